"""Neighbouring frequencies as stretches, and lines of a spectrum thinned for drawing."""

import numpy as np
from numpy.typing import NDArray

_Array = NDArray[np.float64]
_HALF = 1.5


def stretches_of(frequency_hz: _Array, spacing_hz: float) -> list[_Array]:
    """Cut rising frequencies (n,) where one is farther than a spacing from the one before."""
    if not frequency_hz.size:
        return []
    return np.split(frequency_hz, np.flatnonzero(np.diff(frequency_hz) > _HALF * spacing_hz) + 1)


def thinned(values: _Array, most: int) -> _Array:
    """Return means of as many neighbouring values (n,) as leave no more than `most` of them."""
    size = -(-values.size // most)
    starts = np.arange(0, values.size, size)
    means: _Array = np.add.reduceat(values, starts) / np.diff(np.append(starts, values.size))
    return means
