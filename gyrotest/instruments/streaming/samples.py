"""Numbered readings to samples of the grid: means of so many readings each, in blocks without gaps."""

import math

import numpy as np
from numpy.typing import NDArray

from gyrotest.instruments.streaming.readings import Readings, joined
from gyrotest.records.recording import Block


class Sampler:
    """Averages `size` readings to a sample; a sample of which a reading is missing is missing."""

    def __init__(self, size: int, interval_s: float) -> None:
        self._size, self._interval_s = size, interval_s
        self.lost = self.gaps = 0
        self.begin(0, 0)

    def begin(self, first: int, end: int) -> None:
        """Samples `first` … `end - 1` are asked for from now on."""
        self.position, self._end = first, end
        self._parts: list[Readings] = []
        self._numbers: list[NDArray[np.int64]] = []

    def push(self, readings: Readings, numbers: NDArray[np.int64]) -> list[Block]:
        """Take numbered readings; returns the samples that are complete, each block without a gap."""
        self._parts.append(readings)
        self._numbers.append(numbers)
        sample_of_last = (int(numbers[-1]) + 1) // self._size
        if sample_of_last <= self.position:
            return []
        gathered, at = joined(self._parts), np.concatenate(self._numbers)
        ready = int(np.searchsorted(at, sample_of_last * self._size))
        self._parts, self._numbers = [gathered.part(slice(ready, None))], [at[ready:]]
        wanted = (at >= self.position * self._size) & (at < self._end * self._size)
        chosen = np.flatnonzero(wanted[:ready])
        part = slice(int(chosen[0]), int(chosen[-1]) + 1) if len(chosen) else slice(0, 0)
        blocks = self._blocks(gathered.part(part), at[part])
        self._tell_missing(blocks, min(sample_of_last, self._end))
        return blocks

    def _tell_missing(self, blocks: list[Block], end: int) -> None:
        """Count samples that are missing before, between and behind the blocks."""
        for block in blocks:
            self._miss(block.first - self.position)
            self.position = block.first + len(block.flags)
        self._miss(end - self.position)
        self.position = end

    def _miss(self, count: int) -> None:
        self.lost += count
        self.gaps += count > 0

    def _blocks(self, readings: Readings, numbers: NDArray[np.int64]) -> list[Block]:
        values, flags, sample = readings.values, readings.flags, numbers
        if self._size > 1:
            sample, begins, counts = np.unique(
                numbers // self._size, return_index=True, return_counts=True
            )
            complete = counts == self._size
            if len(sample):
                values = np.add.reduceat(values, begins, axis=0)[complete] / self._size
                flags = np.bitwise_or.reduceat(flags, begins)[complete]
            sample = sample[complete]
        if not len(sample):
            return []
        edges = np.flatnonzero(np.diff(sample) != 1) + 1
        bounds = zip((0, *edges.tolist()), (*edges.tolist(), len(sample)), strict=True)
        return [self._block(sample[a:b], values[a:b], flags[a:b]) for a, b in bounds]

    def _block(
        self, sample: NDArray[np.int64], values: NDArray[np.float64], flags: NDArray[np.uint8]
    ) -> Block:
        return Block(
            first=int(sample[0]),
            time_s=sample.astype(np.float64) * self._interval_s,
            values=values,
            flags=flags,
        )


def readings_in(interval_s: float, period_s: float) -> int:
    """How many readings make a sample; 0 where the interval is no whole multiple of the period."""
    size = round(interval_s / period_s)
    return size if size >= 1 and math.isclose(size * period_s, interval_s, rel_tol=1e-6) else 0
