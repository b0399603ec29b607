"""Allan deviation of a rate record, overlapping and classic, with chi-square intervals."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from gyrotest.analysis.angle import BLOCK, angle, checked_rate
from gyrotest.analysis.edf import allan_edf
from gyrotest.analysis.interval import ONE_SIGMA, Bounds, deviation_bounds
from gyrotest.analysis.noise_type import NoiseType, noise_types
from gyrotest.errors import InsufficientDataError

GROUPS = 9
"""Independent groups that the longest default averaging time leaves."""

FLAT = 0.6642824702679600
"""Allan deviation of flicker noise over its coefficient: sqrt(2 ln 2 / π), IEEE 952."""


@dataclass(frozen=True, slots=True, kw_only=True)
class AllanDeviation:
    """An Allan deviation curve; every array has shape (k,), one entry an averaging time.

    `lower_dps` and `upper_dps` are the 68.3 % chi-square bounds; `noise_type` rules the degrees of
    freedom `edf`.
    """

    averaging_factor: NDArray[np.int64]
    tau_s: NDArray[np.float64]
    deviation_dps: NDArray[np.float64]
    n_differences: NDArray[np.int64]
    edf: NDArray[np.float64]
    lower_dps: NDArray[np.float64]
    upper_dps: NDArray[np.float64]
    noise_type: tuple[NoiseType, ...]

    def at(self, averaging_factors: NDArray[np.int64]) -> "AllanDeviation":
        """Take the curve at some of its averaging factors only."""
        chosen = np.flatnonzero(np.isin(self.averaging_factor, averaging_factors))
        return AllanDeviation(
            averaging_factor=self.averaging_factor[chosen],
            tau_s=self.tau_s[chosen],
            deviation_dps=self.deviation_dps[chosen],
            n_differences=self.n_differences[chosen],
            edf=self.edf[chosen],
            lower_dps=self.lower_dps[chosen],
            upper_dps=self.upper_dps[chosen],
            noise_type=tuple(self.noise_type[int(place)] for place in chosen),
        )

    def bounds_dps(self, confidence: float = 0.95) -> Bounds:
        """Return chi-square bounds at another confidence."""
        return deviation_bounds(self.deviation_dps, self.edf, confidence=confidence)


def overlapping_allan_deviation(
    rate_dps: ArrayLike, *, sample_rate_hz: float, averaging_factors: Sequence[int] | None = None
) -> AllanDeviation:
    """Overlapping Allan deviation.

    Parameters
    ----------
    rate_dps
        Shape (n,): rate samples, evenly spaced, °/s.
    sample_rate_hz
        Samples a second.
    averaging_factors
        Samples in a group; by default ten a decade, from 1 to floor(n/9).

    Returns
    -------
    AllanDeviation

    Raises
    ------
    InsufficientDataError
        Too few samples for the factors, a sample that is not finite, or a constant record.

    Notes
    -----
    NIST SP 1065 eq. 11; IEEE 952 Annex C.
    """
    rate = checked_rate(rate_dps)
    factors = _checked_factors(rate.size, averaging_factors)
    theta = angle(rate)
    variances = np.array([_overlapping_variance(theta, int(m)) for m in factors])
    return _with_intervals(theta, factors, variances, sample_rate_hz, overlapping=True)


def allan_deviation(
    rate_dps: ArrayLike, *, sample_rate_hz: float, averaging_factors: Sequence[int] | None = None
) -> AllanDeviation:
    """Classic Allan deviation, of groups side by side.

    Parameters, return value and errors as of `overlapping_allan_deviation`. Over K = floor(n/m)
    group means the sum of squared differences is divided by 2(K − 1); a tail shorter than a group
    is dropped.

    Notes
    -----
    NIST SP 1065 eq. 8.
    """
    rate = checked_rate(rate_dps)
    factors = _checked_factors(rate.size, averaging_factors)
    theta = angle(rate)
    variances = np.array([_classic_variance(theta, int(m)) for m in factors])
    return _with_intervals(theta, factors, variances, sample_rate_hz, overlapping=False)


def default_factors(samples: int) -> NDArray[np.int64]:
    """Return averaging factors, ten a decade, from 1 to floor(samples/9); raises `InsufficientDataError`."""
    if samples < GROUPS:
        raise InsufficientDataError(
            f"the record has {samples} samples; an Allan deviation needs at least {GROUPS} groups"
        )
    return log_spaced_factors(samples // GROUPS, per_decade=10)


def log_spaced_factors(longest: int, *, per_decade: int) -> NDArray[np.int64]:
    """Return whole numbers from 1 to `longest`, both included, evenly spaced in their logarithm."""
    steps = int(np.floor(np.log10(longest) * per_decade + 1e-9))
    spaced = np.rint(10.0 ** (np.arange(steps + 1) / per_decade)).astype(np.int64)
    return np.unique(np.append(spaced[spaced <= longest], longest))


def _checked_factors(samples: int, factors: Sequence[int] | None) -> NDArray[np.int64]:
    if factors is None:
        return default_factors(samples)
    wanted = np.unique(np.asarray(factors, dtype=np.int64))
    if wanted.size == 0 or wanted[0] < 1:
        raise ValueError("averaging factors are positive whole numbers")
    if 2 * wanted[-1] > samples:
        raise InsufficientDataError(
            f"averaging {wanted[-1]} samples needs at least {2 * wanted[-1]}; the record has {samples}"
        )
    return wanted


def _overlapping_variance(theta: NDArray[np.float64], m: int) -> float:
    """1/(2m²(n − 2m + 1)) · Σ(θ[k+2m] − 2θ[k+m] + θ[k])², block by block."""
    count = theta.size - 2 * m
    scratch = np.empty(min(BLOCK, count))
    total = 0.0
    for begin in range(0, count, BLOCK):
        end = min(begin + BLOCK, count)
        second = scratch[: end - begin]
        np.subtract(theta[begin + 2 * m : end + 2 * m], theta[begin + m : end + m], out=second)
        second -= theta[begin + m : end + m]
        second += theta[begin:end]
        total += float(np.dot(second, second))
    return total / (2.0 * m * m * count)


def _classic_variance(theta: NDArray[np.float64], m: int) -> float:
    groups = (theta.size - 1) // m
    corners = theta[: groups * m + 1 : m]
    total = 0.0
    for begin in range(0, groups - 1, BLOCK):
        second = np.diff(corners[begin : min(begin + BLOCK, groups - 1) + 2], n=2)
        total += float(np.dot(second, second))
    return total / (2.0 * m * m * (groups - 1))


def _with_intervals(
    theta: NDArray[np.float64],
    factors: NDArray[np.int64],
    variances: NDArray[np.float64],
    sample_rate_hz: float,
    *,
    overlapping: bool,
) -> AllanDeviation:
    types = noise_types(theta, factors)
    edf = np.array(
        [
            allan_edf(theta.size, int(m), kind, overlapping=overlapping)
            for m, kind in zip(factors, types, strict=True)
        ]
    )
    deviation = np.sqrt(variances)
    bounds = deviation_bounds(deviation, edf, confidence=ONE_SIGMA)
    count = theta.size - 2 * factors if overlapping else (theta.size - 1) // factors - 1
    arrays = (factors, factors / sample_rate_hz, deviation, count, edf, bounds.lower, bounds.upper)
    for array in arrays:
        array.setflags(write=False)
    return AllanDeviation(
        averaging_factor=arrays[0],
        tau_s=arrays[1],
        deviation_dps=arrays[2],
        n_differences=arrays[3],
        edf=arrays[4],
        lower_dps=arrays[5],
        upper_dps=arrays[6],
        noise_type=types,
    )
