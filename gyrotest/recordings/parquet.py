"""A recording as a Parquet file: written aside batch by batch, and read batch by batch."""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from gyrotest.errors import RecordingError
from gyrotest.recordings.batches import rows_of_columns, said
from gyrotest.recordings.content import Content, rows_in_json
from gyrotest.recordings.journal import Rows
from gyrotest.recordings.layout import (
    BATCH_ROWS,
    CONTENT_KEY,
    GAPS_KEY,
    columns_of,
    gaps_from_json,
    gaps_to_json,
    header_from_metadata,
    recording_schema,
)
from gyrotest.records.recording import Gap, RecordingHeader

# A row group per this many rows: what the writer and the reader hold in memory.
_GROUP_ROWS = 4 * BATCH_ROWS


@dataclass(frozen=True, slots=True, kw_only=True)
class Facts:
    """What the file's footer says."""

    header: RecordingHeader
    rows: int
    gaps: tuple[Gap, ...]


def read_facts(path: Path) -> Facts:
    """Header, number of rows and gaps of a Parquet recording; raises `RecordingError`."""
    with _open(path) as file:
        try:
            metadata = file.schema_arrow.metadata
            header = header_from_metadata(metadata)
            gaps = gaps_from_json(metadata.get(GAPS_KEY, b"[]"))
            rows = rows_in_json((file.metadata.metadata or {}).get(CONTENT_KEY, b"{}"))
        except (RecordingError, ValueError, KeyError) as error:
            raise RecordingError(f"{path}: {said(error)}") from error
        if rows != file.metadata.num_rows:
            raise RecordingError(f"{path}: damaged: of {rows} rows {file.metadata.num_rows} are there")
        return Facts(header=header, rows=rows, gaps=gaps)


def iterate(path: Path) -> Iterator[Rows]:
    """The rows of a Parquet recording, every checksum verified; raises `RecordingError`.

    That of the whole content is known when the last row was given.
    """
    import pyarrow as pa

    content = Content()
    with _open(path) as file:
        try:
            batches = file.iter_batches(batch_size=BATCH_ROWS, use_threads=False)
            yield from content.watch(rows_of_columns(columns_of(batch)) for batch in batches)
        except (pa.ArrowException, OSError, ValueError, RecordingError) as error:
            raise RecordingError(f"{path}: damaged after row {content.rows}: {said(error)}") from error
        if (file.metadata.metadata or {}).get(CONTENT_KEY) != content.to_json():
            raise RecordingError(
                f"{path}: damaged: its {content.rows} rows are not those that were written"
            )


def write(path: Path, header: RecordingHeader, gaps: Iterable[Gap], parts: Iterable[Rows]) -> None:
    """Write rows to a new file; raises `OSError`."""
    import pyarrow as pa
    import pyarrow.parquet as pq

    schema = recording_schema(header, {GAPS_KEY: gaps_to_json(gaps)})
    floats = {"time_s": "BYTE_STREAM_SPLIT"} | dict.fromkeys(
        header.sampling.columns, "BYTE_STREAM_SPLIT"
    )
    with (
        path.open("xb") as stream,
        pq.ParquetWriter(
            pa.PythonFile(stream, mode="w"),
            schema,
            compression="zstd",
            compression_level=1,
            use_dictionary=False,
            column_encoding={"index": "DELTA_BINARY_PACKED"} | floats,
            write_page_checksum=True,
        ) as writer,
    ):
        content = Content()
        for group in _grouped(content.watch(parts)):
            columns = [group.index, group.time_s, *np.ascontiguousarray(group.values.T), group.flags]
            writer.write_table(pa.table([pa.array(one) for one in columns], schema=schema))
        writer.add_key_value_metadata({CONTENT_KEY: content.to_json()})


def _grouped(parts: Iterable[Rows]) -> Iterator[Rows]:
    """Put rows together to row groups of `_GROUP_ROWS` or a little more."""
    waiting: list[Rows] = []
    for part in parts:
        waiting.append(part)
        if sum(map(len, waiting)) >= _GROUP_ROWS:
            yield _joined(waiting)
            waiting = []
    if waiting:
        yield _joined(waiting)


def _joined(parts: list[Rows]) -> Rows:
    return Rows(
        index=np.concatenate([part.index for part in parts]),
        time_s=np.concatenate([part.time_s for part in parts]),
        values=np.concatenate([part.values for part in parts]),
        flags=np.concatenate([part.flags for part in parts]),
    )


def _open(path: Path) -> Any:
    import pyarrow as pa
    import pyarrow.parquet as pq

    try:
        return pq.ParquetFile(pa.OSFile(str(path), "rb"), page_checksum_verification=True)
    except (pa.ArrowException, OSError, ValueError) as error:
        raise RecordingError(f"{path}: cannot be read as a recording: {said(error)}") from error
