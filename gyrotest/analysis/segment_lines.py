"""The lines of tapered, detrended segments of an angle and an output, the angle's as those of its rate."""

import numpy as np
from numpy.typing import NDArray

from gyrotest.analysis.taper import Taper

_Array = NDArray[np.float64]
_Complex = NDArray[np.complex128]
_EDGE = 1e-12


class SegmentLines:
    """The lines of a band, both ends included, and how they are found in a segment's samples.

    Raises
    ------
    ValueError
        A band that does not lie between the segment's first line and half of the sampling rate.
    """

    def __init__(self, shape: Taper, *, rate_hz: float, low_hz: float, high_hz: float) -> None:
        self._taper = shape
        self._lines = _band(shape, rate_hz, low_hz, high_hz)
        self._ramp = _ramp(shape.samples, self._lines)
        place = np.arange(shape.samples) - 0.5 * (shape.samples - 1)
        self._slope = place / float(place @ place)
        self._turn = 2j * np.pi * self._lines * rate_hz / shape.samples
        self.kept = self._lines[shape.reach : self._lines.size - shape.reach]

    def tapered(self, segments: _Array) -> _Complex:
        """Return the lines (2, s, k) of rate and output from samples (2, s, n) of angle and output."""
        from scipy.fft import rfft

        lines = rfft(segments, axis=-1, workers=1)[..., self._lines]
        lines -= (segments @ self._slope)[..., np.newaxis] * self._ramp
        lines[..., self._lines == 0] = 0.0
        lines[0] *= self._turn  # S4.4: Ω1 = j2πf·Θ1
        tapered: _Complex = sum(
            (share * lines[..., m : m + self.kept.size] for m, share in enumerate(self._taper.kernel)),
            start=np.zeros((*lines.shape[:-1], self.kept.size), dtype=np.complex128),
        )
        return tapered


def _ramp(samples: int, lines: NDArray[np.int64]) -> _Complex:
    """Return the transform of 0, 1, 2 … at lines; that at line 0 is not used, since the mean is taken out."""
    found = np.zeros(lines.size, dtype=np.complex128)
    beyond = lines > 0
    found[beyond] = samples / np.expm1(-2j * np.pi * lines[beyond] / samples)
    return found


def _band(shape: Taper, rate_hz: float, low_hz: float, high_hz: float) -> NDArray[np.int64]:
    """Return the numbers of the band's lines, and of those to either side that the taper takes from."""
    segment_s = shape.samples / rate_hz
    low = int(np.ceil(low_hz * segment_s - _EDGE * shape.samples))
    high = int(np.floor(high_hz * segment_s + _EDGE * shape.samples))
    if not (shape.reach < low <= high < shape.samples // 2 - shape.reach):
        raise ValueError(
            f"segments of {segment_s:g} s at {rate_hz:g} Hz have lines {(shape.reach + 1) / segment_s:g} …"
            f" {(shape.samples // 2 - shape.reach - 1) / segment_s:g} Hz, found a band of {low_hz:g} …"
            f" {high_hz:g} Hz"
        )
    return np.arange(low - shape.reach, high + shape.reach + 1)
