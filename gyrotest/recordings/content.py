"""The content of a recording in short: its rows and a CRC-32 of each column, whatever the batches."""

import json
import zlib
from collections.abc import Iterable, Iterator, Sequence

import numpy as np

from gyrotest.recordings.journal import Rows


class Content:
    """What passed so far."""

    def __init__(self) -> None:
        self.rows = 0
        self._crcs: list[int] = []

    def agrees(self, kept: bytes, columns: Sequence[int] | None) -> bool:
        """Whether this is what was kept; of a part of the values' columns, by their places: as far as it goes.

        Raises `ValueError`, `KeyError` or `IndexError`.
        """
        if columns is None or not self.rows:
            return kept == self.to_json()
        found = json.loads(kept)
        crcs: list[str] = found["crc32"]
        wanted = [crcs[0], crcs[1], *(crcs[2 + place] for place in columns), crcs[-1]]
        return bool(found["rows"] == self.rows and wanted == [f"{crc:08x}" for crc in self._crcs])

    def watch(self, parts: Iterable[Rows]) -> Iterator[Rows]:
        """Hand rows on and count them in."""
        for rows in parts:
            self._add(rows)
            yield rows

    def to_json(self) -> bytes:
        """Return the content as JSON, to be kept and compared."""
        crcs = [f"{crc:08x}" for crc in self._crcs] if self.rows else []
        return json.dumps({"rows": self.rows, "crc32": crcs}).encode()

    def _add(self, rows: Rows) -> None:
        columns = [rows.index, rows.time_s, *rows.values.T, rows.flags]
        crcs = self._crcs or [0] * len(columns)
        self._crcs = [
            zlib.crc32(np.ascontiguousarray(column).data, crc)
            for column, crc in zip(columns, crcs, strict=True)
        ]
        self.rows += len(rows)


def rows_in_json(text: bytes) -> int:
    """Return the number of rows in a content's JSON; raises `ValueError` or `KeyError`."""
    return int(json.loads(text)["rows"])
