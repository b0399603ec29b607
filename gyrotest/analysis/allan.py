"""Allan deviation of rate records and its family, with chi-square intervals."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from gyrotest.analysis.accumulator import AllanAccumulator
from gyrotest.analysis.angle import angle, real_samples
from gyrotest.analysis.curve import (
    AllanDeviation,
    bounded_curve,
    checked_factors,
    checked_sample_rate,
    default_factors,
    log_spaced_factors,
)
from gyrotest.analysis.edf import Variance, allan_edf
from gyrotest.analysis.kernels.chains import overlapping_variances
from gyrotest.analysis.kernels.lag import SHORTEST
from gyrotest.analysis.noise_type import noise_types
from gyrotest.analysis.variances import (
    classic_variances,
    hadamard_variances,
    modified_variances,
    total_variances,
)
from gyrotest.errors import InsufficientDataError

__all__ = [
    "FLAT",
    "AllanAccumulator",
    "AllanDeviation",
    "allan_deviation",
    "default_factors",
    "hadamard_deviation",
    "log_spaced_factors",
    "modified_allan_deviation",
    "overlapping_allan_deviation",
    "total_deviation",
]

FLAT = 0.6642824702679600
"""Allan deviation of flicker noise over its coefficient: sqrt(2 ln 2 / π), IEEE 952."""

_Factors = NDArray[np.int64]


def overlapping_allan_deviation(
    rate_dps: ArrayLike, *, sample_rate_hz: float, averaging_factors: Sequence[int] | None = None
) -> AllanDeviation:
    """Overlapping Allan deviation.

    Parameters
    ----------
    rate_dps
        Shape (..., n): rate samples, evenly spaced, °/s; leading axes for several gyro axes.
    sample_rate_hz
        Samples a second.
    averaging_factors
        Samples in a group, positive whole numbers; by default ten a decade, from 1 to floor(n/9).

    Returns
    -------
    AllanDeviation
        With the record's leading axes; averaging factors ascending, each once.

    Raises
    ------
    InsufficientDataError
        Too few samples for the factors, samples that are masked or not finite, or a constant record;
        of several axes the first such one is named.
    ValueError
        An averaging factor is no positive whole number, or a sample rate not positive and finite.

    Notes
    -----
    NIST SP 1065 eq. 11; IEEE 952 Annex C.
    """
    return _curve(rate_dps, _OVERLAPPING, sample_rate_hz, averaging_factors)


def allan_deviation(
    rate_dps: ArrayLike, *, sample_rate_hz: float, averaging_factors: Sequence[int] | None = None
) -> AllanDeviation:
    """Classic Allan deviation, of groups side by side.

    Parameters, return value and errors as of `overlapping_allan_deviation`. Over K = floor(n/m)
    group means the sum of squared differences is divided by 2(K − 1); a tail shorter than a group
    is dropped.

    Notes
    -----
    NIST SP 1065 eq. 7.
    """
    return _curve(rate_dps, _CLASSIC, sample_rate_hz, averaging_factors)


def modified_allan_deviation(
    rate_dps: ArrayLike, *, sample_rate_hz: float, averaging_factors: Sequence[int] | None = None
) -> AllanDeviation:
    """Modified Allan deviation, which tells white from flicker angle noise (slopes −3/2 and −1).

    Parameters, return value and errors as of `overlapping_allan_deviation`; an averaging factor m
    needs 3m − 1 samples.

    Notes
    -----
    NIST SP 1065 eq. 14.
    """
    return _curve(rate_dps, _MODIFIED, sample_rate_hz, averaging_factors)


def hadamard_deviation(
    rate_dps: ArrayLike, *, sample_rate_hz: float, averaging_factors: Sequence[int] | None = None
) -> AllanDeviation:
    """Overlapping Hadamard deviation, to which a rate ramp adds nothing.

    Parameters, return value and errors as of `overlapping_allan_deviation`; an averaging factor m
    needs 3m samples.

    Notes
    -----
    NIST SP 1065 eq. 20.
    """
    return _curve(rate_dps, _HADAMARD, sample_rate_hz, averaging_factors)


def total_deviation(
    rate_dps: ArrayLike, *, sample_rate_hz: float, averaging_factors: Sequence[int] | None = None
) -> AllanDeviation:
    """Total deviation: the Allan deviation with more degrees of freedom at long averaging times.

    Parameters, return value and errors as of `overlapping_allan_deviation`. The angle is continued
    at both ends by its reflection, which has its price: over a record of length T the expected
    variance is the Allan variance times 1 − a·τ/T, with a = 0 for angle random walk, 0.481 for bias
    instability, 3/4 for rate random walk and −4/3 for white angle noise. Nothing is corrected; the
    bounds are of that expectation.

    Notes
    -----
    NIST SP 1065 eq. 25.
    """
    return _curve(rate_dps, _TOTAL, sample_rate_hz, averaging_factors)


@dataclass(frozen=True, slots=True, kw_only=True)
class _Estimator:
    """How variances are computed, how many differences they are of, and what a factor m needs.

    `differences` takes the number of samples and the factors; `groups`·m − `spared` samples are needed.
    """

    variances: Callable[[NDArray[np.float64], _Factors], NDArray[np.float64]]
    differences: Callable[[int, _Factors], _Factors]
    variance: Variance
    groups: int
    spared: int = 0
    strides: int | None = None


_OVERLAPPING = _Estimator(
    variances=overlapping_variances,
    differences=lambda n, m: n + 1 - 2 * m,
    variance=Variance.ALLAN,
    groups=2,
)
_CLASSIC = _Estimator(
    variances=classic_variances,
    differences=lambda n, m: n // m - 1,
    variance=Variance.ALLAN,
    groups=2,
    strides=1,
)
_MODIFIED = _Estimator(
    variances=modified_variances,
    differences=lambda n, m: n + 2 - 3 * m,
    variance=Variance.MODIFIED,
    groups=3,
    spared=1,
)
_HADAMARD = _Estimator(
    variances=hadamard_variances,
    differences=lambda n, m: n + 1 - 3 * m,
    variance=Variance.HADAMARD,
    groups=3,
)
_TOTAL = _Estimator(
    variances=total_variances,
    differences=lambda n, m: np.full(m.shape, n - 1),
    variance=Variance.TOTAL,
    groups=2,
)


def _curve(
    rate_dps: ArrayLike,
    estimator: _Estimator,
    sample_rate_hz: float,
    averaging_factors: Sequence[int] | None,
) -> AllanDeviation:
    rate = real_samples(rate_dps)
    checked_sample_rate(sample_rate_hz)
    if not rate.ndim or not np.prod(rate.shape[:-1], dtype=int):
        raise ValueError(f"a rate record has shape (..., n) and at least one axis, found {rate.shape}")
    factors = _factors(rate.shape[-1], estimator, averaging_factors)
    shape = (*rate.shape[:-1], factors.size)
    variances, types = np.empty(shape), np.empty(shape, dtype=np.int8)
    for place in np.ndindex(rate.shape[:-1]):  # one at a time: only one angle is in memory
        theta = _angle(rate, place)
        variances[place] = estimator.variances(theta, factors)
        types[place] = _types(theta, factors)
    return bounded_curve(
        averaging_factor=factors,
        sample_rate_hz=sample_rate_hz,
        deviation_dps=np.sqrt(variances),
        n_differences=estimator.differences(rate.shape[-1], factors),
        edf=allan_edf(
            rate.shape[-1] + 1,
            factors,
            types,
            variance=estimator.variance,
            strides=estimator.strides,
        ),
        noise_type=types,
    )


def _types(theta: NDArray[np.float64], factors: _Factors) -> NDArray[np.int8]:
    """Identify noise types; at the longest time that allows it, where all factors are too long."""
    longest = (theta.size - 1) // SHORTEST
    identified = [longest] if 0 < longest < factors[0] else []
    return noise_types(theta, np.concatenate((identified, factors)).astype(np.int64))[-factors.size :]


def _factors(samples: int, estimator: _Estimator, wanted: Sequence[int] | None) -> _Factors:
    if wanted is None:
        return default_factors(samples)
    factors = checked_factors(wanted)
    needed = estimator.groups * int(factors[-1]) - estimator.spared
    if needed > samples:
        raise InsufficientDataError(
            f"averaging {factors[-1]} samples needs at least {needed}; the record has {samples}"
        )
    return factors


def _angle(rate: NDArray[np.generic], place: tuple[int, ...]) -> NDArray[np.float64]:
    """Sum up one gyro axis; `place` is its index among the leading axes."""
    try:
        return angle(rate[place])
    except InsufficientDataError as error:
        if not place:
            raise
        raise InsufficientDataError(f"axis {', '.join(map(str, place))}: {error}") from None
