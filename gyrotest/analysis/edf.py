"""Equivalent degrees of freedom of Allan variances, after Greenhall and Riley.

C. A. Greenhall and W. J. Riley, "Uncertainty of stability variances based on finite differences",
35th PTTI, 2003; here for second differences (d = 2) of an unmodified variance (F = m).
"""

import math

import numpy as np
from numpy.typing import NDArray

from gyrotest.analysis.noise_type import NoiseType

_D = 2
_LONGEST_SUM = 100
_LONG = {0: (2 / 3, 1 / 3), -1: (0.852, 0.375), -2: (1.079, 0.368)}  # table 2, d = 2


def allan_edf(
    angle_points: int, averaging_factor: int, noise_type: NoiseType, *, overlapping: bool
) -> float:
    """Degrees of freedom of an Allan variance.

    Parameters
    ----------
    angle_points
        Number of angle points: one more than rate samples.
    averaging_factor
        Rate samples in a group.
    noise_type
        The dominant one at this averaging time.
    overlapping
        Whether groups begin at every sample, or side by side.
    """
    m, alpha = averaging_factor, int(noise_type)
    stride = m if overlapping else 1  # S of the paper: groups begun per averaging time
    count = 1 + (stride * (angle_points - 1 - _D * m)) // m
    r = count / stride
    if alpha == 2 and overlapping:
        return count / _white_angle(r)
    terms = min(count, (_D + 1) * stride)
    if terms <= _LONGEST_SUM:
        ratio = float(m) if m * (_D + 1) <= _LONGEST_SUM or alpha > 0 else math.inf
        return 1.0 / _relative_sum(terms, count, stride, ratio, alpha)
    if r >= _D + 1:
        return _long_record(r, m, alpha)
    shrunk = _LONGEST_SUM / r
    ratio = math.inf if alpha <= 0 else float(m)
    return 1.0 / _relative_sum(_LONGEST_SUM, _LONGEST_SUM, shrunk, ratio, alpha)


def _white_angle(r: float) -> float:
    """Count over degrees of freedom for white angle noise (table 1)."""
    if math.ceil(r) > _D:
        return 35 / 18 - 1 / r
    total = sum((1 - k / r) * math.comb(2 * _D, _D - k) ** 2 for k in range(1, math.ceil(r)))
    return 1 + 2 * total / math.comb(2 * _D, _D) ** 2


def _long_record(r: float, m: int, alpha: int) -> float:
    if alpha == 1:  # table 3
        return r * (15.23 + 12.0 * math.log(m)) ** 2 / (790.0 - 410.0 / r)
    a0, a1 = _LONG[alpha]
    return r / (a0 - a1 / r)


def _relative_sum(terms: int, count: int, stride: float, ratio: float, alpha: int) -> float:
    """Return the basic sum over sz(0)²·M, which is one over the degrees of freedom."""
    j = np.arange(1, terms + 1, dtype=np.float64)
    shape = (_sz(np.concatenate(([0.0], j / stride)), ratio, alpha)) ** 2
    weights = 2.0 * (1.0 - j / count)
    weights[-1] = 1.0 - terms / count
    return float((shape[0] + np.sum(weights * shape[1:])) / (shape[0] * count))


def _sz(t: NDArray[np.float64], ratio: float, alpha: int) -> NDArray[np.float64]:
    """Covariance of the second differences."""
    return (
        6.0 * _sx(t, ratio, alpha)
        - 4.0 * (_sx(t - 1.0, ratio, alpha) + _sx(t + 1.0, ratio, alpha))
        + _sx(t - 2.0, ratio, alpha)
        + _sx(t + 2.0, ratio, alpha)
    )


def _sx(t: NDArray[np.float64], ratio: float, alpha: int) -> NDArray[np.float64]:
    if math.isinf(ratio):
        return _sw(t, alpha + 2)
    step = 1.0 / ratio
    return ratio**2 * (2.0 * _sw(t, alpha) - _sw(t - step, alpha) - _sw(t + step, alpha))


def _sw(t: NDArray[np.float64], alpha: int) -> NDArray[np.float64]:
    """Generalised covariance: |t|^(3 − α), with a logarithm where the power is even."""
    size = np.abs(t)
    if alpha % 2 == 0:
        sign = -1.0 if alpha in (2, -2) else 1.0
        return sign * size ** (3 - alpha)
    sign = -1.0 if alpha == -1 else 1.0
    return sign * size ** (3 - alpha) * np.log(np.where(size > 0.0, size, 1.0))
