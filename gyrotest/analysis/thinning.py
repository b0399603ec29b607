"""A few samples of a long record, picked evenly from all of it while it streams by."""

import numpy as np
from numpy.typing import NDArray

_GOLDEN = (5.0**0.5 - 1.0) / 2.0


class Thinned:
    """At most so many rows of all that were pushed, from all over the record.

    The distance from pick to pick wanders (by the golden ratio), so that no rhythm of the record is picked
    at one phase alone.
    """

    def __init__(self, *, columns: int, most: int) -> None:
        self._most = most
        self._every = 1
        self._seen = 0
        self._rows = np.empty((0, columns))

    @property
    def columns(self) -> NDArray[np.float64]:
        """The columns (columns, m) of the rows that were picked."""
        return np.ascontiguousarray(self._rows.T)

    @property
    def rows(self) -> NDArray[np.float64]:
        """The rows (m, columns) that were picked."""
        return self._rows

    def push(self, *columns: NDArray[np.float64]) -> None:
        """Take further samples of each column, all (n,)."""
        picks = self._picks(columns[0].size)
        self._keep(np.stack([one[picks] for one in columns], axis=1), columns[0].size)

    def push_rows(self, rows: NDArray[np.float64]) -> None:
        """Take further rows (n, columns)."""
        self._keep(rows[self._picks(rows.shape[0])], rows.shape[0])

    def _keep(self, picked: NDArray[np.float64], size: int) -> None:
        self._rows = np.concatenate((self._rows, picked))
        self._seen += size
        while self._rows.shape[0] > self._most:
            self._rows, self._every = self._rows[::2], 2 * self._every

    def _picks(self, size: int) -> NDArray[np.int64]:
        ordinals = np.arange(self._seen // self._every, (self._seen + size) // self._every + 1)
        places = (ordinals * self._every + (ordinals * _GOLDEN % 1.0) * self._every).astype(np.int64)
        places -= self._seen
        return places[(places >= 0) & (places < size)]
