"""The noise of a simulated generator: low-passed, and the same however many samples are asked for at a time."""

import math

import numpy as np
from numpy.typing import NDArray

from gyrotest.simulation.streams import generator

_BLOCK = 1 << 16
_ORDER = 4
# Nearer to half the sampling rate a low-pass is not worth its name.
_FILTERED_BELOW = 0.45
# What a filter remembers of the samples before so many of its slowest time constants is nothing.
_MEMORY = 40.0


class BandNoise:
    """White Gaussian noise of one rms V up to a bandwidth, at the positions of a grid of samples.

    Whole blocks of samples are made, each from a stream of its own, with the filter run in over the block
    before: any order and any number of samples give the same values. Above half the sampling rate there
    is no noise; its share is missing.
    """

    def __init__(
        self, seed: int, names: tuple[str | int, ...], *, bandwidth_hz: float, interval_s: float
    ) -> None:
        self._seed = seed
        self._names = names
        self._filter: NDArray[np.float64] | None = None
        self._run_in = 0
        self._level = math.sqrt(min(1.0, 0.5 / (interval_s * bandwidth_hz)))
        if bandwidth_hz * interval_s < _FILTERED_BELOW:
            self._set_filter(bandwidth_hz * interval_s)
        self._block = _BLOCK * max(1, math.ceil(self._run_in / _BLOCK))
        self._kept: dict[int, NDArray[np.float64]] = {}
        self._made: dict[int, NDArray[np.float64]] = {}

    def take(self, first: int, count: int) -> NDArray[np.float64]:
        """The noise at the positions `first` … `first + count - 1`, which may be negative, (count,), V."""
        taken = np.empty(count)
        done = 0
        while done < count:
            number, start = divmod(first + done, self._block)
            size = min(count - done, self._block - start)
            taken[done : done + size] = self._noise(number)[start : start + size]
            done += size
        return taken

    def _set_filter(self, cycles: float) -> None:
        from scipy.signal import butter, sos2zpk, sosfilt

        self._filter = np.asarray(butter(_ORDER, 2.0 * cycles, output="sos"))
        _, poles, _ = sos2zpk(self._filter)
        self._run_in = math.ceil(-_MEMORY / math.log(float(np.abs(poles).max())))
        impulse = np.zeros(self._run_in)
        impulse[0] = 1.0
        response = sosfilt(self._filter, impulse)
        self._level = 1.0 / math.sqrt(float(response @ response))

    def _noise(self, number: int) -> NDArray[np.float64]:
        made = self._made.get(number)
        if made is None:
            made = self._level * self._passed(number)
            # A block is asked for in pieces, one after the other.
            self._made = {number: made}
        return made

    def _passed(self, number: int) -> NDArray[np.float64]:
        white = self._white(number)
        if self._filter is None:
            return white
        from scipy.signal import sosfilt

        before = self._kept.get(number - 1)
        if before is None:
            before = self._white(number - 1)
        run_in = before[self._block - self._run_in :]
        passed: NDArray[np.float64] = sosfilt(self._filter, np.concatenate([run_in, white]))
        self._kept = {number: white}
        return passed[self._run_in :]

    def _white(self, number: int) -> NDArray[np.float64]:
        return generator(self._seed, "exciter noise", *self._names, number).standard_normal(self._block)
