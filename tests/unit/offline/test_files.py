"""A run's folder stands for its recordings."""

from pathlib import Path

import pytest

from gyrotest.errors import RecordingError
from gyrotest.offline.files import files_of


def _run(folder: Path) -> Path:
    for name in ("b-a1.parquet", "a-a1.parquet", "a-a2/000.arrows", "b-a1/000.arrows", "empty/x.txt"):
        path = folder / "recordings" / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.touch()
    (folder / "run.json").touch()
    return folder


@pytest.mark.parametrize("given", ["", "recordings"])
def test_a_run_s_folder_stands_for_each_of_its_recordings_once(tmp_path: Path, given: str) -> None:
    found = files_of(_run(tmp_path) / given)
    assert [one.relative_to(tmp_path / "recordings").as_posix() for one in found] == [
        "a-a1.parquet",
        "a-a2",
        "b-a1.parquet",
    ]


def test_a_file_and_a_recording_s_segments_stand_for_themselves(tmp_path: Path) -> None:
    run = _run(tmp_path)
    for path in (run / "run.json", run / "recordings" / "a-a2", run / "gone.csv"):
        assert files_of(path) == (path,)


def test_a_folder_without_recordings_tells_what_it_holds(tmp_path: Path) -> None:
    for name in ("rest.csv", "more.csv", "odd.parquet"):
        (tmp_path / name).touch()
    message = "is a folder without recordings .* it holds more.csv, odd.parquet, rest.csv"
    with pytest.raises(RecordingError, match=message):
        files_of(tmp_path)
