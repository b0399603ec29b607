"""Leaps from sample to sample that are no noise: a spike, a fault of the recording, a gyro that was moved."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

_TIMES = 20.0  # the usual step: noise of any size of record stays below half of it
_BLOCK = 1 << 16
_USUAL_OVER = 100_000
_MEDIAN_TO_SIGMA = 1.4826  # of normally distributed steps


@dataclass(frozen=True, slots=True, kw_only=True)
class Leap:
    """The largest step between neighbours: to sample `at` (from 0), `size`, and how often the usual one."""

    at: int
    size: float
    times_usual: float


def largest_leap(values: NDArray[np.float64]) -> Leap | None:
    """Return the largest step of a record, shape (n,), where it is far above the usual; None elsewhere.

    The usual step is the standard deviation of steps by their median magnitude, so that the leap itself
    does not count. Where most steps are 0, as with coarse rounding, nothing can be told.
    """
    usual = _usual_step(values)
    if usual == 0.0:
        return None
    at, size = 0, 0.0
    for begin in range(0, values.size - 1, _BLOCK):
        steps = np.abs(np.diff(values[begin : begin + _BLOCK + 1]))
        place = int(steps.argmax())
        if steps[place] > size:
            at, size = begin + place + 1, float(steps[place])
    if size < _TIMES * usual:
        return None
    return Leap(at=at, size=size, times_usual=size / usual)


def _usual_step(values: NDArray[np.float64]) -> float:
    apart = max((values.size - 1) // _USUAL_OVER, 1)
    before, after = values[:-1:apart], values[1::apart]
    return _MEDIAN_TO_SIGMA * float(np.median(np.abs(after - before)))
