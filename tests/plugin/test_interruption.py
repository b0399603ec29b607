"""Ctrl-C, SIGTERM and kill -9 in mid-acquisition: what was recorded is kept and said to be incomplete."""

import signal
import subprocess
import sys
from pathlib import Path

import pytest

from .project import Ended, Project, end_with, short_spec

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="signals are sent as POSIX does")


def _in_mid_acquisition(project: Project) -> "subprocess.Popen[str]":
    """Start a run in real time and wait until a batch of its recording is on the disk."""
    project.write(
        "specs/short.yaml", short_spec(duration="10 min", repeats=2).replace("warm_up: 1 min\n", "")
    )
    process = project.start("--gyro-real-time", "-v")
    assert process.stdout is not None
    for line in process.stdout:
        if "samples every" in line:
            break
    while not [path for path in _segments(project) if path.stat().st_size > 4000]:
        assert process.poll() is None, process.stdout.read()
    return process


def _segments(project: Project) -> list[Path]:
    return list((project.path / "reports").glob("*/*/recordings/*/*.arrows"))


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_a_request_to_end_keeps_the_record_and_certifies_incomplete(
    project: Project, number: signal.Signals
) -> None:
    ended: Ended = end_with(_in_mid_acquisition(project), number)
    assert ended.code == 2, ended.out
    record = project.record()
    assert record["verdict"] == "INCOMPLETE"
    attempt = record["items"][0]["attempts"][0]
    assert attempt["outcome"] == "interrupted"
    assert attempt["recording"]["complete"] is False
    assert attempt["recording"]["samples"] >= 1
    assert "INCOMPLETE" in project.certificates()[0].name


def test_a_killed_run_is_readable_verifiable_and_goes_on(project: Project) -> None:
    process = _in_mid_acquisition(project)
    process.kill()
    process.communicate()
    record = project.record()
    assert record["verdict"] == "INCOMPLETE"
    assert project.certificates() == []
    (run,) = project.runs()
    verified = project.gyrotest("recordings", "verify", str(run))
    assert verified.code == 1
    assert "incomplete" in verified
    reported = project.gyrotest("report", str(run))
    assert reported.code == 0, reported.out
    assert "INCOMPLETE" in project.certificates()[0].name
    resumed = project.pytest("--gyro-resume", str(run))
    assert resumed.code == 0, resumed.out
    record = project.record()
    assert record["verdict"] == "PASS"
    assert [one["outcome"] for one in record["items"][0]["attempts"]] == ["interrupted", "passed"]


def test_resuming_keeps_finished_acquisitions(project: Project) -> None:
    project.pytest("-k", "r1")
    (run,) = project.runs()
    before = project.record()["items"][0]["attempts"]
    resumed = project.pytest("--gyro-resume", str(run))
    assert resumed.code == 0, resumed.out
    record = project.record()
    assert record["verdict"] == "PASS"
    assert record["items"][0]["attempts"] == before


def test_resuming_with_another_spec_is_refused(project: Project) -> None:
    project.pytest("-k", "r1")
    (run,) = project.runs()
    project.write("specs/short.yaml", short_spec(bias_max="1.9 deg/s"))
    refused = project.pytest("--gyro-resume", str(run))
    assert refused.code == 4
    assert "spec (SHA-256)" in refused
