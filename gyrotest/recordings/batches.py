"""The batches of segments: read one by one, every checksum verified."""

import contextlib
import json
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from gyrotest.errors import RecordingError
from gyrotest.recordings.journal import Rows
from gyrotest.recordings.layout import (
    BATCH_CRC,
    BATCH_OUTCOME,
    BATCH_ROW,
    BATCH_UTC,
    SEGMENT_KEY,
    SEGMENT_SUFFIX,
    checksum,
    columns_of,
    header_from_metadata,
    recording_schema,
)
from gyrotest.records.recording import RecordingHeader

if TYPE_CHECKING:
    import pyarrow as pa


@dataclass(frozen=True, slots=True, kw_only=True)
class Opening:
    """What a segment's schema says: the recording's header, its first row, why it was begun."""

    header: RecordingHeader
    row: int
    reason: str


@dataclass(frozen=True, slots=True, kw_only=True)
class Batch:
    """A batch that was read whole: its rows, and the word that ends a segment (or nothing)."""

    rows: Rows
    outcome: str


def segment_files(folder: Path) -> tuple[Path, ...]:
    """The segments of a recording in their order; raises `RecordingError` if there is none."""
    files = tuple(sorted(folder.glob(f"*{SEGMENT_SUFFIX}")))
    if not files:
        raise RecordingError(f"{folder}: holds no segment of a recording (*{SEGMENT_SUFFIX})")
    return files


def read_opening(file: Path) -> Opening:
    """The header of a segment; raises `RecordingError`."""
    with _reader(file) as stream:
        return _opening(stream.schema, file)


def read_batches(file: Path) -> Iterator[Batch]:
    """The batches of a segment in their order; raises `RecordingError` at the first damaged one."""
    with _reader(file) as stream:
        opening = _opening(stream.schema, file)
        row = opening.row
        while (found := _next(stream, file, row)) is not None:
            batch = _checked(*found, file, row)
            yield batch
            row += len(batch.rows)


@contextlib.contextmanager
def _reader(file: Path) -> Iterator[Any]:
    """The open stream, and the file beneath, which a stream does not close by itself."""
    import pyarrow as pa

    with contextlib.ExitStack() as opened:
        try:
            source = opened.enter_context(pa.OSFile(str(file), "rb"))
            stream = opened.enter_context(pa.ipc.open_stream(source))
        except (pa.ArrowException, OSError, ValueError) as error:
            raise RecordingError(f"{file}: cannot be read as a segment: {said(error)}") from error
        yield stream


def _next(stream: Any, file: Path, row: int) -> tuple[Any, Any] | None:
    import pyarrow as pa

    try:
        found: tuple[Any, Any] = stream.read_next_batch_with_custom_metadata()
    except StopIteration:
        return None
    except (pa.ArrowException, OSError, ValueError, MemoryError) as error:
        raise RecordingError(f"{file}: damaged after row {row}: {said(error)}") from error
    return found


def _opening(of: "pa.Schema", file: Path) -> Opening:
    try:
        header = header_from_metadata(of.metadata)
        place = json.loads(of.metadata[SEGMENT_KEY])
    except (RecordingError, KeyError, ValueError) as error:
        raise RecordingError(f"{file}: {error}") from error
    if not of.equals(recording_schema(header, {})):
        raise RecordingError(f"{file}: damaged: its columns are not those that its header names")
    return Opening(header=header, row=place["row"], reason=place["reason"])


def _checked(batch: Any, metadata: Any, file: Path, row: int) -> Batch:
    stamp: dict[bytes, bytes] = dict(metadata or {})
    try:
        columns = columns_of(batch)
        utc, outcome = stamp[BATCH_UTC].decode(), stamp[BATCH_OUTCOME].decode()
    except (RecordingError, KeyError, ValueError) as error:
        raise RecordingError(f"{file}: damaged after row {row}: {said(error)}") from error
    crc = b"%08x" % checksum(columns, row, utc, outcome)
    if stamp.get(BATCH_CRC) != crc or stamp.get(BATCH_ROW) != b"%d" % row:
        raise RecordingError(f"{file}: damaged after row {row}: the batch's checksum does not agree")
    return Batch(rows=rows_of_columns(columns), outcome=outcome)


def rows_of_columns(columns: list[NDArray[Any]]) -> Rows:
    """The rows that a batch's columns make."""
    index, time_s, *values, flags = columns
    return Rows(index=index, time_s=time_s, values=np.stack(values, axis=1), flags=flags)


def said(error: BaseException) -> str:
    """The first line of what an error says."""
    return (str(error) or type(error).__name__).splitlines()[0]
