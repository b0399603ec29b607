"""Auto and cross spectra of a reference angle and a gyro's output, block by block.

The convention, here and everywhere: G_yx = ⟨Y·X*⟩, which is what `scipy.signal.csd(x, y)` computes, with
the reference as x and the output as y. An output that lags by τ has the phase −360°·f·τ. The reference is
an angle and enters as a rate, Ω1 = j2πf·Θ1: each line of a segment is multiplied before the taper spreads
it. Done after the taper, G_ω1ω1 = (2πf)²·G_θ1θ1 comes out too large by up to 1/(f·T)², because an angle's
spectrum falls steeply (0.25 % at twenty periods a segment).
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from gyrotest.analysis.taper import Taper, taper

_Array = NDArray[np.float64]
_Complex = NDArray[np.complex128]

PERIODS = 20
"""Periods of the lowest frequency in the shortest default segment."""

_TOGETHER = 6
_EDGE = 1e-9


@dataclass(frozen=True, slots=True, kw_only=True)
class Spectra:
    """One-sided spectral densities at k lines, averaged over segments that overlap by half.

    `reference` is in (°/s)²/Hz, `output` in its unit squared a Hz, `cross` is output × conj(reference).
    `averages` is how many independent segments the `segments` are worth. `correlation` is that of the
    estimates at lines 0, 1, 2 … apart. The arrays are read-only.
    """

    frequency_hz: _Array  # (k,)
    reference: _Array  # (k,)
    output: _Array  # (k,)
    cross: _Complex  # (k,)
    segments: int
    averages: float
    segment_s: float
    correlation: _Array  # (m,)

    def with_reference_later(self, skew_s: float) -> "Spectra":
        """Correct the cross spectrum for a reference that is sampled so much later than the output.

        What is sampled later leads by 2πf·skew, so that the output seems to lag: S4.8.
        """
        return replace(self, cross=_fixed(self.cross * np.exp(2j * np.pi * self.frequency_hz * skew_s)))


def default_segment(*, rate_hz: float, low_hz: float) -> int:
    """Return the even number of samples, quick to transform, that holds 20 periods of the lowest frequency."""
    from scipy.fft import next_fast_len

    half = int(np.ceil(PERIODS * rate_hz / low_hz / 2.0 - _EDGE))
    return 2 * int(next_fast_len(half, real=True))


class CrossSpectra:
    """Averages tapered, detrended segments that overlap by half, as samples come (Welch).

    Parameters
    ----------
    rate_hz
        Sampling rate of both signals.
    low_hz, high_hz
        The band, both ends included; lines outside are not kept.
    segment
        Samples a segment; None: `default_segment`.
    window
        One of `taper.TERMS`.

    Raises
    ------
    ValueError
        A band that does not lie between the segment's first line and half of the sampling rate.
    """

    def __init__(
        self,
        *,
        rate_hz: float,
        low_hz: float,
        high_hz: float,
        segment: int | None = None,
        window: str = "hann",
    ) -> None:
        self.rate_hz = rate_hz
        self.segment = segment or default_segment(rate_hz=rate_hz, low_hz=low_hz)
        self._taper = taper(window, self.segment)
        self._lines = _lines(self._taper, rate_hz, low_hz, high_hz)
        raise NotImplementedError

    @property
    def segment_s(self) -> float:
        """Length of a segment, s."""
        return self.segment / self.rate_hz

    def begin_stretch(self) -> None:
        """Say that the next sample does not follow the last one: no segment bridges this."""
        raise NotImplementedError

    def push(self, angle_deg: _Array, output: _Array) -> None:
        """Take in the next samples (n,) of both: the reference angle in °, the output in its unit."""
        raise NotImplementedError

    def spectra(self) -> Spectra:
        """Average what has come so far; raises `InsufficientDataError` where no segment is complete."""
        raise NotImplementedError


def pooled(runs: Sequence[Spectra]) -> Spectra:
    """Average the spectra of several runs, each weighted by its segments.

    Raises
    ------
    ValueError
        No run, or runs of different lines.
    """
    raise NotImplementedError


def _lines(shape: Taper, rate_hz: float, low_hz: float, high_hz: float) -> NDArray[np.int64]:
    raise NotImplementedError


def _fixed(array: _Complex) -> _Complex:
    array.setflags(write=False)
    return array
