"""Which format a file has: told by its first bytes, not by its name."""

from collections.abc import Callable, Iterator
from enum import Enum
from pathlib import Path

from gyrotest.errors import RecordingError
from gyrotest.recordings.formats.selection import Part, Selection
from gyrotest.recordings.layout import HEADER_KEY


class Format(Enum):
    """The formats that are read."""

    OWN = "a recording of gyrotest"
    NPY = "npy"
    NPZ = "npz"
    MAT = "MATLAB"
    HDF5 = "HDF5"
    PARQUET = "Parquet"
    ARROW = "Arrow"
    TEXT = "text"


_SIGNATURES = (
    (0, b"\x93NUMPY", Format.NPY),
    (0, b"PK\x03\x04", Format.NPZ),
    (0, b"\x89HDF\r\n\x1a\n", Format.HDF5),
    (512, b"\x89HDF\r\n\x1a\n", Format.HDF5),
    (0, b"MATLAB 5.0 MAT-file", Format.MAT),
    (0, b"PAR1", Format.PARQUET),
    (0, b"ARROW1", Format.ARROW),
    (0, b"\xff\xff\xff\xff", Format.ARROW),
)


def detect(path: Path) -> Format:
    """Return the format of a file, or of a folder of segments; raises `RecordingError`."""
    if path.is_dir():
        return Format.OWN
    try:
        with path.open("rb") as stream:
            head = stream.read(1024)
    except OSError as error:
        raise RecordingError(f"{path}: cannot be read: {error.strerror}") from error
    if not head:
        raise RecordingError(f"{path}: is empty")
    for offset, signature, found in _SIGNATURES:
        if head.startswith(signature, offset):
            return Format.OWN if found is Format.PARQUET and _is_own(path) else found
    return Format.MAT if path.suffix.lower() == ".mat" else Format.TEXT


def read_parts(path: Path, selection: Selection) -> Iterator[Part]:
    """Yield the rows of a file of any format; raises `RecordingError`."""
    return _reader(detect(path))(path, selection)


def _reader(of: Format) -> Callable[[Path, Selection], Iterator[Part]]:
    """Load the reader of a format: each brings its own heavy package."""
    from gyrotest.recordings.formats import arrow_table, hdf5, mat, npy, own, text

    return {
        Format.OWN: own.read_own,
        Format.NPY: npy.read_npy,
        Format.NPZ: npy.read_npz,
        Format.MAT: mat.read_mat,
        Format.HDF5: hdf5.read_hdf5,
        Format.PARQUET: arrow_table.read_parquet,
        Format.ARROW: arrow_table.read_arrow,
        Format.TEXT: text.read_text,
    }[of]


def _is_own(path: Path) -> bool:
    import pyarrow as pa
    import pyarrow.parquet as pq

    try:
        return HEADER_KEY in (pq.read_schema(path).metadata or {})
    except (pa.ArrowException, OSError) as error:
        raise RecordingError(f"{path}: cannot be read as Parquet: {error}") from error
