"""The rule by which a dwell's samples are outliers, as a case may state it."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gyrotest.analysis.outliers import inside_window, near_median
from gyrotest.procedures.wording import plain
from gyrotest.units import Dimension, Quantity, same_dimension


@dataclass(frozen=True, slots=True, kw_only=True)
class OutlierRule:
    """Which samples of a dwell count: within `window` of its rate (of it, or in °/s), else near their median.

    A window in proportion to the rate says nothing of a dwell at rest; there the median serves.
    """

    window: Quantity | None = None
    mads: float = 7.5

    def kept(
        self, rate_dps: NDArray[np.float64], demanded_dps: float | None, *, usual_dps: float = 0.0
    ) -> NDArray[np.bool_]:
        """Return which samples (n,) are kept; `usual_dps`: the median absolute deviation of all dwells."""
        half_dps = self.half_width_dps(demanded_dps)
        if half_dps is None or demanded_dps is None:
            return near_median(rate_dps, mads=self.mads, least_deviation=usual_dps)
        return inside_window(rate_dps, centre=demanded_dps, half_width=half_dps)

    def half_width_dps(self, demanded_dps: float | None) -> float | None:
        """Return the window's half-width, °/s; None where the median serves."""
        if self.window is None or demanded_dps is None:
            return None
        if same_dimension(self.window.unit, Dimension.RATE):
            return self.window.to("deg/s")
        return self.window.to("") * abs(demanded_dps) or None

    def spoken(self, demanded_dps: float | None) -> str:
        """Return the rule in words."""
        half_dps = self.half_width_dps(demanded_dps)
        if half_dps is None:
            return f"within {self.mads:g} median absolute deviations of the median"
        return f"within {plain(half_dps, 4)} °/s of the rate"
