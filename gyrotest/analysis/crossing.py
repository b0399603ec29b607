"""Where a measured curve first falls through a level: between two points, never beyond them."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

_Array = NDArray[np.float64]

_ROUNDS = 60
_MANY, _OF_STRAIGHT, _OF_STRAIGHT_OF_FEW = 5, 0.1, 0.5


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
    neighbours; the half-width its greatest difference to the polynomials through one point fewer and through
    one more, and a tenth of that to the straight line (half, where there are fewer than five points). Over
    frequencies that are apart by a fourth of themselves the error at second-order responses with a delay
    is within it in 19 of 20 cases.
    """
    below = np.flatnonzero(y < level)
    if not below.size or below[0] == 0:
        return None
    place = int(below[0]) - 1
    bracket = _Bracket(x=x, y=y, place=place, level=level)
    value = bracket.root(-1, 2)
    others = [bracket.root(*ends) for ends in ((-1, 1), (0, 2), (-2, 2), (-1, 3))]
    share = _OF_STRAIGHT if x.size >= _MANY else _OF_STRAIGHT_OF_FEW
    straight = share * abs(bracket.root(0, 1) - value)
    half_width = max(straight, *(abs(one - value) for one in others))
    if x.size == 2:
        half_width = float(x[1] - x[0]) / 2.0
    return Crossing(
        x=value,
        half_width=float(half_width),
        slope=float((y[place + 1] - y[place]) / (x[place + 1] - x[place])),
        place=place,
    )


@dataclass(frozen=True, slots=True, kw_only=True)
class _Bracket:
    """The points, and between which of them the level is passed."""

    x: _Array
    y: _Array
    place: int
    level: float

    def root(self, begin: int, end: int) -> float:
        """Return where a polynomial passes the level between `place` and the next point.

        It goes through the points from `begin` to `end`, counted from `place`, as far as there are such.
        """
        chosen = slice(max(self.place + begin, 0), self.place + end + 1)
        above, below = float(self.x[self.place]), float(self.x[self.place + 1])
        for _ in range(_ROUNDS):
            middle = (above + below) / 2.0
            if _polynomial(self.x[chosen], self.y[chosen], middle) >= self.level:
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
