"""Frequency response from spectra: the estimators H1, H2 and Hv, the coherence and the random error."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gyrotest.analysis.cross_spectra import Spectra
from gyrotest.analysis.fixed import fixed
from gyrotest.analysis.noise_ratio import NoiseRatio
from gyrotest.errors import InsufficientDataError

_Array = NDArray[np.float64]

FEWEST_AVERAGES = 8.0
"""Independent averages below which a coherence, and so an error, says too little."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Response:
    """A frequency response at k lines; the arrays are read-only.

    `gain` is in the output's unit a °/s; `phase_deg` lies in −180 … 180, a lag negative. `coherence` is
    corrected for its bias. `error` is the random error, one standard deviation: relative of the gain, in
    radians of the phase; inf where there is no coherence. `common` (k, q) moves the logarithm of the gain at
    all lines together: q independent standard deviations by what the noise ratio is not known. `leaning`
    says which channel the noise is on: 1 the output, −1 the reference. `averages`, `segment_s` and
    `correlation` are those of the spectra.
    """

    frequency_hz: _Array
    gain: _Array
    phase_deg: _Array
    coherence: _Array
    error: _Array
    common: _Array
    leaning: _Array
    averages: float
    segment_s: float
    correlation: _Array

    @property
    def phase_error_deg(self) -> _Array:
        """Random error of the phase, one standard deviation, °."""
        return np.degrees(self.error)


def h1(spectra: Spectra) -> Response:
    """Estimate G21/G11: unbiased where all noise is on the output, else too small.

    Raises
    ------
    InsufficientDataError
        Fewer than 8 independent averages, or a channel that stands still at a frequency.
    """
    gain = np.abs(spectra.cross) / _moving(spectra.reference, spectra, "reference")
    return _response(spectra, gain, leaning=np.ones(gain.size))


def h2(spectra: Spectra) -> Response:
    """Estimate G22/G12: unbiased where all noise is on the reference, else too large; raises as `h1` does."""
    gain = spectra.output / _moving(np.abs(spectra.cross), spectra, "output")
    return _response(spectra, gain, leaning=-np.ones(gain.size))


def hv(spectra: Spectra, noise_ratio: NoiseRatio) -> Response:
    """Estimate the response with noise on both channels, of which the ratio is known.

    Parameters
    ----------
    spectra
        Of the vibrating unit.
    noise_ratio
        κ = G_dd/G_cc, in the square of the output's unit a °/s: found in spectra of the same two channels.

    Raises
    ------
    InsufficientDataError
        Fewer than 8 independent averages, or a channel that stands still at a frequency.

    Notes
    -----
    S4.5: |H| = [(G22 − κG11) + √((G22 − κG11)² + 4κ|G21|²)]/(2|G21|), arg H = arg G21. Where the first
    bracket is negative the other form of the same root is taken, which does not cancel. An infinite κ is H1.
    The random error is that of H1 to the first order, whatever κ.
    """
    frequency_hz = spectra.frequency_hz
    kappa = noise_ratio.at(frequency_hz)
    if not np.isfinite(kappa).all():
        return h1(spectra)
    cross = _moving(np.abs(spectra.cross), spectra, "output")
    _moving(spectra.reference, spectra, "reference")
    excess = spectra.output - kappa * spectra.reference
    root = np.sqrt(excess**2 + 4.0 * kappa * cross**2)
    positive = excess >= 0.0
    gain = np.where(
        positive,
        (excess + root) / (2.0 * cross),
        2.0 * kappa * cross / np.where(positive, 1.0, root - excess),
    )
    by_ratio = -kappa * (gain * spectra.reference - cross) / (gain * root)
    common = by_ratio[:, np.newaxis] * noise_ratio.deviations(frequency_hz)
    leaning = (kappa - gain**2) / (kappa + gain**2)
    return _response(spectra, gain, leaning=leaning, common=common)


def coherence(spectra: Spectra) -> _Array:
    """Compute γ² = |G21|²/(G11·G22), corrected for its bias and held between 0 and 1.

    Returns
    -------
    Shape (k,). 0 where a channel has no power at all.

    Notes
    -----
    S4.5. The expectation of the estimate from L averages is γ² + (1 − γ²)²/L to the first order (Carter,
    Knapp and Nuttall 1973): 1/L where there is none, so that few averages feign coherence.
    """
    product = spectra.reference * spectra.output
    there = product > 0.0
    found = np.where(there, np.abs(spectra.cross) ** 2 / np.where(there, product, 1.0), 0.0)
    found = found - (1.0 - found) ** 2 / spectra.averages
    return np.clip(found, 0.0, 1.0)


def random_error(coherence: _Array, averages: float) -> _Array:
    """Compute ε = √((1 − γ²)/(2Lγ²)): relative of the gain, and in radians of the phase.

    Parameters
    ----------
    coherence
        γ², shape (k,).
    averages
        Independent averages L, which are fewer than segments that overlap.

    Notes
    -----
    S4.5; inf where there is no coherence.
    """
    there = coherence > 0.0
    known = np.where(there, coherence, 1.0)
    return np.where(there, np.sqrt((1.0 - known) / (2.0 * averages * known)), np.inf)


def _response(
    spectra: Spectra, gain: _Array, *, leaning: _Array, common: _Array | None = None
) -> Response:
    if spectra.averages < FEWEST_AVERAGES:
        raise InsufficientDataError(
            f"{spectra.segments} segments of {spectra.segment_s:g} s that overlap by half are worth"
            f" {spectra.averages:.1f} independent averages; {FEWEST_AVERAGES:g} are needed for a coherence:"
            f" record {0.5 * (FEWEST_AVERAGES + 3.0) * spectra.segment_s:.0f} s or more"
        )
    found = coherence(spectra)
    return Response(
        frequency_hz=spectra.frequency_hz,
        gain=fixed(gain),
        phase_deg=fixed(np.degrees(np.angle(spectra.cross))),
        coherence=fixed(found),
        error=fixed(random_error(found, spectra.averages)),
        common=fixed(np.zeros((gain.size, 0)) if common is None else common),
        leaning=fixed(leaning),
        averages=spectra.averages,
        segment_s=spectra.segment_s,
        correlation=spectra.correlation,
    )


def _moving(power: _Array, spectra: Spectra, channel: str) -> _Array:
    """Return what a gain is divided by; raises where it is 0."""
    still = np.flatnonzero(power == 0.0)
    if still.size:
        raise InsufficientDataError(
            f"the {channel} does not move at {spectra.frequency_hz[still[0]]:g} Hz ({still.size} of"
            f" {power.size} frequencies): there is no response; see that the table vibrates over the band and"
            " that both channels are connected"
        )
    return power
