"""The angle: the running sum of a rate record, checked first, its offset removed before summing."""

import numpy as np
from numpy.typing import ArrayLike, NDArray

from gyrotest.errors import InsufficientDataError

BLOCK = 8192
"""Samples worked on at a time: they stay in the cache, and a dot product of them in one thread."""


def checked_rate(rate_dps: ArrayLike) -> NDArray[np.float64]:
    """Return the record as a one-dimensional float array.

    Raises
    ------
    InsufficientDataError
        Fewer than two samples, a sample that is not finite (the first is named), or a constant.
    """
    rate = np.asarray(rate_dps, dtype=np.float64)
    if rate.ndim != 1:
        raise ValueError(f"a rate record has one dimension, found {rate.ndim}")
    if rate.size < 2:
        raise InsufficientDataError(f"the record has {rate.size} samples; at least 2 are needed")
    lowest, highest = float(rate.min()), float(rate.max())
    if not (np.isfinite(lowest) and np.isfinite(highest)):
        raise InsufficientDataError(_first_bad(rate))
    if lowest == highest:
        raise InsufficientDataError(
            f"all {rate.size} samples are {lowest:.6g}: a constant carries no noise; is the output alive?"
        )
    return rate


def _first_bad(rate: NDArray[np.float64]) -> str:
    bad, first = 0, -1
    for begin in range(0, rate.size, BLOCK):
        where = np.flatnonzero(~np.isfinite(rate[begin : begin + BLOCK]))
        if where.size and first < 0:
            first = begin + int(where[0])
        bad += where.size
    return f"sample {first} is {rate[first]} ({bad} of {rate.size} are not finite); a number is needed"


def angle(rate: NDArray[np.float64]) -> NDArray[np.float64]:
    """Sum up the record less its mean: `n + 1` points beginning at 0, in rate × samples.

    The mean goes first: the sum of a large offset would eat the digits of a small noise, and the
    Allan variance does not see it.
    """
    summed = np.empty(rate.size + 1)
    summed[0] = 0.0
    np.subtract(rate, rate.mean(), out=summed[1:])
    np.cumsum(summed[1:], out=summed[1:])
    return summed
