"""From segments to one Parquet file: written aside, verified, renamed; only then they go."""

import logging
import os
from collections.abc import Iterable
from pathlib import Path

from gyrotest.errors import RecordingError
from gyrotest.recordings import parquet
from gyrotest.recordings.batches import read_batches, segment_files
from gyrotest.recordings.facts import Facts
from gyrotest.recordings.segment import sync_folder

_log = logging.getLogger(__name__)


def segments_to_parquet(folder: Path, target: Path, facts: Facts) -> None:
    """Convert a closed folder of segments, of which these facts are known, and remove it.

    Raises `RecordingError` or `OSError`; the segments then stay and nothing is left aside.
    """
    aside = target.with_name(f"{target.name}.part")
    files = segment_files(folder)
    try:
        parquet.write(aside, facts, (batch.rows for file in files for batch in read_batches(file)))
        _sync(aside)
        _verify(aside, facts.rows)
        if target.exists():
            raise RecordingError(f"{target}: exists; it is not overwritten")
        aside.rename(target)
    except BaseException:
        aside.unlink(missing_ok=True)
        raise
    sync_folder(target.parent)
    _remove(folder, files)


def _remove(folder: Path, files: Iterable[Path]) -> None:
    """Remove the segments; what cannot be removed does no harm, for the Parquet file is whole."""
    try:
        for file in files:
            file.unlink()
        folder.rmdir()
    except OSError as error:
        _log.warning("%s: could not be removed after the conversion: %s", folder, error)


def _verify(aside: Path, rows: int) -> None:
    found = sum(len(part) for part in parquet.iterate(aside))
    if found != rows:
        raise RecordingError(f"{aside}: {rows} rows were recorded, {found} are in the file")


def _sync(file: Path) -> None:
    with file.open("rb+") as stream:
        os.fsync(stream.fileno())
