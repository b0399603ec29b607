"""Ctrl-C, SIGTERM and kill -9 in mid-acquisition: what was recorded is kept and said to be incomplete."""

import json
import signal
import sys

import pytest

from .project import FAILING, TINY, Ended, Project

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="signals are sent as POSIX does")

# The process ends itself at a sample that is known, so that no test has to wait for the right moment.
ENDS_ITSELF = """
import os, signal
from gyrotest.acquisition.acquire import Acquisition
import gyrotest.certificate.pdf as pdf

def end():
    os.kill(os.{whom}(), signal.{name})

kept = Acquisition._keep
def keep(self, tracks, block):
    kept(self, tracks, block)
    if block.first + len(block.flags) == 20:
        for writer in tracks._writers:
            writer.flush()
        end()
        end()

write = pdf.write_certificate
def write_while_asked_to_end(record, folder):
    end()
    return write(record, folder)

if os.environ.get("END_ITSELF"):
    Acquisition._keep = keep
    pdf.write_certificate = write_while_asked_to_end
"""
REPEATED = "interval: 1 s\n    repeats: 2"


def _end_in_mid_acquisition(
    project: Project, number: signal.Signals, *arguments: str, whom: str = "getpid"
) -> Ended:
    project.write("specs/tiny.yaml", TINY.replace("interval: 1 s", REPEATED))
    project.write("conftest.py", ENDS_ITSELF.format(name=number.name, whom=whom))
    return project.pytest(*arguments, spec="tiny.yaml", environment={"END_ITSELF": "yes"})


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM, signal.SIGHUP])
def test_requests_to_end_keep_the_record_and_certify_incomplete_once(
    project: Project, number: signal.Signals
) -> None:
    ended = _end_in_mid_acquisition(project, number)
    assert ended.code == 2, ended.out
    record = project.record()
    assert record["verdict"] == "INCOMPLETE"
    assert f"the run was interrupted ({number.name})" in record["missing"]
    attempt = record["items"][0]["attempts"][0]
    assert attempt["outcome"] == "interrupted"
    assert attempt["recording"]["complete"] is False
    assert attempt["recording"]["samples"] == 20
    (certificate,) = project.certificates()
    assert "INCOMPLETE" in certificate.name


def test_workers_that_are_interrupted_leave_an_incomplete_run(project: Project) -> None:
    pytest.importorskip("xdist")
    ended = _end_in_mid_acquisition(project, signal.SIGTERM, "-n", "1")
    assert ended.code == 2, ended.out
    assert project.record()["verdict"] == "INCOMPLETE"
    assert project.record()["items"][0]["attempts"][0]["outcome"] == "interrupted"
    assert "INCOMPLETE" in project.certificates()[0].name


def test_a_killed_run_is_readable_verifiable_and_goes_on(project: Project) -> None:
    ended = _end_in_mid_acquisition(project, signal.SIGKILL)
    assert ended.code == -signal.SIGKILL
    assert project.record()["verdict"] == "INCOMPLETE"
    assert project.certificates() == []
    (run,) = project.runs()
    verified = project.gyrotest("recordings", "verify", str(run))
    assert verified.code == 1
    assert "incomplete, 20 samples" in verified
    reported = project.gyrotest("report", str(run))
    assert reported.code == 0, reported.out
    assert "INCOMPLETE" in project.certificates()[0].name
    resume = ("--gyro-resume", str(run))
    resumed = project.pytest(*resume, spec="tiny.yaml")
    assert resumed.code == 0, resumed.out
    record = project.record()
    assert record["verdict"] == "PASS"
    assert [one["outcome"] for one in record["items"][0]["attempts"]] == ["interrupted", "passed"]
    assert "Resumed on" in record["header"]["deviations"][0]
    again = project.pytest(*resume, spec="tiny.yaml")
    assert again.code == 4
    assert "has ended (PASS) and lacks nothing" in again


def test_a_record_never_says_pass_before_its_certificate_exists(project: Project) -> None:
    project.write("specs/tiny.yaml", TINY)
    project.write("conftest.py", ENDS_ITSELF.format(name="SIGKILL", whom="getpid"))
    conftest = project.path / "conftest.py"
    conftest.write_text(conftest.read_text().replace("== 20", "== -1"))
    ended = project.pytest(spec="tiny.yaml", environment={"END_ITSELF": "yes"})
    assert ended.code == -signal.SIGKILL
    record = project.record()
    assert [one["outcome"] for one in record["items"][0]["attempts"]] == ["passed"]
    assert record["verdict"] == "INCOMPLETE"
    assert record["missing"] == ["the run has not ended"]


def test_resuming_keeps_what_was_acquired_and_replaces_no_failure(project: Project) -> None:
    project.write("specs/failing.yaml", FAILING.replace("interval: 1 s", REPEATED))
    project.pytest("-k", "r1", spec="failing.yaml")
    (run,) = project.runs()
    before = project.record()["items"][0]["attempts"]
    resumed = project.pytest("--gyro-resume", str(run), spec="failing.yaml")
    assert resumed.code == 1, resumed.out
    record = project.record()
    assert record["verdict"] == "FAIL"
    assert record["items"][0]["attempts"] == before
    assert [one["outcome"] for one in record["items"][1]["attempts"]] == ["failed"]
    assert project.runs() == [run]


def test_resuming_as_something_else_is_refused_and_changes_nothing(project: Project) -> None:
    project.write("specs/tiny.yaml", TINY)
    project.pytest("-m", "nothing", spec="tiny.yaml")
    (run,) = project.runs()
    before = (run / "run.json").read_bytes()
    resume = ("--gyro-resume", str(run))
    other = project.pytest(*resume, spec="tiny.yaml", serial="1235")
    project.write("specs/tiny.yaml", TINY.replace("max: 2 deg/s", "max: 1.9 deg/s"))
    changed = project.pytest(*resume, spec="tiny.yaml")
    assert (other.code, changed.code) == (4, 4)
    assert "made with serial number 1234, now it is 1235" in other
    assert "spec (SHA-256)" in changed
    assert (run / "run.json").read_bytes() == before
    assert json.loads(before)["verdict"] == "INCOMPLETE"
