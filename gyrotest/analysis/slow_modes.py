"""The slow part of a record: the cosine modes of its block means, which noise makes independent.

Over averaging times close to its length a record has few averages, whose Allan variances are far
from normal and depend on each other. The record's cosine transform has neither fault: each mode is
normal, and the modes of white noise and of a random walk are exactly uncorrelated, with the
spectrum at k/(2T) as their variance. Those of flicker noise are nearly uncorrelated; the ends of the
record take the share 2/(π²k) of their variance.
"""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from gyrotest.analysis.noise_terms import Grid, spectrum_columns

MOST_MODES = 256

TO_MODES = 0.4
"""Averaging time, over the record's length and times the number of modes, beyond which modes are used."""

_BLOCKS_PER_MODE = 4
_FLICKER = 2


@dataclass(frozen=True, slots=True, kw_only=True)
class SlowModes:
    """Modes 1 … m of a record of `duration_s`, and what each term contributes to their variance.

    `mode_dps` has shape (m,) and is orthonormal over `blocks` block means; `variance` (m, 4) is per
    unit of Q², N², B², K². The mean, mode 0, is not among them.
    """

    mode_dps: NDArray[np.float64]
    variance: NDArray[np.float64]
    blocks: int
    duration_s: float

    @property
    def first_tau_s(self) -> float:
        """The averaging time from which on the modes stand in for Allan variances."""
        return TO_MODES * self.duration_s / self.mode_dps.size

    def slowest(self, count: int) -> "SlowModes":
        """Leave out the fastest modes."""
        return replace(self, mode_dps=self.mode_dps[:count], variance=self.variance[:count])

    def of_course(self, block_means: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the modes (..., m) of a course given by its block means (..., blocks)."""
        return _cosine_modes(block_means, self.mode_dps.size)


def slow_modes(rate_dps: NDArray[np.float64], grid: Grid) -> SlowModes:
    """Return the slowest modes of a record, at most 256; a tail shorter than a block is left out."""
    count = mode_count(rate_dps.size)
    size = max(rate_dps.size // (_BLOCKS_PER_MODE * count), 1)
    blocks = rate_dps.size // size
    means = np.add.reduceat(rate_dps[: blocks * size], np.arange(0, blocks * size, size)) / size
    means -= means.mean()
    block_s = size * grid.interval_s
    spacing = Grid(interval_s=block_s, aperture_s=block_s)
    order = np.arange(1, count + 1)
    variance = spectrum_columns(order / (2.0 * blocks * block_s), spacing)[:, :4] / (2.0 * block_s)
    variance[:, _FLICKER] *= 1.0 - 2.0 / (np.pi**2 * order)
    return SlowModes(
        mode_dps=_cosine_modes(means, count),
        variance=variance,
        blocks=blocks,
        duration_s=blocks * block_s,
    )


def mode_count(samples: int) -> int:
    """Return how many modes of a record of so many samples are used."""
    return min(MOST_MODES, max(samples // _BLOCKS_PER_MODE, 1))


def _cosine_modes(block_means: NDArray[np.float64], count: int) -> NDArray[np.float64]:
    from scipy.fft import dct

    modes: NDArray[np.float64] = dct(block_means, type=2, norm="ortho", axis=-1)
    return modes[..., 1 : count + 1]
