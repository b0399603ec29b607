"""Noise that is there in motion and not at rest: of which channel it is, the record at rest cannot tell."""

import numpy as np
from numpy.typing import NDArray

from gyrotest.analysis.cross_spectra import Spectra
from gyrotest.analysis.frequency_response import coherence

_Array = NDArray[np.float64]
_LINES = 41


def noise_beyond_rest(moving: Spectra, rest: Spectra) -> _Array:
    """Return by how much of itself a gain may err for it, at most, at each line (k,).

    The incoherent share 1 − γ² is what the noises at rest make up of both powers, and more where there are
    others: an encoder's errors within its lines, a unit that rectifies. All of that on one channel, taken to
    be on the other, makes the gain wrong by as much as itself. Means of neighbouring lines, 0 at least.
    """
    incoherent = 1.0 - coherence(moving)
    at_rest = rest.output / moving.output + rest.reference / moving.reference
    found: _Array = np.maximum(_smooth(incoherent - at_rest), 0.0)
    found.setflags(write=False)
    return found


def _smooth(values: _Array) -> _Array:
    """Return running means, of fewer values towards the ends."""
    window = np.ones(min(_LINES, values.size))
    sums: _Array = np.convolve(values, window, mode="same")
    counts: _Array = np.convolve(np.ones(values.size), window, mode="same")
    return sums / counts
