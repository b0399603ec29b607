"""How far a drift spreads about its mean, and how well its standard deviation is known among wandering noise."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gyrotest.analysis.interval import deviation_bounds

_Array = NDArray[np.float64]
_FEWEST_FREEDOM = 1.0


@dataclass(frozen=True, slots=True, kw_only=True)
class Spread:
    """The sample standard deviation of `count` averages, its degrees of freedom and its 95 % interval."""

    deviation: float
    degrees_of_freedom: float
    lower_95: float
    upper_95: float
    count: int


def averages(values: _Array, groups: NDArray[np.intp]) -> _Array:
    """Return the means of values (m,) that belong to one group each; `groups` (m,) does not fall."""
    return np.bincount(groups, weights=values) / np.bincount(groups)


def spread(values: _Array, groups: NDArray[np.intp], noise_covariance: _Array) -> Spread:
    """Return the standard deviation of averages over groups of values, about their mean.

    Parameters
    ----------
    values
        Shape (m,): what spreads, its course and noise together.
    groups
        Shape (m,): the number of the group that each belongs to, from 0 on, not falling.
    noise_covariance
        Shape (m, m): of the values' noise.

    Notes
    -----
    With s² = xᵀPx/(n − 1), P the centring, and x = µ + noise of covariance C, the variance of s² is
    (2·tr(PCPC) + 4·µᵀPCPµ)/(n − 1)²; so s has 2s⁴/Var(s²) degrees of freedom, which give its interval.
    """
    means = averages(values, groups)
    count = means.size
    gather = np.zeros((count, values.size))
    gather[groups, np.arange(values.size)] = 1.0
    gather /= gather.sum(axis=1, keepdims=True)
    noise = gather @ noise_covariance @ gather.T
    noise -= noise.mean(axis=0)
    noise = noise - noise.mean(axis=1, keepdims=True)
    away = means - means.mean()
    square = float(away @ away) / (count - 1)
    by_noise = float(np.trace(noise)) / (count - 1)
    # Of the course only what is beyond the noise.
    course = max(1.0 - by_noise / square, 0.0) if square > 0.0 else 0.0
    variance = 2.0 * float(np.sum(noise * noise.T)) + 4.0 * course * float(away @ noise @ away)
    variance /= (count - 1) ** 2
    freedom = max(2.0 * square**2 / variance, _FEWEST_FREEDOM) if variance > 0.0 else float(count - 1)
    bounds = deviation_bounds(np.sqrt(square), freedom, confidence=0.95)
    return Spread(
        deviation=float(np.sqrt(square)),
        degrees_of_freedom=freedom,
        lower_95=float(bounds.lower),
        upper_95=float(bounds.upper),
        count=count,
    )
