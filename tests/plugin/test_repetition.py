"""Reruns and workers: attempts are kept, and nobody tests until it passes."""

import pytest

from .project import FAILING, TINY, Project, Session

pytest.importorskip("xdist")
pytest.importorskip("pytest_rerunfailures")

RETESTED = FAILING.replace("interval: 1 s", "interval: 1 s\n    retests: 1")
REPEATED = TINY.replace("interval: 1 s", "interval: 1 s\n    repeats: 2").replace(
    "max: 2 deg/s}}", "max: 2 deg/s}, bias_run_to_run: {max: 200 deg/h, over: repeats}}"
)
LOOSE_CABLE = """
import pytest
from gyrotest.errors import InstrumentError
tries = []

@pytest.fixture(autouse=True)
def loose_cable(gyro_session):
    bench = gyro_session.bench()
    real = bench.source
    def source(slot, serial_number):
        tries.append(slot)
        bench.source = real
        raise InstrumentError("the cable is loose")
    if not tries:
        bench.source = source
"""
WORKER_DIES = """
import os
from gyrotest.acquisition.acquire import Acquisition

kept = Acquisition._keep
def keep(self, tracks, block):
    kept(self, tracks, block)
    if block.first == 20 and "r1" in self.tracks[0].header.item:
        os._exit(7)
if os.environ.get("PYTEST_XDIST_WORKER"):
    Acquisition._keep = keep
"""


def test_reruns_replace_a_bench_error_and_a_failure_only_where_the_spec_says_so(
    project: Project,
) -> None:
    project.write("specs/tiny.yaml", TINY)
    project.write("specs/failing.yaml", FAILING)
    project.write("specs/retested.yaml", RETESTED)
    reruns = ("--reruns", "2")
    failed, retested, repaired = project.sessions(
        Session(spec="failing.yaml", arguments=reruns),
        Session(spec="retested.yaml", arguments=reruns),
        Session(spec="tiny.yaml", arguments=reruns, plugin=LOOSE_CABLE),
    )
    assert "2 rerun" in failed.out
    for ended, code, verdict, outcomes in (
        (failed, 1, "FAIL", ["failed"]),
        (retested, 1, "FAIL", ["failed", "failed"]),
        (repaired, 0, "PASS", ["error", "passed"]),
    ):
        (item,) = ended.record["items"]
        assert [one["outcome"] for one in item["attempts"]] == outcomes
        assert (ended.code, ended.record["verdict"]) == (code, verdict), ended.out


def test_workers_do_the_items_as_a_single_process_does_and_the_controller_certifies(
    project: Project,
) -> None:
    project.write("specs/repeated.yaml", REPEATED)
    ended = project.pytest(
        "-n", "2", "--dist", "each", "--gyro-yes", serial="1234,1235", spec="repeated.yaml"
    )
    assert ended.code == 0, ended.out
    assert "6 passed" in ended
    assert "samples every" not in ended
    for serial in ("1234", "1235"):
        assert project.record(serial)["verdict"] == "PASS"
        assert len(project.certificates(serial)) == 1
    distributed = [one["value"] for one in project.record("1235")["results"]]
    alone = project.pytest(serial="1235", spec="repeated.yaml")
    assert alone.code == 0, alone.out
    assert [one["value"] for one in project.record("1235")["results"]] == distributed


def test_what_a_worker_was_lost_at_stays_missing_and_the_rest_goes_on(project: Project) -> None:
    project.write("specs/repeated.yaml", REPEATED)
    project.write("conftest.py", WORKER_DIES)
    ended = project.pytest("-n", "1", spec="repeated.yaml")
    assert ended.code == 1, ended.out
    assert "crashed" in ended
    record = project.record()
    assert record["verdict"] == "INCOMPLETE"
    outcomes = [[one["outcome"] for one in item["attempts"]] for item in record["items"]]
    assert outcomes == [["interrupted"], ["passed"], ["skipped"]]
    assert "INCOMPLETE" in project.certificates()[0].name
