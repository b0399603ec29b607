"""Tapers of spectral segments, and how far segments and neighbouring lines are independent."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

_Array = NDArray[np.float64]

TERMS = {
    "hann": (0.5, 0.5),
    "blackman": (0.42, 0.5, 0.08),
    "nuttall": (0.375, 0.5, 0.125),
}
"""Sums of cosines that vanish at both ends: w = a0 − a1·cos(2πn/N) + a2·cos(4πn/N); Nuttall's is Hann's square."""

_LAGS = 8


@dataclass(frozen=True, slots=True, kw_only=True)
class Taper:
    """A taper over `samples` of a segment, applied to a segment's lines instead of its samples.

    `kernel` (2r + 1,) is what a line takes of itself and its r neighbours to either side; `power` is
    U = (1/N)Σw². `same` and `next` (lags,) are the squared correlations of two lines so many apart, in one
    segment and in two that overlap by half.
    """

    samples: int
    kernel: _Array
    power: float
    same: _Array
    next: _Array

    @property
    def reach(self) -> int:
        """Neighbours to either side that a line takes from."""
        return self.kernel.size // 2

    @property
    def hop(self) -> int:
        """Samples from the begin of a segment to that of the next one."""
        return self.samples - self.samples // 2


def taper(window: str, samples: int) -> Taper:
    """Make a taper by its name, one of `TERMS`.

    Raises
    ------
    ValueError
        An unknown name, or a segment too short to be one.

    Notes
    -----
    Welch (1967): the averages of overlapping segments are correlated by ρ = [Σw(n)w(n + D)/Σw²]². Lines m
    apart likewise by the transform of w² (or of the product) at m.
    """
    if window not in TERMS:
        raise ValueError(f"a window is one of {', '.join(TERMS)}, found {window!r}")
    terms = TERMS[window]
    if samples < 4 * len(terms):
        raise ValueError(f"a segment has at least {4 * len(terms)} samples, found {samples}")
    sides = np.array([0.5 * (-1.0) ** m * a for m, a in enumerate(terms)][1:])
    kernel = np.concatenate((sides[::-1], terms[:1], sides))
    shape = _shape(terms, samples)
    hop = samples - samples // 2
    total = float(np.sum(shape**2))
    return Taper(
        samples=samples,
        kernel=kernel,
        power=total / samples,
        same=_correlation(shape**2, total),
        next=_correlation(np.pad(shape[hop:] * shape[: samples - hop], (0, hop)), total),
    )


def _shape(terms: tuple[float, ...], samples: int) -> _Array:
    phase = 2.0 * np.pi * np.arange(samples) / samples
    shape: _Array = sum(
        ((-1.0) ** m * a * np.cos(m * phase) for m, a in enumerate(terms)), start=np.zeros(samples)
    )
    return shape


def _correlation(product: _Array, total: float) -> _Array:
    lines = np.fft.rfft(product)[: _LAGS + 1] / total
    squared: _Array = np.abs(lines) ** 2
    return squared
