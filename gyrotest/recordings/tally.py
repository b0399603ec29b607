"""The running tally of a recording: rows, gaps, flags and lateness, batch by batch."""

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from gyrotest.recordings.journal import Rows
from gyrotest.records.recording import Gap

MISSING = "samples are missing"


@dataclass(slots=True)
class Tally:
    """Counts over the rows seen so far. `reasons` names a gap by the sample that it follows."""

    interval_s: float
    rows: int = 0
    last_index: int = -1
    flagged: int = 0
    largest_lateness_s: float | None = None
    gaps: list[Gap] = field(default_factory=list)
    reasons: dict[int, str] = field(default_factory=dict)

    def add(self, rows: Rows) -> None:
        """Count rows."""
        if not len(rows):
            return
        self.gaps += gaps_in(rows.index, after=self.last_index, reasons=self.reasons)
        self.last_index = int(rows.index[-1])
        self.rows += len(rows)
        self.flagged += int(np.count_nonzero(rows.flags))
        lateness_s = float(np.max(rows.time_s - rows.index * self.interval_s))
        if self.largest_lateness_s is None or lateness_s > self.largest_lateness_s:
            self.largest_lateness_s = lateness_s


def gaps_in(
    index: NDArray[np.int64], *, after: int = -1, reasons: dict[int, str] | None = None
) -> tuple[Gap, ...]:
    """The gaps in growing positions that follow sample `after` (-1: from the grid's begin)."""
    steps = np.diff(index, prepend=after)
    found = np.flatnonzero(steps > 1)
    before = index[found] - steps[found]
    return tuple(
        Gap(after=int(last), missing=int(step) - 1, reason=(reasons or {}).get(int(last), MISSING))
        for last, step in zip(before, steps[found], strict=True)
    )
