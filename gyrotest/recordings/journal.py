"""The journal of a running recording: a folder of segments, one batch after the other."""

import json
from collections.abc import Callable
from dataclasses import dataclass
from datetime import datetime
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from gyrotest.recordings.layout import (
    BATCH_CRC,
    BATCH_OUTCOME,
    BATCH_ROW,
    BATCH_UTC,
    SEGMENT_KEY,
    SEGMENT_SUFFIX,
    batch_of,
    checksum,
    recording_schema,
)
from gyrotest.recordings.segment import Segment, sync_folder
from gyrotest.records.recording import Block, RecordingHeader

if TYPE_CHECKING:
    import pyarrow as pa


@dataclass(frozen=True, slots=True, kw_only=True)
class Rows:
    """Rows of a recording: positions, times, values (n, channels) and flags."""

    index: NDArray[np.int64]
    time_s: NDArray[np.float64]
    values: NDArray[np.float64]
    flags: NDArray[np.uint8]

    def __len__(self) -> int:
        return int(self.index.size)


def rows_of(blocks: list[Block]) -> Rows:
    """Blocks put together."""
    return Rows(
        index=np.concatenate(
            [np.arange(b.first, b.first + len(b.flags), dtype=np.int64) for b in blocks]
        ),
        time_s=np.concatenate([np.asarray(b.time_s, dtype=np.float64) for b in blocks]),
        values=np.concatenate([np.asarray(b.values, dtype=np.float64) for b in blocks]),
        flags=np.concatenate([np.asarray(b.flags, dtype=np.uint8) for b in blocks]),
    )


class Journal:
    """Segments in a new folder. Whatever fails raises `OSError` and leaves the batches before it."""

    def __init__(self, folder: Path, header: RecordingHeader, utc: Callable[[], datetime]) -> None:
        self.rows = 0
        self._folder, self._header, self._utc = folder, header, utc
        self._segments = 0
        self._segment: Segment | None = None
        self._schema: pa.Schema | None = None

    def begin(self, reason: str = "") -> None:
        """Open the next segment; `reason` says why the one before ended."""
        place = {"number": self._segments, "row": self.rows, "reason": reason}
        text = json.dumps(place, ensure_ascii=False).encode()
        self._schema = recording_schema(self._header, {SEGMENT_KEY: text})
        self._segment = Segment(self._folder / f"{self._segments:04d}{SEGMENT_SUFFIX}", self._schema)
        self._segments += 1
        self.sync()

    def append(self, rows: Rows) -> None:
        """Write rows as a batch and hand it to the operating system."""
        columns = [rows.index, rows.time_s, *np.ascontiguousarray(rows.values.T), rows.flags]
        self._write(columns, "")
        self.rows += len(rows)

    def sync(self) -> None:
        """Have everything put on the disk."""
        if self._segment is not None:
            self._segment.sync()
            sync_folder(self._folder)

    def end(self, outcome: str) -> None:
        """End the open segment with the word that says why; nothing may follow in it."""
        if self._segment is not None:
            empty = np.empty(0)
            columns = [empty.astype(np.int64), *[empty] * (1 + len(self._header.sampling.columns))]
            self._write([*columns, empty.astype(np.uint8)], outcome)
            self._segment.finish()
            self._segment = None

    def abandon(self) -> None:
        """Close the open segment as it is."""
        if self._segment is not None:
            self._segment.abandon()
            self._segment = None

    def _write(self, columns: list[NDArray[np.generic]], outcome: str) -> None:
        if self._segment is None:
            raise OSError("no segment is open")
        utc = self._utc().isoformat()
        crc = checksum(columns, self.rows, utc, outcome)
        self._segment.append(
            batch_of(columns, self._schema),
            {
                BATCH_ROW: b"%d" % self.rows,
                BATCH_UTC: utc.encode(),
                BATCH_OUTCOME: outcome.encode(),
                BATCH_CRC: b"%08x" % crc,
            },
        )
