"""What a file holds: its arrays with their columns, read from its head without the samples."""

import zipfile
import zlib
from dataclasses import dataclass
from pathlib import Path
from typing import IO, Any

import numpy as np

from gyrotest.errors import RecordingError
from gyrotest.recordings.batches import said
from gyrotest.recordings.formats.arrow_dates import are_dates
from gyrotest.recordings.formats.detect import Format, detect
from gyrotest.recordings.formats.hdf5 import data_sets, opened
from gyrotest.recordings.formats.npy import DAMAGE
from gyrotest.recordings.formats.text_head import read_head
from gyrotest.recordings.reader import read_header

_MATLAB_NUMBERS = ("double", "single", "int", "uint", "logical")


@dataclass(frozen=True, slots=True, kw_only=True)
class Table:
    """Columns of numbers side by side.

    `array` is what `Selection.array` calls it; empty where the file is one table. `columns` are
    names, or the columns' numbers from 1 where they have none. `dates` are columns of dates and
    times, which can be no more than a time column.
    """

    array: str
    columns: tuple[str, ...]
    dates: tuple[str, ...] = ()


def contents(path: Path, *, skip_rows: int = 0) -> tuple[Table, ...]:
    """Return the tables of numbers that a file holds; raises `RecordingError`."""
    form = detect(path)
    if form is Format.OWN:
        return (Table(array="", columns=read_header(path).sampling.columns),)
    if form is Format.TEXT:
        return (Table(array="", columns=read_head(path, skip_rows=skip_rows, wanted=()).names),)
    if form in (Format.PARQUET, Format.ARROW):
        return (_arrow_table(path, form),)
    return _arrays(path, form)


def _arrays(path: Path, form: Format) -> tuple[Table, ...]:
    if form is Format.NPY:
        return _npy(path)
    if form is Format.NPZ:
        return _npz(path)
    if form is Format.MAT:
        return _mat(path)
    with opened(path) as file:
        return tuple(
            _table(name, file[name], rows_last="MATLAB_class" in file[name].attrs)
            for name in data_sets(file)
            if _numbers(file[name])
        )


def _npy(path: Path) -> tuple[Table, ...]:
    try:
        array = np.load(path, mmap_mode="r", allow_pickle=False)
    except DAMAGE as error:
        raise RecordingError(f"{path}: cannot be read as npy: {error}") from error
    return (_table("", array),) if _numbers(array) else ()


def _npz(path: Path) -> tuple[Table, ...]:
    try:
        with zipfile.ZipFile(path) as archive:
            shapes = {}
            for name in archive.namelist():
                with archive.open(name) as member:
                    shapes[name.removesuffix(".npy")] = _shape(member)
    except (*DAMAGE, zipfile.BadZipFile, zlib.error, NotImplementedError) as error:
        raise RecordingError(f"{path}: cannot be read as npz: {error}") from error
    return tuple(_table(name, shape) for name, shape in shapes.items() if _numbers(shape))


@dataclass(frozen=True, slots=True)
class _Shape:
    """An array without its content."""

    shape: tuple[int, ...]
    dtype: Any

    @property
    def ndim(self) -> int:
        return len(self.shape)


def _shape(member: IO[bytes]) -> _Shape:
    """Read the header of an npy file; a version that numpy does not tell has no columns."""
    version = np.lib.format.read_magic(member)
    read = {
        (1, 0): np.lib.format.read_array_header_1_0,
        (2, 0): np.lib.format.read_array_header_2_0,
    }.get(version)
    if read is None:
        return _Shape((), np.dtype(object))
    shape, _, dtype = read(member)
    return _Shape(shape, dtype)


def _mat(path: Path) -> tuple[Table, ...]:
    from scipy.io import whosmat
    from scipy.io.matlab import MatReadError

    try:
        found = whosmat(str(path))
    except (OSError, ValueError, TypeError, NotImplementedError, zlib.error, MatReadError) as error:
        raise RecordingError(f"{path}: cannot be read as a MATLAB file: {error}") from error
    return tuple(
        _table(name, _Shape(tuple(shape), np.dtype(np.float64)))
        for name, shape, kind in found
        if kind.startswith(_MATLAB_NUMBERS) and len(shape) == 2 and max(shape) > 1
    )


def _arrow_table(path: Path, form: Format) -> Table:
    import pyarrow as pa
    import pyarrow.parquet as pq

    try:
        if form is Format.PARQUET:
            schema = pq.read_schema(path)
        else:
            with pa.OSFile(str(path), "rb") as source:
                is_file = source.read(6) == b"ARROW1"
                source.seek(0)
                schema = (pa.ipc.open_file if is_file else pa.ipc.open_stream)(source).schema
    except (pa.ArrowException, OSError) as error:
        raise RecordingError(f"{path}: cannot be read: {said(error)}") from error
    return Table(
        array="",
        columns=tuple(
            field.name
            for field in schema
            if pa.types.is_integer(field.type) or pa.types.is_floating(field.type)
        ),
        dates=tuple(field.name for field in schema if are_dates(field.type)),
    )


def _numbers(array: Any) -> bool:
    """Whether an array of one or two dimensions, or with named fields, holds numbers to analyse."""
    if array.dtype.names:
        return True
    return array.ndim in (1, 2) and array.dtype.kind in "iufb"


def _table(name: str, array: Any, *, rows_last: bool = False) -> Table:
    if array.dtype.names:
        return Table(array=name, columns=tuple(array.dtype.names))
    if array.ndim == 1:
        return Table(array=name, columns=("1",))
    rows, columns = array.shape[::-1] if rows_last else array.shape
    count = rows if rows == 1 else columns
    return Table(array=name, columns=tuple(str(number) for number in range(1, count + 1)))
