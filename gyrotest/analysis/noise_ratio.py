"""The ratio of the gyro's noise to the reference's, as the Hv estimator needs it, from a record at rest."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gyrotest.analysis.cross_spectra import Spectra

_Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True, kw_only=True)
class NoiseRatio:
    """κ = G_dd/G_cc over a band: noise of the output to that of the rate, in the square of (unit)/(°/s)."""

    low_hz: float
    high_hz: float

    def at(self, frequency_hz: _Array) -> _Array:
        """Return κ at frequencies (k,) of the band; inf where the reference, 0 where the output has no noise."""
        raise NotImplementedError

    def deviations(self, frequency_hz: _Array) -> _Array:
        """Return what moves ln κ (k, q): q independent standard deviations, each common to all frequencies."""
        raise NotImplementedError


def known_ratio(value: float) -> NoiseRatio:
    """Return a noise ratio that is the same at all frequencies and known: 1 is the source's estimator."""
    raise NotImplementedError


def noise_ratio(rest: Spectra) -> NoiseRatio:
    """Find κ in the spectra of a record at rest."""
    raise NotImplementedError
