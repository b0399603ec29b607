"""Rows out of arrays: of NumPy, MATLAB or HDF5, of one or two dimensions."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gyrotest.errors import RecordingError
from gyrotest.recordings.formats.selection import PART_ROWS, Part, Selection, find_column


@dataclass(frozen=True, slots=True)
class Column:
    """A column of an array: how many rows, and how to read a range of them."""

    rows: int
    read: Callable[[slice], NDArray[Any]]


def column_of(array: Any, wanted: str | int | None, path: Path, *, rows_last: bool = False) -> Column:
    """Return a column of anything with `shape`, `dtype` and slices; raises `RecordingError`.

    `rows_last`: the rows are along the last axis, as MATLAB's arrays are in HDF5.
    """
    if array.dtype.names:
        name = array.dtype.names[find_column(wanted, array.dtype.names, path)]
        _check_numbers(array.dtype[name], path)
        return Column(array.shape[0], lambda rows: array[rows][name])
    _check_numbers(array.dtype, path)
    if array.ndim == 1:
        find_column(wanted, ("1",), path)
        return Column(array.shape[0], lambda rows: array[rows])
    if array.ndim != 2:
        raise RecordingError(
            f"{path}: the array has {array.ndim} dimensions {array.shape}; one or two are read"
        )
    return _of_two_dimensions(array, wanted, path, rows_last=rows_last)


def _of_two_dimensions(array: Any, wanted: str | int | None, path: Path, *, rows_last: bool) -> Column:
    rows, columns = (1, 0) if rows_last else (0, 1)
    if array.shape[rows] == 1:
        # A row of values: every one of them is a sample.
        rows, columns = columns, rows
    names = tuple(str(number) for number in range(1, array.shape[columns] + 1))
    at = find_column(wanted, names, path)
    if rows == 0:
        return Column(array.shape[0], lambda part: array[part, at])
    return Column(array.shape[1], lambda part: array[at, part])


def parts_of(
    values: Column, time: Column | None, path: Path, beside: Sequence[Column] = ()
) -> Iterator[Part]:
    """Yield the rows of a column, and of the times and further columns beside it, block by block."""
    if time is not None and time.rows != values.rows:
        raise RecordingError(
            f"{path}: {values.rows} values and {time.rows} times; there must be one for each"
        )
    for other in beside:
        if other.rows != values.rows:
            raise RecordingError(
                f"{path}: columns of {values.rows} and of {other.rows} rows; side by side all have as many"
            )
    for start in range(0, values.rows, PART_ROWS):
        rows = slice(start, min(start + PART_ROWS, values.rows))
        yield Part(
            row=np.arange(rows.start, rows.stop, dtype=np.int64),
            values=np.asarray(values.read(rows), dtype=np.float64),
            time=None if time is None else np.asarray(time.read(rows), dtype=np.float64),
            beside=tuple(np.asarray(other.read(rows), dtype=np.float64) for other in beside),
        )


def array_and_column(selection: Selection, names: Sequence[str]) -> Selection:
    """Take a column by name as an array by name, where no array is chosen and one is called so."""
    if selection.array is None and isinstance(selection.column, str) and selection.column in names:
        return replace(selection, array=selection.column, column=None)
    return selection


def refuse_where(selection: Selection, path: Path) -> None:
    """Raise `RecordingError` for a row filter, which arrays of numbers do not know."""
    if selection.where:
        raise RecordingError(
            f"{path}: 'where' is for tables with named columns; this file holds plain arrays"
        )


def _check_numbers(dtype: Any, path: Path) -> None:
    if dtype.kind not in "iufb":
        raise RecordingError(f"{path}: holds {dtype} and not real numbers")
