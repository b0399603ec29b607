"""An Allan deviation curve, and at which averaging factors it is taken."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from gyrotest.analysis.fixed import fixed
from gyrotest.analysis.interval import ONE_SIGMA, Bounds, deviation_bounds
from gyrotest.errors import InsufficientDataError

GROUPS = 9
"""Independent groups that the longest default averaging time leaves."""

_FIRST = (1, 2, 3, 4, 5, 6, 8, 10, 12)
_OCTAVE = (16, 20, 25)


@dataclass(frozen=True, slots=True, kw_only=True)
class AllanDeviation:
    """A deviation over averaging times; `...` are the leading axes of the record, one entry a gyro axis.

    `lower_dps` and `upper_dps` are the 68.27 % chi-square bounds; `noise_type`, values of
    `NoiseType`, rules the degrees of freedom `edf`. All arrays are read-only.
    """

    averaging_factor: NDArray[np.int64]  # (k,)
    tau_s: NDArray[np.float64]  # (k,)
    deviation_dps: NDArray[np.float64]  # (..., k)
    n_differences: NDArray[np.int64]  # (k,)
    edf: NDArray[np.float64]  # (..., k)
    lower_dps: NDArray[np.float64]  # (..., k)
    upper_dps: NDArray[np.float64]  # (..., k)
    noise_type: NDArray[np.int8]  # (..., k)

    def at(self, averaging_factors: ArrayLike) -> "AllanDeviation":
        """Take the curve at some of its averaging factors only; `ValueError` where it lacks one."""
        wanted = np.unique(np.asarray(averaging_factors, dtype=np.int64))
        missing = np.setdiff1d(wanted, self.averaging_factor)
        if missing.size:
            raise ValueError(f"the curve has no averaging factor {missing[0]}")
        chosen = np.searchsorted(self.averaging_factor, wanted)
        return AllanDeviation(
            averaging_factor=fixed(self.averaging_factor[chosen]),
            tau_s=fixed(self.tau_s[chosen]),
            deviation_dps=fixed(self.deviation_dps[..., chosen]),
            n_differences=fixed(self.n_differences[chosen]),
            edf=fixed(self.edf[..., chosen]),
            lower_dps=fixed(self.lower_dps[..., chosen]),
            upper_dps=fixed(self.upper_dps[..., chosen]),
            noise_type=fixed(self.noise_type[..., chosen]),
        )

    def bounds_dps(self, confidence: float = 0.95) -> Bounds:
        """Return chi-square bounds at another confidence."""
        return deviation_bounds(self.deviation_dps, self.edf, confidence=confidence)


def bounded_curve(
    *,
    averaging_factor: NDArray[np.int64],
    sample_rate_hz: float,
    deviation_dps: NDArray[np.float64],
    n_differences: NDArray[np.int64],
    edf: NDArray[np.float64],
    noise_type: NDArray[np.int8],
) -> AllanDeviation:
    """Return the curve with its 68.27 % bounds; the arrays handed in become read-only."""
    bounds = deviation_bounds(deviation_dps, edf, confidence=ONE_SIGMA)
    return AllanDeviation(
        averaging_factor=fixed(averaging_factor),
        tau_s=fixed(averaging_factor / sample_rate_hz),
        deviation_dps=fixed(deviation_dps),
        n_differences=fixed(n_differences),
        edf=fixed(edf),
        lower_dps=fixed(bounds.lower),
        upper_dps=fixed(bounds.upper),
        noise_type=fixed(noise_type),
    )


def default_factors(samples: int) -> NDArray[np.int64]:
    """Return averaging factors, ten a decade, from 1 to floor(samples/9).

    From 16 on they are 16, 20 and 25 times a power of two: an octave is exactly a factor of two, and
    three an octave are ten a decade.

    Raises
    ------
    InsufficientDataError
        Fewer than nine samples.
    """
    if samples < GROUPS:
        raise InsufficientDataError(
            f"the record has {samples} samples; an Allan deviation needs at least {GROUPS} groups"
        )
    longest = samples // GROUPS
    octaves = 2 ** np.arange(longest.bit_length(), dtype=np.int64)
    series = np.concatenate((_FIRST, np.multiply.outer(octaves, _OCTAVE).ravel()))
    return np.append(series[series < longest], longest)


def log_spaced_factors(longest: int, *, per_decade: int) -> NDArray[np.int64]:
    """Return whole numbers from 1 to `longest`, both included, evenly spaced in their logarithm."""
    steps = int(np.floor(np.log10(longest) * per_decade + 1e-9))
    spaced = np.rint(10.0 ** (np.arange(steps + 1) / per_decade)).astype(np.int64)
    return np.unique(np.append(spaced[spaced <= longest], longest))


def checked_factors(factors: Sequence[int] | NDArray[np.int64]) -> NDArray[np.int64]:
    """Return averaging factors ascending and once each; `ValueError` unless positive whole numbers."""
    wanted = np.unique(np.asarray(factors))
    if wanted.size == 0 or wanted.dtype.kind not in "iu" or wanted[0] < 1:
        raise ValueError(f"averaging factors are positive whole numbers, found {factors!r}")
    return wanted.astype(np.int64)


def checked_sample_rate(sample_rate_hz: float) -> None:
    """Raise `ValueError` unless a sample rate is positive and finite."""
    if not (np.isfinite(sample_rate_hz) and sample_rate_hz > 0.0):
        raise ValueError(f"a sample rate is a positive, finite number of Hz, found {sample_rate_hz!r}")
