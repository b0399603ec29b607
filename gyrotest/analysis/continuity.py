"""Continuity of a record: stretches without gaps, and readings that are stuck."""

import itertools
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

_BLOCK = 65536
_TOLERANCE = 0.5


@dataclass(frozen=True, slots=True, kw_only=True)
class Stretch:
    """Samples `start` … `stop - 1` of a record."""

    start: int
    stop: int

    @property
    def size(self) -> int:
        """Number of samples."""
        return self.stop - self.start


def stretches_by_index(index: NDArray[np.int64]) -> tuple[Stretch, ...]:
    """Gap-free stretches of samples by their positions on the acquisition's grid."""
    if index.size and int(index[-1]) - int(index[0]) == index.size - 1:
        return (Stretch(start=0, stop=index.size),)
    return _between(np.flatnonzero(np.diff(index) != 1), index.size)


def stretches_by_time(time_s: NDArray[np.float64], *, interval_s: float) -> tuple[Stretch, ...]:
    """Stretches of samples whose time stamps are one interval apart, to within half an interval."""
    breaks = [
        np.flatnonzero(
            np.abs(np.diff(time_s[begin : begin + _BLOCK + 1]) - interval_s) > _TOLERANCE * interval_s
        )
        + begin
        for begin in range(0, max(time_s.size - 1, 1), _BLOCK)
    ]
    return _between(np.concatenate(breaks), time_s.size)


def _between(breaks: NDArray[np.intp], size: int) -> tuple[Stretch, ...]:
    edges = [0, *(int(one) + 1 for one in breaks), size]
    return tuple(Stretch(start=a, stop=b) for a, b in itertools.pairwise(edges))


def stuck_stretch(values: NDArray[np.float64]) -> Stretch | None:
    """Find the longest run of one repeated value, where chance does not explain it; else None.

    Chance is judged by how often two neighbours are equal in the rest of the record (coarsely
    digitised noise repeats itself often, a voltmeter's hardly ever): a run is stuck if one like it
    is expected less than once in 10⁹ records.
    """
    equal, longest = 0, Stretch(start=0, stop=0)
    begin_of_run = 0
    for begin in range(0, values.size - 1, _BLOCK):
        piece = values[begin : begin + _BLOCK + 1]
        changes = np.flatnonzero(piece[1:] != piece[:-1]) + begin
        equal += piece.size - 1 - changes.size
        if changes.size:
            begins = np.concatenate(([begin_of_run], changes[:-1] + 1))
            lengths = changes + 1 - begins
            best = int(np.argmax(lengths))
            if lengths[best] > longest.size:
                longest = Stretch(start=int(begins[best]), stop=int(begins[best] + lengths[best]))
            begin_of_run = int(changes[-1]) + 1
    if values.size - begin_of_run > longest.size:
        longest = Stretch(start=begin_of_run, stop=values.size)
    return longest if _beyond_chance(longest.size, equal, values.size) else None


def _beyond_chance(length: int, equal_pairs: int, samples: int) -> bool:
    pairs = length - 1
    others = max(samples - length, 1)
    chance = max(equal_pairs - pairs, 1) / others
    return length >= 5 and chance < 1.0 and np.log(samples) + pairs * np.log(chance) < np.log(1e-9)
