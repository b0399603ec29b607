"""A disk that is full in the middle of a record: an error that says so, and what was written stays."""

import sys
from pathlib import Path

import pytest

from tests.plugin.project import Project, short_spec

# Room for the run's record, but neither for 7200 samples nor for the fonts of a certificate.
LARGEST_FILE = 100_000
RUN = f"""
import resource
import sys

import pytest

resource.setrlimit(resource.RLIMIT_FSIZE, ({LARGEST_FILE}, resource.RLIM_INFINITY))
sys.exit(pytest.main(["-p", "no:cacheprovider", "--gyro-spec", "short.yaml", "--serial", "1234"]))
"""


@pytest.mark.skipif(sys.platform == "win32", reason="files cannot be limited on this platform")
def test_a_disk_that_fills_up_ends_in_an_error_and_keeps_what_was_written(tmp_path: Path) -> None:
    project = Project(tmp_path)
    project.write("specs/short.yaml", short_spec(duration="2 h", repeats=1))
    ended = project.python(RUN)
    assert ended.code == 1, ended.out
    assert "Traceback" not in ended
    assert "cannot be written (File too large); the first " in ended
    assert " of 7200 samples are kept" in ended
    record = project.record()
    assert record["verdict"] == "INCOMPLETE"
    assert project.certificates() == []
    ((item,), recorded) = (record["items"], project.runs()[0] / "recordings")
    assert [one.name for one in recorded.iterdir()] == ["rest-1234-r1-a1"]
    (attempt,) = item["attempts"]
    kept = attempt["recording"]["samples"]
    assert 0 < kept < 7200
    verified = project.gyrotest("recordings", "verify", "reports")
    assert verified.code == 1
    assert f"rest-1234-r1-a1: incomplete, {kept} samples" in verified
    assert f"the first {kept} of 7200 are intact" in verified
