"""What a file is said to hold can be read from it."""

from pathlib import Path

import numpy as np
import pytest

from gyrotest.errors import RecordingError
from gyrotest.recordings.formats.contents import Table, contents
from gyrotest.recordings.formats.detect import read_parts
from gyrotest.recordings.formats.selection import Selection

TABLE = np.arange(12.0).reshape(6, 2)


def _text(path: Path) -> None:
    path.write_text("t;gx\n" + "".join(f"{a};{b}\n" for a, b in TABLE), encoding="utf-8")


def _bare_text(path: Path) -> None:
    np.savetxt(path, TABLE)


def _npy(path: Path) -> None:
    np.save(path, TABLE)


def _fields(path: Path) -> None:
    np.save(path, np.zeros(6, dtype=[("t", "f8"), ("gx", "f4")]))


def _row(path: Path) -> None:
    np.save(path, np.arange(6.0)[np.newaxis])


def _npz(path: Path) -> None:
    np.savez(path, gyro=TABLE, t=TABLE[:, 0], rate=100.0, note=np.array("text"))


def _mat(path: Path) -> None:
    from scipy.io import savemat

    savemat(path, {"gyro": TABLE, "t": TABLE[:, 0], "rate": 100.0, "note": "text"})


def _hdf5(path: Path) -> None:
    import h5py

    with h5py.File(path, "w") as file:
        file["imu/gyro"] = TABLE
        file["imu/matlab"] = TABLE.T
        file["imu/matlab"].attrs["MATLAB_class"] = np.bytes_("double")
        file["cube"] = np.zeros((2, 2, 2))


def _parquet(path: Path) -> None:
    import pyarrow as pa
    import pyarrow.parquet as pq

    pq.write_table(pa.table({"t": TABLE[:, 0], "name": ["x"] * 6, "gx": TABLE[:, 1]}), path)


def _arrow(path: Path) -> None:
    import pyarrow as pa

    table = pa.table({"t": TABLE[:, 0], "gx": TABLE[:, 1]})
    with pa.OSFile(str(path), "wb") as sink, pa.ipc.new_file(sink, table.schema) as writer:
        writer.write_table(table)


@pytest.mark.parametrize(
    ("write", "name", "tables"),
    [
        (_text, "a.csv", {"": ("t", "gx")}),
        (_bare_text, "a.txt", {"": ("1", "2")}),
        (_npy, "a.npy", {"": ("1", "2")}),
        (_fields, "a.npy", {"": ("t", "gx")}),
        (_row, "a.npy", {"": ("1",)}),
        (_npz, "a.npz", {"gyro": ("1", "2"), "t": ("1",)}),
        (_mat, "a.mat", {"gyro": ("1", "2"), "t": ("1",)}),
        (_hdf5, "a.h5", {"imu/gyro": ("1", "2"), "imu/matlab": ("1", "2")}),
        (_parquet, "a.parquet", {"": ("t", "gx")}),
        (_arrow, "a.arrow", {"": ("t", "gx")}),
    ],
)
def test_tables_and_columns_are_listed_and_can_be_read(
    tmp_path: Path, write, name: str, tables: dict[str, tuple[str, ...]]
) -> None:
    path = tmp_path / name
    write(path)
    found = contents(path)
    assert {one.array: one.columns for one in found} == tables
    for table in found:
        for column in table.columns:
            parts = list(read_parts(path, _selection(table, column)))
            assert sum(part.values.size for part in parts) == 6


def _selection(table: Table, column: str) -> Selection:
    return Selection(array=table.array or None, column=int(column) if column.isdecimal() else column)


@pytest.mark.parametrize(
    ("name", "content", "message"),
    [
        ("a.npy", b"\x93NUMPY\x01\x00", "cannot be read as npy"),
        ("a.npz", b"PK\x03\x04" + b"\x00" * 40, "cannot be read as npz"),
        ("a.mat", b"MATLAB 5.0 MAT-file" + b"\xff" * 300, "cannot be read as a MATLAB file"),
        ("a.h5", b"\x89HDF\r\n\x1a\n" + b"\x00" * 40, "cannot be read as HDF5"),
        ("a.parquet", b"PAR1" + b"\x00" * 40, "cannot be read"),
        ("a.arrow", b"ARROW1" + b"\x00" * 40, "cannot be read"),
        ("a.csv", b"", "is empty"),
    ],
)
def test_a_damaged_file_is_refused(tmp_path: Path, name: str, content: bytes, message: str) -> None:
    path = tmp_path / name
    path.write_bytes(content)
    with pytest.raises(RecordingError, match=message):
        contents(path)


def test_hdf5_without_its_package_says_how_to_get_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "a.h5"
    _hdf5(path)
    monkeypatch.setitem(__import__("sys").modules, "h5py", None)
    with pytest.raises(RecordingError, match=r"pip install 'gyrotest\[formats\]'"):
        contents(path)
