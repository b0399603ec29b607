"""The assembly of a recording's samples in memory, in arrays made once."""

import numpy as np
from numpy.typing import NDArray

from gyrotest.recordings.journal import Rows
from gyrotest.records.recording import Samples, Sampling


class Assembly:
    """Arrays for `rows` rows, filled part by part. Positions are kept only if one is missing."""

    def __init__(self, rows: int, columns: int, *, own_time: bool) -> None:
        # Column by column: who works on one axis finds its samples side by side.
        self._values = np.empty((columns, rows)).T
        self._flags = np.empty(rows, dtype=np.uint8)
        self._time_s = np.empty(rows) if own_time else None
        self._index: NDArray[np.int64] | None = None
        self._filled = 0

    def add(self, rows: Rows) -> None:
        """Put the next rows in place."""
        if not len(rows):
            return
        place = slice(self._filled, self._filled + len(rows))
        self._values[place], self._flags[place] = rows.values, rows.flags
        if self._time_s is not None:
            self._time_s[place] = rows.time_s
        if self._index is None and int(rows.index[-1]) != place.stop - 1:
            self._index = np.arange(self._flags.size, dtype=np.int64)
        if self._index is not None:
            self._index[place] = rows.index
        self._filled = place.stop

    def samples(self, sampling: Sampling) -> Samples:
        """The samples, read-only."""
        for array in (self._values, self._flags, self._time_s, self._index):
            if array is not None:
                array.flags.writeable = False
        return Samples(
            sampling=sampling,
            values=self._values,
            flags=self._flags,
            index=self._index,
            time_s=self._time_s,
        )
