"""Equivalent degrees of freedom of Allan variances, after Greenhall and Riley.

C. A. Greenhall and W. J. Riley, "Uncertainty of stability variances based on finite differences",
35th PTTI, 2003. The paper's sums over the correlation of overlapping differences are worked out up to
256 terms; a longer one is taken as the integral that it approaches, so that no fitted table is needed.
"""

import math
from dataclasses import dataclass
from enum import Enum
from functools import lru_cache

import numpy as np
from numpy.typing import ArrayLike, NDArray

from gyrotest.analysis.noise_type import NoiseType

_Array = NDArray[np.float64]

_LONGEST_SUM = 256
_FINITE = 100
_NODES = 48
_FAR = 1000.0
_TOTAL = {
    0: (1.50, 0.0),
    -1: (1.17, 0.22),
    -2: (0.93, 0.36),
}  # b and c of b·T/τ − c; NIST SP 1065, table 7
_REFLECTED = 2.25  # what the published line for angle random walk is above the overlapping variance's


class Variance(Enum):
    """What is averaged; the value is the order of its differences of the angle."""

    ALLAN = "allan"
    MODIFIED = "modified"
    HADAMARD = "hadamard"
    TOTAL = "total"

    @property
    def order(self) -> int:
        """Order of the differences of the angle."""
        return 3 if self is Variance.HADAMARD else 2


def allan_edf(
    angle_points: int,
    averaging_factor: ArrayLike,
    noise_type: ArrayLike,
    *,
    variance: Variance = Variance.ALLAN,
    strides: ArrayLike | None = None,
) -> NDArray[np.float64]:
    """Degrees of freedom of Allan variances.

    Parameters
    ----------
    angle_points
        Number of angle points: one more than rate samples.
    averaging_factor
        Shape (k,): rate samples in a group.
    noise_type
        Shape (..., k), values of `NoiseType`: the dominant one at each averaging time.
    variance
        The estimator.
    strides
        Shape (k,): differences taken an averaging time, any number from 1 (side by side) to
        `averaging_factor` (one at each sample, the default). A total variance is taken at each.

    Returns
    -------
    ndarray
        Shape (..., k).

    Raises
    ------
    ValueError
        No difference of that averaging factor fits among the points.

    Notes
    -----
    As in the paper (and in Stable32) each angle point is the mean over a sample interval. Where it is
    the angle at an instant, as the sum of rates averaged over their intervals is, angle random walk
    leaves 15 % fewer at a factor of 1 and up to 10 % more at 4 to 8; from 16 on it hardly matters.

    Total variance: the line b·T/τ − c of NIST SP 1065 for angle random walk, bias instability and rate
    random walk. It is too high at short averaging times, where at most 2¼ degrees above the
    overlapping Allan variance's are allowed. White and flicker angle noise, for which none is
    published, have more: there the one for angle random walk is a prudent stand-in.
    """
    factors = np.asarray(averaging_factor, dtype=np.int64)
    begun = factors if strides is None else np.asarray(strides)
    m, alpha, s = np.broadcast_arrays(factors, np.asarray(noise_type), begun)
    found = [
        _edf(angle_points, int(one), int(kind), float(stride), variance)
        for one, kind, stride in zip(m.flat, alpha.flat, s.flat, strict=True)
    ]
    return np.array(found, dtype=np.float64).reshape(m.shape)


@dataclass(frozen=True, slots=True, kw_only=True)
class _Differences:
    """Differences of some order of an angle with a noise's exponent; F of the paper is `ratio`."""

    order: int
    alpha: int
    ratio: float

    def covariance(self, t: _Array) -> _Array:
        """Compute sz: of differences t averaging times apart."""
        d = self.order
        total = np.zeros_like(t)
        for k in range(-d, d + 1):
            total += (-1) ** k * math.comb(2 * d, d + k) * self._angle(t + k)
        return total

    def _angle(self, t: _Array) -> _Array:
        """Compute sx: of the angle."""
        if math.isinf(self.ratio):
            return _generalised(t, self.alpha + 2)
        step = 1.0 / self.ratio
        sides = _generalised(t - step, self.alpha) + _generalised(t + step, self.alpha)
        near: _Array = self.ratio**2 * (2.0 * _generalised(t, self.alpha) - sides)
        if self.alpha != NoiseType.ANGLE_FLICKER:
            return near
        far = np.abs(t) > _FAR * step  # the difference of near equals would lose all digits
        return np.where(far, -2.0 * np.log(np.where(far, np.abs(t), 1.0)) - 3.0, near)


def _edf(points: int, m: int, alpha: int, strides: float, variance: Variance) -> float:
    if variance is Variance.TOTAL:
        return _total(points, m, alpha)
    order, modified = variance.order, variance is Variance.MODIFIED
    span = (m if modified else 1) + order * m  # L of the paper
    count = 1 + math.floor(strides * (points - span) / m + 1e-9)  # M
    if count < 1:
        raise ValueError(f"averaging factor {m} needs {span} angle points, there are {points}")
    terms = min(count, math.floor((order + 1) * strides))  # J
    smooth = alpha <= 0 and m * (order + 1) > _FINITE
    ratio = 1.0 if modified else math.inf if smooth else float(m)
    differences = _Differences(order=order, alpha=alpha, ratio=ratio)
    if terms <= _LONGEST_SUM:
        sums = _correlation_sums(differences, terms, strides)
        return count / (1.0 + sums.squares - sums.moments / count)
    if alpha == NoiseType.QUANTIZATION and not modified:
        return count / _white_angle(count / strides, order)
    r = count / strides
    sums = _correlation_integrals(differences, min(r, order + 1.0))
    return r / (sums.squares - sums.moments / r)


def _total(points: int, m: int, alpha: int) -> float:
    factor, loss = _TOTAL[min(alpha, 0)]
    published = factor * (points - 1) / m - loss
    return min(published, _edf(points, m, alpha, float(m), Variance.ALLAN) + _REFLECTED)


@dataclass(frozen=True, slots=True, kw_only=True)
class _Sums:
    """Of c² and of t·c², c the correlation of differences t apart, t of both signs."""

    squares: float
    moments: float


@lru_cache(maxsize=512)
def _correlation_sums(differences: _Differences, terms: int, strides: float) -> _Sums:
    """Sum over differences j = 1 … J apart, the last one half; t is in differences."""
    j = np.arange(terms + 1, dtype=np.float64)
    shape = differences.covariance(j / strides)
    squares = 2.0 * (shape / shape[0]) ** 2
    squares[-1] /= 2.0
    return _Sums(squares=float(np.sum(squares[1:])), moments=float(np.sum((j * squares)[1:])))


@lru_cache(maxsize=512)
def _correlation_integrals(differences: _Differences, end: float) -> _Sums:
    """Integrate from 0 to `end`; t is in averaging times.

    At whole averaging times the correlation has kinks or logarithms: midpoints crowd towards them.
    """
    u = (np.arange(_NODES) + 0.5) / _NODES
    place, weight = u**3 * (10.0 - 15.0 * u + 6.0 * u**2), 30.0 * (u * (1.0 - u)) ** 2 / _NODES
    begin = np.arange(math.ceil(end), dtype=np.float64)[:, np.newaxis]
    length = np.minimum(end - begin, 1.0)
    t = begin + length * place
    at_zero = differences.covariance(np.zeros(1))
    squares = 2.0 * length * weight * (differences.covariance(t) / at_zero) ** 2
    return _Sums(squares=float(np.sum(squares)), moments=float(np.sum(t * squares)))


def _white_angle(r: float, order: int) -> float:
    """The sum for white angle noise: differences are related at whole averaging times only."""
    related = range(1, min(order, math.ceil(r) - 1) + 1)
    most = math.comb(2 * order, order)
    total = sum((1 - k / r) * (math.comb(2 * order, order - k) / most) ** 2 for k in related)
    return 1 + 2 * total


def _generalised(t: _Array, alpha: int) -> _Array:
    """Compute sw: |t|^(3 − α), with a logarithm where the power is even."""
    size = np.abs(t)
    sign = 1.0 if alpha in (1, 0) else -1.0
    if alpha % 2 == 0:
        return sign * size ** (3 - alpha)
    return sign * size ** (3 - alpha) * np.log(np.where(size > 0.0, size, 1.0))
