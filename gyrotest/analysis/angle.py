"""The angle: the running sum of a rate record, checked first, its offset removed before summing."""

import numpy as np
from numpy.typing import ArrayLike, NDArray

from gyrotest.analysis.kernels.record import STREAMS, running_sum, scan
from gyrotest.errors import InsufficientDataError

BLOCK = 8192
"""Samples worked on at a time: they stay in the cache, and a dot product of them in one thread."""

_SMALLEST, _LARGEST = 1e-140, 1e140  # mean departures whose squares are numbers still
_NUMBERS = "biufO"


def real_samples(samples: ArrayLike) -> NDArray[np.generic]:
    """Return samples as an array of any shape.

    Raises
    ------
    InsufficientDataError
        Samples are masked.
    ValueError
        They are no real numbers: complex, times or text.
    """
    masked = int(np.sum(samples.mask)) if isinstance(samples, np.ma.MaskedArray) else 0
    if masked:
        raise InsufficientDataError(
            f"{masked} of {np.size(samples)} samples are masked; take a part that has all of its samples"
        )
    array = np.asarray(samples)
    if array.dtype.kind not in _NUMBERS:
        raise ValueError(f"samples are real numbers, found {array.dtype}")
    return array


def checked_rate(rate_dps: ArrayLike) -> NDArray[np.float64]:
    """Return the record as a one-dimensional float array.

    Raises
    ------
    InsufficientDataError
        Fewer than two samples, a sample that is not finite (the first is named), or a constant.
    """
    rate = _record(rate_dps)
    _scanned(rate)
    return rate


def angle(rate_dps: ArrayLike) -> NDArray[np.float64]:
    """Check the record, as `checked_rate` does, and sum it up: `n + 1` points beginning at 0, in rate × samples.

    The mean goes first: the sum of a large offset would eat the digits of a small noise, and the
    Allan variance does not see it.
    """
    rate = _record(rate_dps)
    sums = _scanned(rate)
    summed = _at_cache_line(rate.size + 1)
    running_sum(rate, sums, float(rate[0] + sums.sum() / rate.size), summed)
    return summed


def _at_cache_line(size: int) -> NDArray[np.float64]:
    """Return an array that begins where a cache line does: no vector of it is then loaded in two."""
    room = np.empty(size + 7)
    begin = -room.ctypes.data // 8 % 8
    return room[begin : begin + size]


def _record(rate_dps: ArrayLike) -> NDArray[np.float64]:
    rate = np.asarray(real_samples(rate_dps), dtype=np.float64)
    if rate.ndim != 1:
        raise ValueError(f"a rate record has one dimension, found {rate.ndim}")
    if rate.size < 2:
        raise InsufficientDataError(f"the record has {rate.size} samples; at least 2 are needed")
    return np.ascontiguousarray(rate)


def _scanned(rate: NDArray[np.float64]) -> NDArray[np.float64]:
    """Check the samples; returns the sums of the record's parts, less the first sample."""
    found = np.empty(1 + STREAMS)
    scan(rate, found)
    if not np.isfinite(found[0]):
        raise InsufficientDataError(_first_bad(rate))
    if found[0] == 0.0:
        raise InsufficientDataError(
            f"all {rate.size} samples are {rate[0]:.6g}: a constant carries no noise; is the output alive?"
        )
    departure = float(found[0]) / rate.size
    if not _SMALLEST < departure < _LARGEST:
        raise InsufficientDataError(
            f"the samples depart from the first by {departure:.3g} on average: the squares are no numbers any"
            " more; is the unit, or a factor, right?"
        )
    return found[1:]


def _first_bad(rate: NDArray[np.float64]) -> str:
    bad, first = 0, -1
    for begin in range(0, rate.size, BLOCK):
        where = np.flatnonzero(~np.isfinite(rate[begin : begin + BLOCK]))
        if where.size and first < 0:
            first = begin + int(where[0])
        bad += where.size
    if not bad:
        return f"the samples reach {np.abs(rate).max():.6g}: their sum is no number any more"
    return f"sample {first} is {rate[first]} ({bad} of {rate.size} are not finite); a number is needed"
