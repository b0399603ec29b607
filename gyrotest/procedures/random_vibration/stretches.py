"""Neighbouring frequencies as stretches, and lines of a spectrum grouped for drawing."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

_Array = NDArray[np.float64]
_HALF = 1.5


def stretches_of(frequency_hz: _Array, spacing_hz: float) -> list[_Array]:
    """Cut rising frequencies (n,) where one is farther than a spacing from the one before."""
    if not frequency_hz.size:
        return []
    return np.split(frequency_hz, np.flatnonzero(np.diff(frequency_hz) > _HALF * spacing_hz) + 1)


@dataclass(frozen=True, slots=True, kw_only=True)
class Bins:
    """Neighbouring lines that become one drawn point: where each group of them begins, and its mean frequency."""

    starts: NDArray[np.int64]
    frequency_hz: _Array
    lines: int

    def means(self, values: _Array) -> _Array:
        """Return the mean of each group's values (n,)."""
        counts = np.diff(np.append(self.starts, self.lines))
        found: _Array = np.add.reduceat(values, self.starts) / counts
        return found

    def least(self, values: _Array) -> _Array:
        """Return the least of each group's values (n,)."""
        found: _Array = np.minimum.reduceat(values, self.starts)
        return found


def log_bins(frequency_hz: _Array, most: int) -> Bins:
    """Group rising frequencies (n,) evenly on a logarithmic scale, into `most` groups or fewer."""
    place = np.log(frequency_hz / frequency_hz[0])
    number = np.floor(place * (most / max(float(place[-1]), 1e-12) * (1.0 - 1e-9))).astype(np.int64)
    starts = np.concatenate(([0], np.flatnonzero(np.diff(number)) + 1))
    bins = Bins(starts=starts, frequency_hz=frequency_hz[starts], lines=frequency_hz.size)
    return replace(bins, frequency_hz=bins.means(frequency_hz))
