"""Skew of channels: columns that one clock samples one after another, brought to one instant."""

from collections.abc import Sequence

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from numpy.typing import NDArray

_HALF = 12
_KAISER = 12.0
_NONE = 1e-9


class Aligner:
    """Brings columns to the instants of the first one, block by block.

    Parameters
    ----------
    offsets_s
        How much later than the first column each one is sampled, s, the first among them (0); may be
        negative, and longer than an interval.
    interval_s
        Time between two samples of a column, s.

    Notes
    -----
    S4.8. Each column passes a delay of a fraction of an interval: a sinc of 25 samples under a Kaiser
    window, which errs by less than 2·10⁻⁵ of a sine's amplitude up to 0.6 of half the sampling rate and
    leaves constants as they are. Where there is no skew, rows are given back as they come.
    """

    def __init__(self, offsets_s: Sequence[float], interval_s: float) -> None:
        delays = np.asarray(offsets_s, dtype=np.float64) / interval_s
        delays -= delays[0]
        self._whole = np.rint(delays).astype(np.int64)
        parts = delays - self._whole
        self._taps = tuple(None if abs(part) < _NONE else delay_taps(float(part)) for part in parts)
        skewed = bool(np.abs(delays).max() >= _NONE)
        self._lost = _HALF + int(np.abs(self._whole).max()) if skewed else 0
        self._held = np.empty((0, delays.size))

    @property
    def lost(self) -> int:
        """Samples at either end of a stretch that are not given back: row 0 given is row `lost` put in."""
        return self._lost

    def push(self, values: NDArray[np.float64]) -> NDArray[np.float64]:
        """Take rows (n, columns) and return those (m, columns) that are complete by now."""
        if not self._lost:
            return values
        held = np.concatenate((self._held, values))
        self._held = held[-2 * self._lost :]
        ready = max(held.shape[0] - 2 * self._lost, 0)
        aligned = np.empty((held.shape[1], ready))
        for column, taps in enumerate(self._taps):
            aligned[column] = self._delayed(held[:, column], taps, int(self._whole[column]), ready)
        return aligned.T

    def reset(self) -> None:
        """Begin a new stretch: what comes is not joined to what came before."""
        self._held = self._held[:0]

    def _delayed(
        self, column: NDArray[np.float64], taps: NDArray[np.float64] | None, whole: int, ready: int
    ) -> NDArray[np.float64]:
        begin = self._lost - whole
        if taps is None or not ready:
            return column[begin : begin + ready]
        needed = np.ascontiguousarray(column[begin - _HALF : begin + ready + _HALF])
        delayed: NDArray[np.float64] = sliding_window_view(needed, taps.size) @ taps[::-1]
        return delayed


def delay_taps(delay: float) -> NDArray[np.float64]:
    """Return the impulse response (25,) of a delay by −½ … ½ samples beside the whole 12 of its middle."""
    times = np.arange(-_HALF, _HALF + 1) - delay
    window = np.i0(_KAISER * np.sqrt(1.0 - (times / (_HALF + 1)) ** 2))
    taps = np.sinc(times) * window
    return np.asarray(taps / taps.sum(), dtype=np.float64)
