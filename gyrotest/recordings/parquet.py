"""A recording as a Parquet file: written aside batch by batch, and read batch by batch."""

from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from gyrotest.errors import RecordingError
from gyrotest.recordings.batches import rows_of_columns, said
from gyrotest.recordings.content import Content, rows_in_json
from gyrotest.recordings.facts import Facts
from gyrotest.recordings.journal import Rows
from gyrotest.recordings.layout import (
    BATCH_ROWS,
    CONTENT_KEY,
    DWELLS_KEY,
    GAPS_KEY,
    columns_of,
    dwells_from_json,
    dwells_to_json,
    gaps_from_json,
    gaps_to_json,
    header_from_metadata,
    recording_schema,
)

# A row group per this many rows: what the writer and the reader hold in memory.
_GROUP_ROWS = 4 * BATCH_ROWS


def read_facts(path: Path) -> Facts:
    """What the footer of a Parquet recording says; raises `RecordingError`."""
    with _open(path) as file:
        try:
            metadata = file.schema_arrow.metadata
            header = header_from_metadata(metadata)
            gaps = gaps_from_json(metadata.get(GAPS_KEY, b"[]"))
            dwells = dwells_from_json(metadata.get(DWELLS_KEY, b"[]"))
            rows = rows_in_json((file.metadata.metadata or {}).get(CONTENT_KEY, b"{}"))
        except (RecordingError, ValueError, KeyError) as error:
            raise RecordingError(f"{path}: {said(error)}") from error
        if rows != file.metadata.num_rows:
            raise RecordingError(f"{path}: damaged: of {rows} rows {file.metadata.num_rows} are there")
        return Facts(header=header, rows=rows, gaps=gaps, dwells=dwells)


def iterate(path: Path, columns: Sequence[int] | None = None) -> Iterator[Rows]:
    """The rows of a Parquet recording, every checksum verified; raises `RecordingError`.

    `columns` are the places of those that are read (None: all). The checksum of the whole content is
    known when the last row was given.
    """
    import pyarrow as pa

    content = Content()
    with _open(path) as file:
        try:
            batches = file.iter_batches(
                batch_size=BATCH_ROWS, use_threads=False, columns=_names(file, columns)
            )
            yield from content.watch(rows_of_columns(columns_of(batch)) for batch in batches)
        except (pa.ArrowException, OSError, ValueError, RecordingError) as error:
            raise RecordingError(f"{path}: damaged after row {content.rows}: {said(error)}") from error
        if not _agrees(content, (file.metadata.metadata or {}).get(CONTENT_KEY, b"{}"), columns):
            raise RecordingError(
                f"{path}: damaged: its {content.rows} rows are not those that were written"
            )


def write(path: Path, facts: Facts, parts: Iterable[Rows]) -> None:
    """Write rows to a new file; raises `OSError`."""
    import pyarrow as pa
    import pyarrow.parquet as pq

    header = facts.header
    extra = {GAPS_KEY: gaps_to_json(facts.gaps)}
    if facts.dwells:
        extra[DWELLS_KEY] = dwells_to_json(facts.dwells)
    schema = recording_schema(header, extra)
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


def _names(file: Any, columns: Sequence[int] | None) -> list[str] | None:
    """The names of the columns that are read, in the file's order: index, time, values, flags."""
    if columns is None:
        return None
    index, time_s, *values, flags = file.schema_arrow.names
    return [index, time_s, *(values[place] for place in columns), flags]


def _agrees(content: Content, kept: bytes, columns: Sequence[int] | None) -> bool:
    try:
        return content.agrees(kept, columns)
    except (ValueError, KeyError, IndexError):
        return False


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
