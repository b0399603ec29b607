"""Curves of long records: few enough points for print that still show every extreme, gaps left open."""

import math

import numpy as np
from numpy.typing import NDArray

from gyrotest.procedures.scale_factor_recorded.outputs import Outputs
from gyrotest.records.figure import Curve, Role

_MOST_STRETCHES = 100


def stretches(
    outputs: Outputs, values: NDArray[np.float64], *, role: Role, most: int
) -> tuple[Curve, ...]:
    """Return a curve for each stretch without a gap; of a record in shreds a single one."""
    time_s = (outputs.place - outputs.place[0]) * outputs.interval_s
    cuts = np.flatnonzero(np.diff(outputs.place) != 1) + 1
    if cuts.size >= _MOST_STRETCHES:
        cuts = cuts[:0]
    curves = []
    for times, part in zip(np.split(time_s, cuts), np.split(values, cuts), strict=True):
        x, y = thinned(times, part, most=max(math.ceil(most * part.size / values.size), 2))
        curves.append(Curve(x=tuple(x.tolist()), y=tuple(y.tolist()), role=role))
    return tuple(curves)


def thinned(
    times_s: NDArray[np.float64], values: NDArray[np.float64], *, most: int
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Keep the least and the greatest of every few samples, in their order; all where they are no more."""
    size = math.ceil(2.0 * values.size / most)
    if size < 3:
        return times_s, values
    kept: list[int] = []
    for begin in range(0, values.size, size):
        part = values[begin : begin + size]
        kept += sorted({begin + int(part.argmin()), begin + int(part.argmax())})
    return times_s[kept], values[kept]
