"""From segments to one Parquet file: written aside, verified, renamed; only then they go."""

import os
import zlib
from collections.abc import Iterable
from pathlib import Path

import numpy as np

from gyrotest.errors import RecordingError
from gyrotest.recordings import parquet
from gyrotest.recordings.batches import read_batches, segment_files
from gyrotest.recordings.journal import Rows
from gyrotest.recordings.segment import sync_folder
from gyrotest.records.recording import Gap, RecordingHeader


def segments_to_parquet(
    folder: Path, target: Path, header: RecordingHeader, gaps: Iterable[Gap]
) -> None:
    """Convert a closed folder of segments and remove it.

    Raises `RecordingError` or `OSError`; the segments then stay and nothing is left aside.
    """
    aside = target.with_name(f"{target.name}.part")
    files = segment_files(folder)
    written = _Content()
    try:
        rows = (written.seen(batch.rows) for file in files for batch in read_batches(file))
        parquet.write(aside, header, gaps, rows)
        _sync(aside)
        _verify(aside, written)
        if target.exists():
            raise RecordingError(f"{target}: exists; it is not overwritten")
        aside.rename(target)
    except BaseException:
        aside.unlink(missing_ok=True)
        raise
    sync_folder(target.parent)
    for file in files:
        file.unlink()
    folder.rmdir()


class _Content:
    """Number of rows and a running CRC-32 of each column, whatever the batches."""

    def __init__(self) -> None:
        self.rows = 0
        self.crcs: list[int] = []

    def seen(self, rows: Rows) -> Rows:
        """Count rows in, and hand them on."""
        columns = [rows.index, rows.time_s, *rows.values.T, rows.flags]
        crcs = self.crcs or [0] * len(columns)
        self.crcs = [
            zlib.crc32(np.ascontiguousarray(column).data, crc)
            for column, crc in zip(columns, crcs, strict=True)
        ]
        self.rows += len(rows)
        return rows


def _verify(aside: Path, written: _Content) -> None:
    found = _Content()
    for rows in parquet.iterate(aside):
        found.seen(rows)
    if found.rows != written.rows or (found.rows and found.crcs != written.crcs):
        raise RecordingError(
            f"{aside}: reads back {found.rows} of {written.rows} rows, or other values than were written"
        )


def _sync(file: Path) -> None:
    with file.open("rb+") as stream:
        os.fsync(stream.fileno())
