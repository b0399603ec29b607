"""Samples at places on a grid: averaged by groups of places, and cut where a place is missing."""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True, slots=True, kw_only=True)
class Placed:
    """Samples and their places, which grow; `time_s` on the file's own scale, `values` (n, columns)."""

    place: NDArray[np.int64]
    time_s: NDArray[np.float64]
    values: NDArray[np.float64]
    flags: NDArray[np.uint8]

    def __len__(self) -> int:
        return int(self.place.size)

    def part(self, rows: slice | NDArray[np.bool_]) -> "Placed":
        """Some of the samples."""
        return Placed(
            place=self.place[rows],
            time_s=self.time_s[rows],
            values=self.values[rows],
            flags=self.flags[rows],
        )


class Averages:
    """The mean of every `size` places.

    A group that lacks one has no mean and is counted, save for an unfinished one at the end.
    """

    def __init__(self, size: int) -> None:
        self.incomplete = 0
        self._size = size

    def of(self, parts: Iterable[Placed]) -> Iterator[Placed]:
        """Yield the means part by part."""
        if self._size == 1:
            yield from parts
            return
        carried: Placed | None = None
        for part in parts:
            samples = part if carried is None else joined(carried, part)
            if not len(samples):
                continue
            groups = samples.place // self._size
            begins = int(np.searchsorted(groups, groups[-1]))
            # The last group may go on in the next part.
            carried = samples.part(slice(begins, None))
            yield self._means(samples.part(slice(0, begins)))
        if carried is not None and len(carried) == self._size:
            yield self._means(carried)

    def _means(self, samples: Placed) -> Placed:
        if not len(samples):
            return samples
        groups, begins, counts = np.unique(
            samples.place // self._size, return_index=True, return_counts=True
        )
        whole = counts == self._size
        self.incomplete += int(np.count_nonzero(~whole))
        means = Placed(
            place=groups,
            time_s=samples.time_s[begins],
            values=np.add.reduceat(samples.values, begins, axis=0) / self._size,
            flags=np.bitwise_or.reduceat(samples.flags, begins),
        )
        return means.part(whole)


def joined(first: Placed, second: Placed) -> Placed:
    """Two parts as one."""
    return Placed(
        place=np.concatenate([first.place, second.place]),
        time_s=np.concatenate([first.time_s, second.time_s]),
        values=np.concatenate([first.values, second.values]),
        flags=np.concatenate([first.flags, second.flags]),
    )


def consecutive(samples: Placed) -> Iterator[Placed]:
    """Yield the stretches without a missing place."""
    cuts = np.flatnonzero(np.diff(samples.place) != 1) + 1
    edges = [0, *cuts.tolist(), len(samples)]
    for begin, end in pairwise(edges):
        if end > begin:
            yield samples.part(slice(begin, end))
