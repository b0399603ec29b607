"""A column of a file as one array in memory, read once."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gyrotest.offline.sources import Source
from gyrotest.recordings.formats.detect import read_parts
from gyrotest.recordings.formats.selection import Selection

Watch = Callable[[int], None]
"""Is told how many rows have been read so far."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Column:
    """A column's numbers as they stand in the file, shape (n,).

    `row` are their rows, from 0, where some are missing between them; `time_s` their time stamps,
    where a time column was asked for.
    """

    values: NDArray[np.float64]
    row: NDArray[np.int64] | None
    time_s: NDArray[np.float64] | None


def read_column(
    source: Source, selection: Selection, watch: Watch, *, time_unit_s: float = 1.0
) -> Column:
    """Read a column; `time_unit_s` is that of time stamps which are no dates; raises `RecordingError`."""
    values: list[NDArray[np.float64]] = []
    times: list[NDArray[np.float64]] = []
    rows = _Rows()
    for part in read_parts(source.path, selection):
        if part.row.size:
            rows.add(part.row)
            values.append(part.values)
            stamps_s = part.time_s(time_unit_s)
            if stamps_s is not None:
                times.append(stamps_s)
            watch(rows.count)
    return Column(
        values=_joined(values, rows.count),
        row=rows.if_any_is_missing(),
        time_s=_joined(times, rows.count) if times else None,
    )


class _Rows:
    """The numbers of the rows; they are kept only from where the first one is missing."""

    def __init__(self) -> None:
        self.count = 0
        self._first = 0
        self._parts: list[NDArray[np.int64]] = []

    def add(self, row: NDArray[np.int64]) -> None:
        if not self.count:
            self._first = int(row[0])
        follows = int(row[0]) == self._first + self.count and int(row[-1]) - int(row[0]) == row.size - 1
        if self._parts or not follows:
            if not self._parts:
                self._parts.append(np.arange(self._first, self._first + self.count, dtype=np.int64))
            self._parts.append(row)
        self.count += row.size

    def if_any_is_missing(self) -> NDArray[np.int64] | None:
        return np.concatenate(self._parts) if self._parts else None


def _joined(parts: list[NDArray[np.float64]], size: int) -> NDArray[np.float64]:
    """Lay the parts behind one another, each let go as soon as it is copied."""
    whole = np.empty(size)
    end = size
    while parts:
        part = parts.pop()
        whole[end - part.size : end] = part
        end -= part.size
    return whole
