"""Ctrl-C, SIGTERM and kill -9 in mid-acquisition: what was recorded is kept and said to be incomplete."""

import signal
import sys

import pytest

from .project import Ended, Project, short_spec

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="signals are sent as POSIX does")

# The process ends itself at a sample that is known, so that no test has to wait for the right moment.
ENDS_ITSELF = """
import os, signal
from gyrotest.acquisition.acquire import Acquisition

kept = Acquisition._keep
def keep(self, writer, block):
    kept(self, writer, block)
    if block.first + len(block.flags) == 100:
        writer.flush()
        os.kill(os.getpid(), signal.{name})
if os.environ.get("END_ITSELF"):
    Acquisition._keep = keep
"""


def _end_in_mid_acquisition(project: Project, number: signal.Signals, *arguments: str) -> Ended:
    project.write("conftest.py", ENDS_ITSELF.format(name=number.name))
    return project.pytest(*arguments, environment={"END_ITSELF": "yes"})


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM, signal.SIGHUP])
def test_a_request_to_end_keeps_the_record_and_certifies_incomplete(
    project: Project, number: signal.Signals
) -> None:
    ended = _end_in_mid_acquisition(project, number)
    assert ended.code == 2, ended.out
    record = project.record()
    assert record["verdict"] == "INCOMPLETE"
    attempt = record["items"][0]["attempts"][0]
    assert attempt["outcome"] == "interrupted"
    assert attempt["recording"]["complete"] is False
    assert attempt["recording"]["samples"] == 100
    assert "INCOMPLETE" in project.certificates()[0].name


def test_workers_that_are_interrupted_leave_an_incomplete_run(project: Project) -> None:
    pytest.importorskip("xdist")
    ended = _end_in_mid_acquisition(project, signal.SIGTERM, "-n", "1")
    assert ended.code != 0
    assert project.record()["verdict"] == "INCOMPLETE"


def test_a_killed_run_is_readable_verifiable_and_goes_on(project: Project) -> None:
    ended = _end_in_mid_acquisition(project, signal.SIGKILL)
    assert ended.code == -signal.SIGKILL
    assert project.record()["verdict"] == "INCOMPLETE"
    assert project.certificates() == []
    (run,) = project.runs()
    verified = project.gyrotest("recordings", "verify", str(run))
    assert verified.code == 1
    assert "incomplete, 100 samples" in verified
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
