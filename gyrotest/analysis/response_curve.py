"""A frequency response as a smooth curve over its band, and what is read off it."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gyrotest.analysis.frequency_response import Response

_Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True, kw_only=True)
class CurvePoints:
    """A curve at frequencies (n,), with standard uncertainties by its random error."""

    frequency_hz: _Array
    gain: _Array
    gain_uncertainty: _Array
    phase_deg: _Array
    phase_uncertainty_deg: _Array


@dataclass(frozen=True, slots=True, kw_only=True)
class Reading:
    """A value read off a curve, with its standard uncertainty."""

    value: float
    uncertainty: float


@dataclass(frozen=True, slots=True, kw_only=True)
class ResponseCurve:
    """Gain and phase over `low_hz` … `high_hz`; `excluded_hz` are lines of too little coherence."""

    low_hz: float
    high_hz: float
    excluded_hz: _Array

    def at(self, frequency_hz: _Array) -> CurvePoints:
        """Evaluate within the band; raises `InsufficientDataError` outside of it."""
        raise NotImplementedError


def fit_response(response: Response, *, degree: int, coherence_floor: float) -> ResponseCurve:
    """Fit polynomials of a degree to gain and phase, weighted by 1/ε²: S4.6."""
    raise NotImplementedError


def bandwidth(curve: ResponseCurve, *, reference_hz: float) -> Reading | None:
    """Find where the gain has fallen by 3 dB, Hz; None where that is beyond the band."""
    raise NotImplementedError


def quarter_turn(curve: ResponseCurve) -> Reading | None:
    """Find where the phase passes −90°, Hz; None where that is beyond the band."""
    raise NotImplementedError


def group_delay(curve: ResponseCurve, *, frequency_hz: float) -> Reading:
    """Return −dφ/dω at a frequency, s."""
    raise NotImplementedError


def flatness(curve: ResponseCurve, *, reference_hz: float) -> Reading:
    """Return how far the gain goes up and down over the band, in % of that at the reference frequency."""
    raise NotImplementedError
