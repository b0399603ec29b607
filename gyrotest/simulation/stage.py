"""A simulated stage with a level shaft: how it truly lies, and how a unit's axes sit on it.

Its rotations are not those of `gyrotest.analysis.mounting`, which are held against them.
"""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gyrotest.records.plan import Placement
from gyrotest.records.station import Shaft, Site
from gyrotest.simulation.carriage import (
    ONLY_AXIS,
    Carriage,
    Direction,
    carriage,
    cross,
    heading_deg,
    own_name,
)
from gyrotest.simulation.streams import generator

_PLACES = {"x": 0, "y": 1, "z": 2}
# An axis nearer than this to the shaft's cannot lean towards it.
_LEAST_ACROSS = 1e-6

_Axes = NDArray[np.float64]


@dataclass(frozen=True, slots=True, kw_only=True)
class ShaftErrors:
    """By how much a shaft lies otherwise than its station states, °."""

    azimuth_deg: float = 0.0
    tilt_deg: float = 0.0
    index_deg: float = 0.0

    def truth(self) -> dict[str, float]:
        """The errors, for the record."""
        return {
            "shaft_azimuth_error_deg": self.azimuth_deg,
            "shaft_tilt_error_deg": self.tilt_deg,
            "shaft_index_error_deg": self.index_deg,
        }


def shaft_errors(shaft: Shaft, *, seed: int, serial_number: str, stage: str) -> ShaftErrors:
    """Draw the errors within the station's half-widths, the same for every record of a unit."""
    azimuth, tilt, index = generator(seed, "shaft errors", serial_number, stage).uniform(-1.0, 1.0, 3)
    return ShaftErrors(
        azimuth_deg=float(azimuth) * shaft.azimuth_uncertainty.to("deg"),
        tilt_deg=float(tilt) * shaft.tilt_uncertainty.to("deg"),
        index_deg=float(index) * shaft.index_uncertainty.to("deg"),
    )


def stage_axes(shaft: Shaft, errors: ShaftErrors, site: Site | None) -> _Axes:
    """The stage's x, y and z at the angle 0, rows of (up, north, east) of the bench.

    y is the shaft. An index error has turned the stage already at the angle 0.
    """
    stated_deg = shaft.azimuth.to("deg") if shaft.azimuth is not None else 0.0
    azimuth = math.radians(stated_deg + errors.azimuth_deg - heading_deg(site))
    x = np.array([0.0, math.cos(azimuth), math.sin(azimuth)])
    up = np.array([1.0, 0.0, 0.0])
    tilt = math.radians(shaft.tilt.to("deg") + errors.tilt_deg)
    level = cross(up, x)
    y = math.cos(tilt) * level + math.sin(tilt) * up
    z = cross(x, y)
    index = math.radians(errors.index_deg)
    return np.array([turned(x, y, index), y, turned(z, y, index)])


def stage_carriages(
    axes: Sequence[str],
    stage: _Axes,
    *,
    frame: Mapping[str, str],
    placement: Placement | None,
    site: Site | None,
    misalignment_deg: Callable[[str], float],
) -> tuple[Carriage, ...]:
    """How each axis of a unit sits on a stage, whose axes are those of `stage_axes`.

    A gyro of a single axis senses the one that the placement names. Each sensitive axis leans towards the
    shaft by its misalignment; the unit's own axes, along which gravity acts on its drift, do not.
    """
    mounted = _mounted(frame, placement) @ stage
    own = {name: mounted[place] for name, place in _PLACES.items()}
    single = placement.sensitive_axis if placement is not None else ONLY_AXIS
    return tuple(
        carriage(
            _leaning(own[own_name(axis) if axis else single], stage[1], misalignment_deg(axis)),
            stage[1],
            site=site,
            own=own,
            staged=True,
        )
        for axis in axes
    )


def _mounted(frame: Mapping[str, str], placement: Placement | None) -> _Axes:
    """The unit's own x, y and z along the stage's."""
    own = np.array([_signed(frame[name]) for name in _PLACES])
    if placement is None:
        return own
    about = own[_PLACES[placement.sensitive_axis]]
    angle = math.radians(placement.turned_deg)
    # The stage's own axes are right-handed in their order.
    return np.array(
        [
            each * math.cos(angle)
            + np.cross(about, each) * math.sin(angle)
            + about * (about @ each) * (1.0 - math.cos(angle))
            for each in own
        ]
    )


def _signed(name: str) -> Direction:
    sign = -1.0 if name.startswith("-") else 1.0
    return np.asarray(sign * np.eye(3)[_PLACES[name.removeprefix("-")]])


def _leaning(axis: Direction, shaft: Direction, angle_deg: float) -> Direction:
    """An axis turned towards the shaft; one along the shaft stays."""
    across = axis - (axis @ shaft) * shaft
    length = float(np.linalg.norm(across))
    if length < _LEAST_ACROSS:
        return axis
    angle = math.radians(angle_deg)
    # The rotation about the normal of both, by its effect on the axis itself.
    normal = cross(axis, shaft) / length
    return np.asarray(axis * math.cos(angle) + cross(normal, axis) * math.sin(angle))


def turned(axis: Direction, about: Direction, angle_rad: float) -> Direction:
    """An axis turned right-handed about another one that it is perpendicular to."""
    return np.asarray(axis * math.cos(angle_rad) + cross(about, axis) * math.sin(angle_rad))
