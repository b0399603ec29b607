"""The samples of a vibration's dwells, block by block, and what of them is counted on the way."""

from collections.abc import Iterator
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from gyrotest.analysis.continuity import stretches_by_index
from gyrotest.errors import InsufficientDataError
from gyrotest.records.recording import Dwell, SampleFlag, Samples, SampleStream

_CLIPPED_LEAST, _CLIPPED_MORE, _CLIPPED_RUN = 5, 6, 3


@dataclass(frozen=True, slots=True, kw_only=True)
class Stretch:
    """Consecutive samples of a dwell, the `number`th of the recording: values (n, columns) and flags (n,).

    `first` is the position of the first one; `begins` says that it does not go on from the stretch before.
    """

    number: int
    first: int
    begins: bool
    values: NDArray[np.float64]
    flags: NDArray[np.uint8]


def stretches(stream: SampleStream, dwells: tuple[Dwell, ...]) -> Iterator[Stretch]:
    """Give the dwells' samples in their order, block by block, cut where samples are missing."""
    expected, last = -1, -1
    for samples in stream.blocks():
        places = _places(samples)
        for number, dwell in enumerate(dwells):
            start, stop = np.searchsorted(places, (dwell.first, dwell.first + dwell.samples))
            if start == stop:
                continue
            for one in stretches_by_index(places[start:stop]):
                cut = slice(start + one.start, start + one.stop)
                first = int(places[cut.start])
                yield Stretch(
                    number=number,
                    first=first,
                    begins=first != expected or number != last,
                    values=samples.values[cut],
                    flags=samples.flags[cut],
                )
                expected, last = first + one.size, number


def _places(samples: Samples) -> NDArray[np.int64]:
    if samples.index is None:
        raise InsufficientDataError("a block of samples has no positions; read it as a stream")
    return samples.index


@dataclass
class _Extreme:
    """The greatest level so far, how often it was there and in how many runs, and how often the next one was."""

    level: float = -np.inf
    count: int = 0
    runs: int = 0
    next_level: float = -np.inf
    next_count: int = 0

    def push(self, values: NDArray[np.float64]) -> None:
        """Look at further values."""
        level = float(values.max())
        if level < self.next_level:
            return
        there = values == level
        runs = int(there[0]) + int(np.count_nonzero(there[1:] & ~there[:-1]))
        self._put(level, int(np.count_nonzero(there)), runs)
        below = values[~there]
        if below.size:
            beside = float(below.max())
            self._put(beside, int(np.count_nonzero(below == beside)), 0)

    def _put(self, level: float, count: int, runs: int) -> None:
        if level > self.level:
            self.next_level, self.next_count = self.level, self.count
            self.level, self.count, self.runs = level, count, runs
        elif level == self.level:
            self.count += count
            self.runs += runs
        elif level > self.next_level:
            self.next_level, self.next_count = level, count
        elif level == self.next_level:
            self.next_count += count

    @property
    def clipped(self) -> bool:
        """Whether the signal rests here, far more often than next to it: no sine and no noise does that."""
        rests = self.count >= _CLIPPED_LEAST and self.count >= _CLIPPED_RUN * self.runs
        return rests and self.count > _CLIPPED_MORE * self.next_count


@dataclass
class DwellTally:
    """What was found in a dwell; extremes are those of the output as it is indicated."""

    dwell: Dwell
    present: int = 0
    stretches: int = 0
    flagged: dict[SampleFlag, int] = field(default_factory=dict)
    first_flagged: int | None = None
    unreadable: int = 0
    greatest: _Extreme = field(default_factory=_Extreme)
    least: _Extreme = field(default_factory=_Extreme)

    @property
    def missing(self) -> int:
        """How many of its samples are not there."""
        return self.dwell.samples - self.present

    @property
    def moves(self) -> bool:
        """Whether the table was driven."""
        return bool(self.dwell.vibration_dps)

    def push(self, stretch: Stretch) -> None:
        """Count further samples."""
        self.present += stretch.flags.size
        self.stretches += stretch.begins
        if stretch.flags.any():
            self._count_flags(stretch)
        output = stretch.values[:, 0]
        self.unreadable += int(np.count_nonzero(~np.isfinite(stretch.values)))
        self.greatest.push(output)
        self.least.push(-output)

    def _count_flags(self, stretch: Stretch) -> None:
        if self.first_flagged is None:
            self.first_flagged = stretch.first + int(np.flatnonzero(stretch.flags)[0])
        for flag in SampleFlag:
            count = int(np.count_nonzero(stretch.flags & np.uint8(flag))) if flag else 0
            if count:
                self.flagged[flag] = self.flagged.get(flag, 0) + count
