"""HDF5 files, and MATLAB's of version 7.3, which are HDF5."""

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from gyrotest.errors import RecordingError
from gyrotest.recordings.formats.array_rows import (
    Column,
    array_and_column,
    column_of,
    parts_of,
    refuse_where,
)
from gyrotest.recordings.formats.selection import Part, Selection, find_name


@contextmanager
def opened(path: Path) -> Iterator[Any]:
    """Open a file; raises `RecordingError`, also where h5py is not installed."""
    try:
        import h5py
    except ImportError as error:
        raise RecordingError(
            f"{path}: is HDF5, for which h5py is needed: pip install 'gyrotest[formats]'"
        ) from error
    try:
        with h5py.File(path, "r") as file:
            yield file
    except (OSError, RuntimeError, KeyError, ValueError) as error:
        raise RecordingError(f"{path}: cannot be read as HDF5: {error}") from error


def data_sets(file: Any) -> tuple[str, ...]:
    """Name the data sets of an open file."""
    import h5py

    names: list[str] = []
    file.visititems(lambda name, item: names.append(name) if isinstance(item, h5py.Dataset) else None)
    return tuple(name for name in names if not name.startswith("#"))


def read_hdf5(path: Path, selection: Selection) -> Iterator[Part]:
    """Yield rows of a data set; a time column by name is another data set. Raises `RecordingError`."""
    with opened(path) as file:
        refuse_where(selection, path)
        names = data_sets(file)
        selection = array_and_column(selection, names)
        chosen = find_name(_absolute(selection.array), names, path, "array")
        values = _column(file[chosen], selection.column, path)

        def beside(wanted: str | int, setting: str) -> Column:
            if isinstance(wanted, int) or file[chosen].dtype.names:
                return _column(file[chosen], wanted, path)
            return _column(file[find_name(_absolute(wanted), names, path, setting)], None, path)

        wanted = selection.time_column
        time = None if wanted is None else beside(wanted, "time_column")
        yield from parts_of(values, time, path, [beside(one, "column") for one in selection.beside])


def _column(data_set: Any, wanted: str | int | None, path: Path) -> Column:
    return column_of(data_set, wanted, path, rows_last="MATLAB_class" in data_set.attrs)


def _absolute(name: str | None) -> str | None:
    return None if name is None else name.strip("/")
