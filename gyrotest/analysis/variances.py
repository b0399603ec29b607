"""Variances of an angle record at averaging factors: classic, modified, Hadamard, total.

`angle` is the running sum of n rate samples, shape (n + 1,), in rate × samples; `factors` has shape
(k,), so have the results, in the rate's unit squared. Differences are taken of neighbours first:
these are exact in floating point, however far a drift has carried the angle.
"""

from collections.abc import Iterator
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from gyrotest.analysis.angle import BLOCK
from gyrotest.analysis.kernels.chains import overlapping_variances

_Array = NDArray[np.float64]


def classic_variances(angle: _Array, factors: NDArray[np.int64]) -> _Array:
    """1/(2m²(K − 1)) · the same sum over k = 0, m, 2m …, of K = floor(n/m) groups; eq. 7."""
    return np.array([_mean_square(angle[::m], 1, order=2) / (2.0 * m * m) for m in factors.tolist()])


def hadamard_variances(angle: _Array, factors: NDArray[np.int64]) -> _Array:
    """1/(6m²(n − 3m + 1)) · Σ(θ[k+3m] − 3θ[k+2m] + 3θ[k+m] − θ[k])² over all k; eq. 20."""
    return np.array([_mean_square(angle, int(m), order=3) / (6.0 * m * m) for m in factors])


def modified_variances(angle: _Array, factors: NDArray[np.int64]) -> _Array:
    """1/(2m⁴(n − 3m + 2)) · Σ_j (Σ_{k=j}^{j+m−1} θ[k+2m] − 2θ[k+m] + θ[k])²; eq. 14.

    The inner sum goes along with j: its change from j to j + 1 is a third difference.
    """
    return np.array([_modified(angle, int(m)) for m in factors])


def total_variances(angle: _Array, factors: NDArray[np.int64]) -> _Array:
    """1/(2m²(n − 1)) · Σ(θ*[k+m] − 2θ[k] + θ*[k−m])² over k = 1 … n − 1; eq. 25.

    θ* is the angle continued at both ends by its point reflection; that is only looked up, so that
    no longer array is made. Away from the ends the sum is the overlapping one.
    """
    n = angle.size - 1
    inside = overlapping_variances(angle, factors) * (2.0 * factors**2) * (n + 1 - 2 * factors)
    ends = [_reflected(angle, m) + _reflected(angle[::-1], m) for m in factors.tolist()]
    return (inside + ends) / (2.0 * factors**2 * (n - 1))


def _mean_square(angle: _Array, m: int, *, order: int) -> float:
    total = 0.0
    for block in _differences(angle, m, order=order):
        total += float(np.dot(block, block))
    return total / (angle.size - order * m)


def _differences(angle: _Array, m: int, *, order: int) -> Iterator[_Array]:
    """Differences of points m apart, `order` times, a block at a time."""
    count = angle.size - order * m
    for begin in range(0, count, BLOCK):
        end = min(begin + BLOCK, count)
        points = [angle[begin + step * m : end + step * m] for step in range(order + 1)]
        while len(points) > 1:
            points = [later - earlier for earlier, later in pairwise(points)]
        yield points[0]


def _modified(angle: _Array, m: int) -> float:
    inner = sum(float(np.sum(block)) for block in _differences(angle[: 3 * m], m, order=2))
    total, count = inner * inner, angle.size - 3 * m + 1
    for block in _differences(angle, m, order=3):
        sums = np.cumsum(block)
        sums += inner
        inner = float(sums[-1])
        total += float(np.dot(sums, sums))
    return total / (2.0 * float(m) ** 4 * count)


def _reflected(angle: _Array, m: int) -> float:
    """Squares over k = 1 … m − 1, where θ*[k − m] = 2θ[0] − θ[m − k]."""
    total = 0.0
    for begin in range(1, m, BLOCK):
        end = min(begin + BLOCK, m)
        forward = angle[begin + m : end + m] - angle[begin:end]
        back = angle[begin:end] - angle[0] + (angle[m - end + 1 : m - begin + 1][::-1] - angle[0])
        total += float(np.sum((forward - back) ** 2))
    return total
