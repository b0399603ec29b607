"""NumPy's npy (mapped into memory) and npz files."""

import tokenize
import zipfile
import zlib
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from gyrotest.errors import RecordingError
from gyrotest.recordings.formats.array_rows import (
    Column,
    array_and_column,
    column_of,
    parts_of,
    refuse_where,
)
from gyrotest.recordings.formats.selection import Part, Selection, find_name

DAMAGE = (OSError, ValueError, EOFError, SyntaxError, tokenize.TokenError, MemoryError)
"""What NumPy raises on a damaged file; it reads the header as Python's literals."""


def read_npy(path: Path, selection: Selection) -> Iterator[Part]:
    """Yield rows of an npy file; raises `RecordingError`."""
    refuse_where(selection, path)
    if selection.array is not None:
        raise RecordingError(f"{path}: holds one array without a name; leave 'array' out")
    try:
        array = np.load(path, mmap_mode="r", allow_pickle=False)
    except DAMAGE as error:
        raise RecordingError(f"{path}: cannot be read as npy: {error}") from error
    values = column_of(array, selection.column, path)
    time = None if selection.time_column is None else column_of(array, selection.time_column, path)
    yield from parts_of(values, time, path, [column_of(array, one, path) for one in selection.beside])


def read_npz(path: Path, selection: Selection) -> Iterator[Part]:
    """Yield rows of an array in an npz file; a time column by name is another array in it."""
    refuse_where(selection, path)
    try:
        with path.open("rb") as stream, np.load(stream, allow_pickle=False) as file:
            parts = _arrays(file, path, array_and_column(selection, tuple(file.files)))
    except (*DAMAGE, zipfile.BadZipFile, zlib.error, NotImplementedError) as error:
        raise RecordingError(f"{path}: cannot be read as npz: {error}") from error
    yield from parts


def _arrays(file: Any, path: Path, selection: Selection) -> Iterator[Part]:
    array = file[find_name(selection.array, tuple(file.files), path, "array")]

    def beside(wanted: str | int, setting: str) -> Column:
        if isinstance(wanted, int) or array.dtype.names:
            return column_of(array, wanted, path)
        return column_of(file[find_name(wanted, tuple(file.files), path, setting)], None, path)

    return parts_of(
        column_of(array, selection.column, path),
        None if selection.time_column is None else beside(selection.time_column, "time_column"),
        path,
        [beside(one, "column") for one in selection.beside],
    )
