"""Noise identification: Q, N, B, K and R of a record, with uncertainties that hold.

The squared coefficients are fitted, none of them negative, to log-spaced overlapping Allan variances
by generalised least squares with the covariance that the model itself gives between averaging times,
and, for what is slower, to the likelihood of the record's slow modes. Spectral lines and a drift are
recognised and kept out. The fit begins at the shortest averaging time from which the model describes
the record, so that a sensor's filter does not pass for less noise.
"""

import numpy as np
from numpy.typing import ArrayLike, NDArray

from gyrotest.analysis.allan import AllanDeviation, overlapping_allan_deviation
from gyrotest.analysis.allan_fit import allan_fit
from gyrotest.analysis.angle import checked_rate
from gyrotest.analysis.curve import checked_sample_rate
from gyrotest.analysis.drift import courses
from gyrotest.analysis.fitted_record import FittedRecord
from gyrotest.analysis.identification import NO_NOISE, identified
from gyrotest.analysis.kernels.record import difference_powers
from gyrotest.analysis.minimum import AllanMinimum, allan_minimum
from gyrotest.analysis.noise_model import Drift, DriftKind, NoiseModel, NoiseTerm, SpectralLine
from gyrotest.analysis.noise_terms import Grid
from gyrotest.analysis.slow_modes import TO_MODES, mode_count, slow_modes
from gyrotest.analysis.spectral_lines import Excess, lines_in, spectrum
from gyrotest.errors import InsufficientDataError

__all__ = [
    "SHORTEST_RECORD",
    "AllanMinimum",
    "Drift",
    "DriftKind",
    "NoiseModel",
    "NoiseTerm",
    "SpectralLine",
    "allan_minimum",
    "fitted_factors",
    "identify_noise",
    "spectral_lines",
]

SHORTEST_RECORD = 36
"""Samples below which no noise model is fitted."""

_FIRST_FACTORS = (1, 2, 3, 4, 6, 10)
_OCTAVES = (16, 25, 40)  # times 4^j: five a decade, all of them among the default factors
_MOST_DIFFERENCES = 1 << 21


def identify_noise(
    rate_dps: ArrayLike,
    *,
    sample_rate_hz: float,
    duty: float = 1.0,
    deviation: AllanDeviation | None = None,
    lines: tuple[Excess, ...] | None = None,
) -> NoiseModel:
    """Identify quantization noise, angle random walk, bias instability, rate random walk and rate ramp.

    Parameters
    ----------
    rate_dps
        Shape (n,): rate samples, evenly spaced, °/s.
    sample_rate_hz
        Samples a second.
    duty
        Share of each interval over which a sample is averaged, above 0 and at most 1.
    deviation
        The record's overlapping Allan deviation, where it is at hand already; one at the default
        averaging factors will do.
    lines
        The record's spectral lines, where they are at hand already (`spectral_lines`).

    Returns
    -------
    NoiseModel
        Its angle random walk is the apparent one where the duty is below 1.

    Raises
    ------
    InsufficientDataError
        Fewer than 36 samples, a sample that is not finite, a constant record, or one without noise
        (a ramp or a tone alone).
    ValueError
        A sample rate is not positive and finite, or a duty not above 0 and at most 1.

    Notes
    -----
    Terms and their spectra: IEEE 952 Annex C. Where the fit begins: `first_tau_s` of the model.
    """
    checked_sample_rate(sample_rate_hz)
    if not 0.0 < duty <= 1.0:
        raise ValueError(f"a duty is above 0 and at most 1, found {duty!r}")
    rate = checked_rate(rate_dps)
    if rate.size < SHORTEST_RECORD:
        raise InsufficientDataError(
            f"the record has {rate.size} samples; a noise model needs at least {SHORTEST_RECORD}"
        )
    factors = fitted_factors(rate.size)
    if deviation is None or not np.isin(factors, deviation.averaging_factor).all():
        deviation = overlapping_allan_deviation(
            rate, sample_rate_hz=sample_rate_hz, averaging_factors=factors.tolist()
        )
    if lines is None:
        lines = spectral_lines(rate, sample_rate_hz=sample_rate_hz)
    grid = Grid(interval_s=1.0 / sample_rate_hz, aperture_s=duty / sample_rate_hz)
    fit = allan_fit(factors, deviation.at(factors).deviation_dps ** 2, rate.size, grid).less_lines(lines)
    fit = fit.with_tails(fourth_cumulant(rate))
    modes = slow_modes(rate, grid)
    record = FittedRecord(fit=fit, modes=modes, candidates=courses(modes))
    try:
        with np.errstate(divide="raise", over="raise", invalid="raise"):
            return identified(record, lines)
    except (FloatingPointError, np.linalg.LinAlgError) as error:
        raise InsufficientDataError(NO_NOISE) from error


def spectral_lines(rate_dps: NDArray[np.float64], *, sample_rate_hz: float) -> tuple[Excess, ...]:
    """Find the spectral lines of a record (n,); none in one too short for a spectrum."""
    found = spectrum(rate_dps, sample_rate_hz=sample_rate_hz)
    return () if found is None else lines_in(found)


def fourth_cumulant(rate_dps: NDArray[np.float64]) -> float:
    """Return the fourth cumulant, (°/s)⁴, of the samples of a record (n,), which are taken for independent.

    By first differences d, which drift does not touch: (⟨d⁴⟩ − 3⟨d²⟩²)/2. Of a very long record some
    two million of them, evenly spread.
    """
    sums = np.empty(3)
    every = max(rate_dps.size // _MOST_DIFFERENCES, 1)
    difference_powers(rate_dps, every, sums)
    second, fourth = sums[1:] / sums[0]
    return float(fourth - 3.0 * second**2) / 2.0


def fitted_factors(samples: int) -> NDArray[np.int64]:
    """Return the averaging factors of the fit: five a decade, as far as the slow modes do not speak."""
    longest = max(int(TO_MODES * samples / mode_count(samples)), 1)
    octaves = 4 ** np.arange(longest.bit_length(), dtype=np.int64)
    series = np.append(_FIRST_FACTORS, np.multiply.outer(octaves, _OCTAVES).ravel())
    return series[series <= longest]
