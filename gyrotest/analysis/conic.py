"""The least-squares ellipse through points in a plane, by sums over them."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

_CONSTRAINT = np.array([[0.0, 0.0, 0.5], [0.0, -1.0, 0.0], [0.5, 0.0, 0.0]])
"""Inverse of the constraint 4AC − B² in the coefficients of x², xy and y²."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Conic:
    """The ellipse `xx·X² + xy·XY + yy·Y² = 1` in coordinates X, Y from its centre."""

    centre_x: float
    centre_y: float
    xx: float
    xy: float
    yy: float


class ConicSums:
    """Sums over the points that were pushed."""

    def __init__(self) -> None:
        self._origin = np.zeros(2)
        self._sums = np.zeros((6, 6))

    def push(self, x: NDArray[np.float64], y: NDArray[np.float64]) -> None:
        """Take further points, both (n,)."""
        if not self._sums[5, 5]:
            self._origin = np.array([x.mean(), y.mean()])  # keeps the sums' digits
        x, y = x - self._origin[0], y - self._origin[1]
        terms = np.stack((x * x, x * y, y * y, x, y, np.ones_like(x)))
        self._sums += terms @ terms.T

    def fit(self) -> Conic | None:
        """Return the ellipse; None where the points determine none.

        Notes
        -----
        Least squares of the algebraic distance under 4AC − B² = 1, split into its quadratic and linear
        parts (Fitzgibbon, Pilu and Fisher 1999; Halíř and Flusser 1998), in coordinates of which the points
        have mean 0 and variance 1.
        """
        count = self._sums[5, 5]
        if not count:
            return None
        mean = self._sums[3:5, 5] / count
        spread = float(np.sqrt(np.trace(self._sums[3:5, 3:5]) / count - mean @ mean))
        if not spread > 0.0:
            return None
        to_unit = _substitution(mean, spread)
        coefficients = _constrained(to_unit @ self._sums @ to_unit.T)
        return None if coefficients is None else _centred(coefficients, self._origin + mean, spread)


def _substitution(mean: NDArray[np.float64], spread: float) -> NDArray[np.float64]:
    """Return what turns the terms of (x, y) into those of ((x, y) − mean)/spread."""
    mx, my = mean
    return (
        np.array(
            [
                [1.0, 0.0, 0.0, -2.0 * mx, 0.0, mx * mx],
                [0.0, 1.0, 0.0, -my, -mx, mx * my],
                [0.0, 0.0, 1.0, 0.0, -2.0 * my, my * my],
                [0.0, 0.0, 0.0, spread, 0.0, -spread * mx],
                [0.0, 0.0, 0.0, 0.0, spread, -spread * my],
                [0.0, 0.0, 0.0, 0.0, 0.0, spread**2],
            ]
        )
        / spread**2
    )


def _constrained(sums: NDArray[np.float64]) -> NDArray[np.float64] | None:
    """Return the coefficients (6,) of the ellipse, None where there is none."""
    try:
        linear = -np.linalg.solve(sums[3:, 3:], sums[3:, :3])
    except np.linalg.LinAlgError:
        return None
    _, vectors = np.linalg.eig(_CONSTRAINT @ (sums[:3, :3] + sums[:3, 3:] @ linear))
    vectors = vectors.real
    elliptic = np.flatnonzero(4.0 * vectors[0] * vectors[2] - vectors[1] ** 2 > 0.0)
    if elliptic.size != 1:
        return None
    quadratic = vectors[:, elliptic[0]]
    return np.concatenate((quadratic, linear @ quadratic))


def _centred(
    coefficients: NDArray[np.float64], mean: NDArray[np.float64], spread: float
) -> Conic | None:
    xx, xy, yy, x, y, constant = coefficients
    centre = -np.linalg.solve(np.array([[2.0 * xx, xy], [xy, 2.0 * yy]]), np.array([x, y]))
    level = -(constant + (x * centre[0] + y * centre[1]) / 2.0)
    if not level * xx > 0.0:
        return None
    per = 1.0 / (level * spread**2)
    at = mean + spread * centre
    return Conic(
        centre_x=float(at[0]),
        centre_y=float(at[1]),
        xx=float(xx * per),
        xy=float(xy * per),
        yy=float(yy * per),
    )
