"""Frequency response from spectra: the estimators H1, H2 and Hv, the coherence and the random error."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gyrotest.analysis.cross_spectra import Spectra
from gyrotest.analysis.noise_ratio import NoiseRatio

_Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True, kw_only=True)
class Response:
    """A frequency response at k lines.

    `gain` is in the output's unit a °/s; `phase_deg` is unwrapped, a lag negative. `coherence` is corrected
    for its bias. `gain_error` (relative) and `phase_error_deg` are the random error, one standard deviation.
    `common` (k, q) moves the logarithm of the gain at all lines together: q independent standard deviations
    of what the noise ratio is not known.
    """

    frequency_hz: _Array
    gain: _Array
    phase_deg: _Array
    coherence: _Array
    gain_error: _Array
    phase_error_deg: _Array
    common: _Array
    averages: float
    segment_s: float
    correlation: _Array


def h1(spectra: Spectra) -> Response:
    """Estimate G21/G11: unbiased where all noise is on the output."""
    raise NotImplementedError


def h2(spectra: Spectra) -> Response:
    """Estimate G22/G12: unbiased where all noise is on the reference."""
    raise NotImplementedError


def hv(spectra: Spectra, noise_ratio: NoiseRatio) -> Response:
    """Estimate with noise on both, its ratio known: S4.5."""
    raise NotImplementedError


def coherence(spectra: Spectra) -> _Array:
    """Return γ² (k,), corrected for its bias, 0 … 1."""
    raise NotImplementedError


def random_error(coherence: _Array, averages: float) -> _Array:
    """Return ε = √((1 − γ²)/(2Lγ²)): relative of the gain, and of the phase in radians."""
    raise NotImplementedError
