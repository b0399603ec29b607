"""Auto and cross spectra of a reference angle and a gyro's output, block by block.

The convention, here and everywhere: G_yx = ⟨Y·X*⟩, which is what `scipy.signal.csd(x, y)` computes, with
the reference as x and the output as y. An output that lags by τ has the phase −360°·f·τ. The reference is
an angle and enters as a rate, Ω1 = j2πf·Θ1: each line of a segment is multiplied before the taper spreads
it. Done after the taper, G_ω1ω1 = (2πf)²·G_θ1θ1 comes out too large by up to 1/(f·T)², because an angle's
spectrum falls steeply (0.25 % at twenty periods a segment).
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gyrotest.analysis.fixed import fixed
from gyrotest.analysis.segment_lines import SegmentLines
from gyrotest.analysis.taper import Taper, taper
from gyrotest.errors import InsufficientDataError

_Array = NDArray[np.float64]
_Complex = NDArray[np.complex128]

PERIODS = 20
"""Periods of the lowest frequency in the shortest default segment."""

_TOGETHER = 6
_EDGE = 1e-12


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
        self._lines = SegmentLines(self._taper, rate_hz=rate_hz, low_hz=low_hz, high_hz=high_hz)
        self._room = np.empty((2, self.segment + (_TOGETHER - 1) * self._taper.hop))
        self._origin = np.zeros((2, 1))
        self._sums = np.zeros((2, self._lines.kept.size))
        self._cross = np.zeros(self._sums.shape[1], dtype=np.complex128)
        self._fill = 0
        self._stretches = [0]

    @property
    def segment_s(self) -> float:
        """Length of a segment, s."""
        return self.segment / self.rate_hz

    @property
    def segments(self) -> int:
        """Segments so far that are complete and averaged."""
        return sum(self._stretches)

    def begin_stretch(self) -> None:
        """Say that the next sample does not follow the last one: no segment bridges this."""
        self._average()
        self._fill = 0
        if self._stretches[-1]:
            self._stretches.append(0)

    def push(self, angle_deg: _Array, output: _Array) -> None:
        """Take in the next samples (n,) of both: the reference angle in °, the output in its unit.

        Raises
        ------
        InsufficientDataError
            A sample that is not a finite number.
        ValueError
            Not as many of the one as of the other.
        """
        if angle_deg.shape != output.shape:
            raise ValueError(
                f"{angle_deg.shape} angles and {output.shape} outputs are not sampled together"
            )
        signals = (angle_deg, output)
        if not all(np.isfinite(one.sum()) for one in signals):
            raise InsufficientDataError(
                "a sample is not a finite number; leave it out and begin a new stretch after it"
            )
        if not self._fill and angle_deg.size:
            self._origin = np.array([[one[0]] for one in signals])
        place = 0
        while place < angle_deg.size:
            taken = min(angle_deg.size - place, self._room.shape[1] - self._fill)
            for row, one, origin in zip(self._room, signals, self._origin, strict=True):
                np.subtract(one[place : place + taken], origin, out=row[self._fill : self._fill + taken])
            self._fill += taken
            place += taken
            if self._fill == self._room.shape[1]:
                self._average()

    def spectra(self) -> Spectra:
        """Average what has come so far.

        Raises
        ------
        InsufficientDataError
            No segment is complete.
        """
        self._average()
        if not self.segments:
            raise InsufficientDataError(
                f"no stretch of the record holds a segment of {self.segment_s:g} s ({self.segment} samples):"
                " record longer without a gap, or begin the band at a higher frequency"
            )
        density = 2.0 / (self.rate_hz * self.segment * self._taper.power * self.segments)
        variance = _variances(self._taper, self._stretches)
        return Spectra(
            frequency_hz=fixed(self._lines.kept / self.segment_s),
            reference=fixed(self._sums[0] * density),
            output=fixed(self._sums[1] * density),
            cross=fixed(self._cross * density),
            segments=self.segments,
            averages=float(1.0 / variance[0]),
            segment_s=self.segment_s,
            correlation=fixed(variance / variance[0]),
        )

    def _average(self) -> None:
        """Add all segments that are complete, and keep the samples that the next one begins with."""
        if self._fill < self.segment:
            return
        hop = self._taper.hop
        count = 1 + (self._fill - self.segment) // hop
        windows = np.lib.stride_tricks.sliding_window_view(
            self._room[:, : self._fill], self.segment, axis=1
        )
        rate, output = self._lines.tapered(windows[:, ::hop])
        self._sums += np.stack([_power(rate), _power(output)])
        self._cross += np.sum(output * rate.conj(), axis=0)
        left = self._fill - count * hop
        self._room[:, :left] = self._room[:, self._fill - left : self._fill].copy()
        self._fill = left
        self._stretches[-1] += count


def pooled(runs: Sequence[Spectra]) -> Spectra:
    """Average the spectra of several runs, each weighted by its segments.

    Raises
    ------
    ValueError
        No run, or runs of different lines.
    """
    if not runs:
        raise ValueError("there is no run to average")
    first = runs[0]
    if any(
        one.segment_s != first.segment_s or not np.array_equal(one.frequency_hz, first.frequency_hz)
        for one in runs
    ):
        raise ValueError("runs are averaged line by line; their segments and bands are one and the same")
    segments = sum(one.segments for one in runs)
    shares = [one.segments / segments for one in runs]
    variance = np.sum(
        [s**2 * one.correlation / one.averages for s, one in zip(shares, runs, strict=True)], axis=0
    )
    return Spectra(
        frequency_hz=first.frequency_hz,
        reference=fixed(np.average([one.reference for one in runs], axis=0, weights=shares)),
        output=fixed(np.average([one.output for one in runs], axis=0, weights=shares)),
        cross=fixed(np.average([one.cross for one in runs], axis=0, weights=shares)),
        segments=segments,
        averages=float(1.0 / variance[0]),
        segment_s=first.segment_s,
        correlation=fixed(variance / variance[0]),
    )


def _power(lines: _Complex) -> _Array:
    found: _Array = np.sum(lines.real**2 + lines.imag**2, axis=0)
    return found


def _variances(shape: Taper, stretches: Sequence[int]) -> _Array:
    """Return the relative (co)variance of averages at lines 0, 1, 2 … apart (Welch 1967)."""
    segments = sum(stretches)
    pairs = sum(count - 1 for count in stretches if count)
    found: _Array = (segments * shape.same + 2.0 * pairs * shape.next) / segments**2
    return found
