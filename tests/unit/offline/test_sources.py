"""Which columns are analysed where none is named."""

import re
from pathlib import Path

import h5py
import numpy as np
import pytest

from gyrotest.errors import RecordingError
from gyrotest.offline.request import Request
from gyrotest.offline.sources import sources_of, time_like


def _csv(folder: Path, header: str) -> Path:
    path = folder / "rest.csv"
    row = ",".join("1.5" for _ in header.split(","))
    path.write_text(f"{header}\n{row}\n{row}\n", encoding="utf-8")
    return path


@pytest.mark.parametrize(
    ("header", "columns"),
    [
        ("ax,ay,az,gx,gy,gz", ["gx", "gy", "gz"]),
        ("part,samples,acc_x,gyr_x,gyr_y", ["gyr_x", "gyr_y"]),
        ("Time (s),Gyro Output (rads/s),Input Rate (RPM)", ["Gyro Output (rads/s)"]),
        ("timestamp,omega_z,temperature", ["omega_z"]),
        ("t,y", ["y"]),
        ("time_s,output", ["output"]),
        ("gyro_temp,sample_rate,wx", ["wx"]),
        ("angular rate,encoder", ["angular rate"]),
        ("x", ["x"]),
    ],
)
def test_rate_columns_are_told_by_their_names(tmp_path: Path, header: str, columns: list[str]) -> None:
    found = sources_of(_csv(tmp_path, header), Request())
    assert [one.column for one in found] == columns
    assert [one.name for one in found] == columns


@pytest.mark.parametrize("header", ["a,b", "t,a,b", "ax,ay,az"])
def test_columns_that_may_all_be_the_rate_are_named(tmp_path: Path, header: str) -> None:
    with pytest.raises(RecordingError) as refused:
        sources_of(_csv(tmp_path, header), Request())
    message = str(refused.value)
    assert f"it holds {header.replace(',', ', ')}" in message
    assert "choose with --column" in message


def test_columns_asked_for_are_taken_as_they_are(tmp_path: Path) -> None:
    found = sources_of(_csv(tmp_path, "gx,gy"), Request(columns=("gy", 1)))
    assert [(one.column, one.name) for one in found] == [("gy", "gy"), (1, "column 1")]


def test_the_time_column_is_no_rate(tmp_path: Path) -> None:
    (found,) = sources_of(
        _csv(tmp_path, "seconds since start,y"), Request(time_column="seconds since start")
    )
    assert found.column == "y"
    (found,) = sources_of(_csv(tmp_path, "when,y"), Request(time_column="when"))
    assert found.column == "y"


def test_a_single_column_of_numbers_needs_no_name(tmp_path: Path) -> None:
    np.save(tmp_path / "rest.npy", np.zeros(5))
    (found,) = sources_of(tmp_path / "rest.npy", Request())
    assert (found.column, found.name) == (None, "")


def test_an_array_called_gyro_gives_its_three_axes(tmp_path: Path) -> None:
    np.savez(tmp_path / "rest.npz", gyro_lsb=np.zeros((5, 3)), lsb_dps=0.05, acc=np.zeros((5, 3)))
    found = sources_of(tmp_path / "rest.npz", Request())
    assert [(one.array, one.column) for one in found] == [("gyro_lsb", n) for n in (1, 2, 3)]
    assert [one.name for one in found] == [f"gyro_lsb column {n}" for n in (1, 2, 3)]


def test_arrays_that_may_both_be_meant_are_named(tmp_path: Path) -> None:
    np.savez(tmp_path / "rest.npz", a=np.zeros((5, 2)), b=np.zeros(5))
    with pytest.raises(RecordingError, match=r"'a' with columns 1, 2; 'b' with columns 1; .*--array"):
        sources_of(tmp_path / "rest.npz", Request())
    (found,) = sources_of(tmp_path / "rest.npz", Request(array="b"))
    assert (found.array, found.column) == ("b", None)


def test_a_file_without_numbers_has_nothing_to_analyse(tmp_path: Path) -> None:
    np.savez(tmp_path / "notes.npz", note=np.array("text"))
    with pytest.raises(RecordingError, match="holds no column of numbers"):
        sources_of(tmp_path / "notes.npz", Request())


def test_a_column_that_looks_like_time_is_offered(tmp_path: Path) -> None:
    assert time_like(_csv(tmp_path, "timestamp,gx"), Request()) == "timestamp"
    assert time_like(_csv(tmp_path, "gx,gy"), Request()) is None
    assert time_like(tmp_path / "none.csv", Request()) is None


def test_arrays_called_rates_are_taken_together(tmp_path: Path) -> None:
    np.savez(tmp_path / "rest.npz", t=np.zeros(5), gx=np.zeros(5), gy=np.zeros(5), acc=np.zeros((5, 3)))
    found = sources_of(tmp_path / "rest.npz", Request())
    assert [(one.array, one.column, one.name) for one in found] == [
        ("gx", None, "gx"),
        ("gy", None, "gy"),
    ]


def test_what_stands_beside_a_gyro_is_no_rate(tmp_path: Path) -> None:
    header = "gyro_timestamp,gyro_status,gyro_scale,gyro_range,gyro_x"
    (found,) = sources_of(_csv(tmp_path, header), Request())
    assert found.column == "gyro_x"


def test_a_time_in_a_group_is_offered_and_no_rate(tmp_path: Path) -> None:
    path = tmp_path / "rest.h5"
    with h5py.File(path, "w") as file:
        file["log/time"], file["log/output"] = np.arange(5.0), np.zeros(5)
    (found,) = sources_of(path, Request())
    assert found.array == "log/output"
    assert time_like(path, Request()) == "log/time"


def test_an_array_that_is_not_there_is_named_beside_those_that_are(tmp_path: Path) -> None:
    np.savez(tmp_path / "rest.npz", gyro_x=np.zeros(5), acc=np.zeros(5))
    message = "holds no numbers called 'gyr_x', but gyro_x, acc; is 'gyro_x' meant?"
    with pytest.raises(RecordingError, match=re.escape(message)):
        sources_of(tmp_path / "rest.npz", Request(array="gyr_x"))
    with pytest.raises(RecordingError, match="is one table, without arrays"):
        sources_of(_csv(tmp_path, "gx"), Request(array="gyr_x"))


def test_samples_side_by_side_are_suspected(tmp_path: Path) -> None:
    np.save(tmp_path / "rest.npy", np.zeros((3, 4000)))
    with pytest.raises(
        RecordingError, match=r"20, … 4000 \(do its samples lie side by side\? then transpose"
    ):
        sources_of(tmp_path / "rest.npy", Request())
