"""Tables of Parquet files and of Arrow files and streams."""

from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gyrotest.errors import RecordingError
from gyrotest.recordings.batches import said
from gyrotest.recordings.formats.arrow_dates import Dates, are_dates
from gyrotest.recordings.formats.selection import PART_ROWS, Part, Selection, find_column


def read_parquet(path: Path, selection: Selection) -> Iterator[Part]:
    """Yield rows of a Parquet file; raises `RecordingError`."""
    import pyarrow as pa
    import pyarrow.parquet as pq

    try:
        with pq.ParquetFile(path) as file:
            columns = _needed(file.schema_arrow, selection, path)
            batches = file.iter_batches(batch_size=PART_ROWS, columns=columns, use_threads=False)
            yield from _parts(batches, columns, path, selection)
    except (pa.ArrowException, OSError) as error:
        raise RecordingError(f"{path}: cannot be read as Parquet: {said(error)}") from error


def read_arrow(path: Path, selection: Selection) -> Iterator[Part]:
    """Yield rows of an Arrow file or stream; raises `RecordingError`."""
    import pyarrow as pa

    try:
        with pa.OSFile(str(path), "rb") as source:
            is_file = source.read(6) == b"ARROW1"
            source.seek(0)
            reader: Any = pa.ipc.open_file(source) if is_file else pa.ipc.open_stream(source)
            batches = (
                (reader.get_batch(number) for number in range(reader.num_record_batches))
                if is_file
                else reader
            )
            columns = _needed(reader.schema, selection, path)
            yield from _parts(batches, columns, path, selection)
    except (pa.ArrowException, OSError) as error:
        raise RecordingError(f"{path}: cannot be read as Arrow: {said(error)}") from error


def _needed(schema: Any, selection: Selection, path: Path) -> list[str]:
    """Name the columns to read: values, then times if any, then those beside, then those of the filter."""
    names = tuple(schema.names)
    wanted: list[str | int | None] = [selection.column]
    if selection.time_column is not None:
        wanted.append(selection.time_column)
    wanted += [*selection.beside, *selection.where]
    return [names[find_column(one, names, path)] for one in wanted]


def _parts(
    batches: Iterable[Any], columns: list[str], path: Path, selection: Selection
) -> Iterator[Part]:
    row, dates = 0, Dates()
    timed = int(selection.time_column is not None)
    others = columns[1 + timed : 1 + timed + len(selection.beside)]
    for batch in batches:
        numbers = np.arange(row, row + batch.num_rows, dtype=np.int64)
        row += batch.num_rows
        is_date = bool(timed) and are_dates(batch.column(columns[1]).type)
        time = None
        if timed:
            time = (
                dates.seconds(batch.column(columns[1])) if is_date else _numbers(batch, columns[1], path)
            )
        part = Part(
            row=numbers,
            values=_numbers(batch, columns[0], path),
            time=time,
            time_in_s=is_date,
            beside=tuple(_numbers(batch, one, path) for one in others),
        )
        yield part.kept(_kept(batch, selection)) if selection.where else part


def _kept(batch: Any, selection: Selection) -> Any:
    import pyarrow as pa
    import pyarrow.compute as pc

    keep = np.ones(batch.num_rows, dtype=bool)
    for name, contents in selection.accepted.items():
        any_of_them = np.zeros(batch.num_rows, dtype=bool)
        for content in contents:
            column, wanted = batch.column(name), pa.scalar(content)
            if pa.types.is_string(column.type) != pa.types.is_string(wanted.type):
                column, wanted = column.cast(pa.string()), pa.scalar(str(content))
            any_of_them |= pc.equal(column, wanted).fill_null(False).to_numpy(zero_copy_only=False)
        keep &= any_of_them
    return keep


def _numbers(batch: Any, name: str, path: Path) -> NDArray[np.float64]:
    import pyarrow as pa

    column = batch.column(name)
    if not (pa.types.is_integer(column.type) or pa.types.is_floating(column.type)):
        raise RecordingError(f"{path}: column '{name}' holds {column.type} and not numbers")
    numbers: NDArray[np.float64] = column.cast(pa.float64(), safe=False).to_numpy(zero_copy_only=False)
    return numbers
