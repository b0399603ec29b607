"""Outliers: which samples of a dwell are kept, by a stated window or by a robust rule."""

import numpy as np
from numpy.typing import NDArray

from gyrotest.analysis.resolution import digital_step


def inside_window(values: NDArray[np.float64], *, centre: float, half_width: float) -> NDArray[np.bool_]:
    """Return which samples (n,) lie within a window about a stated value, its ends included.

    Notes
    -----
    S3.2: the source keeps 9 … 11 °/s at 10 °/s. Windows of opposite rates are mirror images.
    """
    kept: NDArray[np.bool_] = np.abs(values - centre) <= half_width
    return kept


def median_deviation(values: NDArray[np.float64]) -> float:
    """Return the median absolute deviation of samples (n,) from their median, as it is.

    Of digitised samples more than half may read the same: it is one of their steps at least.
    """
    away = float(np.median(np.abs(values - np.median(values))))
    return max(away, digital_step(values) or 0.0)


def near_median(
    values: NDArray[np.float64], *, mads: float, least_deviation: float = 0.0
) -> NDArray[np.bool_]:
    """Return which samples (n,) lie within so many median absolute deviations of their median.

    Parameters
    ----------
    values
        Shape (n,), any unit.
    mads
        Of the median absolute deviation as it is, which of normal noise is 0.6745 σ: 7.5 of them are 5 σ.
    least_deviation
        What the deviation is at least, from more samples of the same noise: that of a few dozen may by
        chance be half of what it should.
    """
    deviation = max(median_deviation(values), least_deviation)
    kept: NDArray[np.bool_] = np.abs(values - np.median(values)) <= mads * deviation
    return kept
