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


def near_median(values: NDArray[np.float64], *, mads: float) -> NDArray[np.bool_]:
    """Return which samples (n,) lie within so many median absolute deviations of their median.

    Parameters
    ----------
    values
        Shape (n,), any unit.
    mads
        Of the median absolute deviation as it is, which of normal noise is 0.6745 σ: 7.5 of them are 5 σ.

    Notes
    -----
    Of digitised samples more than half may read the same, and their median absolute deviation be 0: it
    counts as one step at least. Where all samples are the same, all are kept.
    """
    middle = float(np.median(values))
    away = np.abs(values - middle)
    step = digital_step(values) or 0.0
    kept: NDArray[np.bool_] = away <= mads * max(float(np.median(away)), step)
    return kept
