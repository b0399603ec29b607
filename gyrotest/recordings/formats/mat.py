"""MATLAB's files up to version 7 (version 7.3 is HDF5)."""

import zlib
from collections.abc import Iterator
from pathlib import Path

from gyrotest.errors import RecordingError
from gyrotest.recordings.formats.array_rows import (
    Column,
    array_and_column,
    column_of,
    parts_of,
    refuse_where,
)
from gyrotest.recordings.formats.selection import Part, Selection, find_name

# What scipy raises on a damaged file, beside its own error.
_DAMAGE = (
    OSError,
    ValueError,
    TypeError,
    IndexError,
    KeyError,
    NotImplementedError,
    MemoryError,
    zlib.error,
)


def read_mat(path: Path, selection: Selection) -> Iterator[Part]:
    """Yield rows of a variable; a time column by name is another variable. Raises `RecordingError`."""
    from scipy.io import loadmat, whosmat
    from scipy.io.matlab import MatReadError

    refuse_where(selection, path)
    try:
        names = tuple(name for name, _, _ in whosmat(str(path)))
        selection = array_and_column(selection, names)
        chosen = find_name(selection.array, names, path, "array")
        wanted = [chosen]
        if isinstance(selection.time_column, str):
            wanted.append(find_name(selection.time_column, names, path, "time_column"))
        wanted += [
            find_name(one, names, path, "column") for one in selection.beside if isinstance(one, str)
        ]
        variables = loadmat(str(path), variable_names=wanted)
    except (*_DAMAGE, MatReadError) as error:
        raise RecordingError(f"{path}: cannot be read as a MATLAB file: {error}") from error

    def beside(wanted: str | int) -> Column:
        if isinstance(wanted, str):
            return column_of(variables[wanted], None, path)
        return column_of(variables[chosen], wanted, path)

    yield from parts_of(
        column_of(variables[chosen], selection.column, path),
        None if selection.time_column is None else beside(selection.time_column),
        path,
        [beside(one) for one in selection.beside],
    )
