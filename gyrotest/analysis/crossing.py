"""Where a measured curve first falls through a level: between two points, never beyond them."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

_Array = NDArray[np.float64]

_ROUNDS = 100


@dataclass(frozen=True, slots=True, kw_only=True)
class Crossing:
    """`x` where the curve falls through the level, between the points `place` and `place + 1`.

    `half_width` is by how much ways to interpolate differ, `slope` dy/dx there (below 0).
    """

    x: float
    half_width: float
    slope: float
    place: int


def first_fall(x: _Array, y: _Array, *, level: float) -> Crossing | None:
    """Find where points first fall below a level; None where they do not, or begin below it.

    Parameters
    ----------
    x, y
        Shape (n,), x ascending.
    level
        In the unit of y.

    Notes
    -----
    The value is that of the polynomial through the two points on either side of the level and their
    neighbours; the half-width its greatest difference to the polynomials through one point fewer.
    """
    below = np.flatnonzero(y < level)
    if not below.size or below[0] == 0:
        return None
    place = int(below[0]) - 1
    first, last = max(place - 1, 0), min(place + 2, x.size - 1)
    value = _root(x[first : last + 1], y[first : last + 1], place - first, level)
    fewer = [
        _root(x[begin : end + 1], y[begin : end + 1], place - begin, level)
        for begin, end in ((first, last - 1), (first + 1, last))
        if begin <= place < end
    ]
    half_width = max((abs(one - value) for one in fewer), default=(x[place + 1] - x[place]) / 2.0)
    return Crossing(
        x=value,
        half_width=float(half_width),
        slope=float((y[place + 1] - y[place]) / (x[place + 1] - x[place])),
        place=place,
    )


def _root(x: _Array, y: _Array, place: int, level: float) -> float:
    """Return where the polynomial through points passes the level between `place` and the next one."""
    above, below = float(x[place]), float(x[place + 1])
    for _ in range(_ROUNDS):
        middle = (above + below) / 2.0
        if _polynomial(x, y, middle) >= level:
            above = middle
        else:
            below = middle
    return (above + below) / 2.0


def _polynomial(x: _Array, y: _Array, at: float) -> float:
    """Lagrange's polynomial through all points."""
    total = 0.0
    for place, value in enumerate(y):
        others = np.delete(x, place)
        total += float(value * np.prod((at - others) / (x[place] - others)))
    return total
