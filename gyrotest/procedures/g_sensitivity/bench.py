"""How the unit lies on the shaft and how the shaft lies: from what the station states, nothing assumed."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gyrotest.analysis.g_sensitivity import ShaftModel
from gyrotest.analysis.level_shaft import ShaftPose
from gyrotest.analysis.mounting import AXES, SHAFT, own_axes
from gyrotest.errors import InsufficientDataError
from gyrotest.records.plan import Context, Placement
from gyrotest.records.station import Shaft

_ALONG = 0.5
_SIGNS = {True: "", False: "\N{MINUS SIGN}"}


@dataclass(frozen=True, slots=True, kw_only=True)
class Mounted:
    """A unit on a shaft: its own axes in the stage's (3, 3), and the place of the sensitive one."""

    axes: NDArray[np.float64]
    sensitive: int
    placement: Placement
    shaft: Shaft
    pose: ShaftPose

    @property
    def model(self) -> ShaftModel:
        """What its output follows."""
        return ShaftModel(pose=self.pose, sensitive=self.axes[self.sensitive])

    @property
    def along(self) -> int:
        """Place of the own axis along the shaft, whose coefficient this mounting does not show."""
        return int(np.abs(self.axes[:, SHAFT]).argmax())

    @property
    def across(self) -> tuple[int, ...]:
        """Places of the own axes across the shaft, whose coefficients it shows."""
        return tuple(place for place in range(len(AXES)) if place != self.along)

    @property
    def shaft_sign(self) -> float:
        """Whether the own axis along the shaft points as the shaft does (1) or against it (−1)."""
        return 1.0 if self.axes[self.along, SHAFT] > 0.0 else -1.0

    @property
    def words(self) -> str:
        """How it is mounted."""
        turned = f"{self.placement.turned_deg:g}°".replace("-", "\N{MINUS SIGN}")
        return f"turned by {turned}: {_SIGNS[self.shaft_sign > 0.0]}{AXES[self.along]} along the shaft"


def mounted(context: Context, placement: Placement) -> Mounted:
    """Return how a unit lies; raises `InsufficientDataError` where the station does not tell."""
    axes = own_axes(context.frame, placement.sensitive_axis, placement.turned_deg)
    found = Mounted(
        axes=axes,
        sensitive=AXES.index(placement.sensitive_axis),
        placement=placement,
        shaft=_shaft(context),
        pose=shaft_pose(context),
    )
    if abs(axes[found.sensitive, SHAFT]) > _ALONG:
        raise InsufficientDataError(
            f"{context.case_name}: by the slot's 'frame' the sensitive axis {placement.sensitive_axis} lies along"
            " the shaft, about which everything turns; it must lie across it: correct the frame, or"
            " 'parameters.sensitive_axis'"
        )
    return found


def shaft_pose(context: Context) -> ShaftPose:
    """Return how the shaft lies; raises `InsufficientDataError` where latitude or azimuth is not known."""
    shaft, site = _shaft(context), context.site
    lacking = []
    if site is None:
        lacking.append("the latitude (the station's 'site.latitude')")
    if shaft.azimuth is None:
        lacking.append("the azimuth of the stage's x axis at angle 0 (its 'shaft.azimuth')")
    if site is None or shaft.azimuth is None:
        raise InsufficientDataError(
            f"{context.case_name}: {' and '.join(lacking)} {'is' if len(lacking) == 1 else 'are'} not known; the"
            " Earth's rate has the shape of gravity over the angle, and left in it would be taken for up to 15 °/h"
            " a g: state it in the station"
        )
    return ShaftPose(
        latitude_deg=site.latitude.to("deg"),
        azimuth_deg=shaft.azimuth.to("deg"),
        tilt_deg=shaft.tilt.to("deg"),
    )


def _shaft(context: Context) -> Shaft:
    if context.shaft is None:
        raise InsufficientDataError(
            f"{context.case_name}: the slot is on no stage with a level shaft; give the slot a 'table', and that a"
            " 'shaft' with its azimuth"
        )
    return context.shaft
