"""A user's own tests beside a spec."""

from typing import Any

import pytest

from .project import TINY, Project, Session, SessionEnded

INSTRUMENT = """
def test_noise(instrument, gyro_spec, gyro_station, gyro_serial, gyro_acquire, gyro_verify):
    assert gyro_serial == "1234"
    assert gyro_spec.model == "TINY50"
    assert gyro_station.simulation is not None
    assert instrument.identity.model == "34401A"
    assert "34401A" in instrument.query("*IDN?")
    assert 2.0 < instrument.read() < 3.0
    samples = gyro_acquire(duration="20 s", interval="1 s")
    assert samples.values.shape == (20, 1)
    gyro_verify("quiet_noise", float(samples.values.std() * 1e3), unit="mV", max="5 mV")
    gyro_verify("offset", float(samples.values.mean()), unit="V", min="2.4 V", max="2.6 V")
    instrument._opened().source.close()
    assert 2.0 < instrument.read() < 3.0
"""
VALUES = """
def test_values(gyro_verify):
    gyro_verify("first", 3.0, unit="mV", max="2 mV")
    gyro_verify("second", float("nan"), unit="mV", max="2 mV")
"""
ASSERTION = """
def test_assertion(gyro_verify):
    gyro_verify("fine", 1.0, unit="mV", max="2 mV")
    assert False, "something else"
"""
SKIPPED = """
import pytest
def test_skipped(gyro_verify):
    gyro_verify("fine", 1.0, unit="mV", max="2 mV")
    pytest.skip("later")
"""
TEARDOWN = """
import pytest
@pytest.fixture
def breaking():
    yield
    raise RuntimeError("boom")
def test_teardown(breaking, gyro_verify):
    gyro_verify("fine", 1.0, unit="mV", max="2 mV")
"""
UNTIL_IT_PASSES = """
tries = []
def test_again(gyro_verify):
    tries.append(1)
    gyro_verify("noise", 3.0 if len(tries) == 1 else 1.0, unit="mV", max="2 mV")
"""
LOOSE_CABLE = """
from gyrotest.errors import InstrumentError
tries = []
def test_again(gyro_acquire, gyro_verify):
    tries.append(1)
    gyro_acquire(duration="5 s")
    if len(tries) == 1:
        raise InstrumentError("the cable is loose")
    gyro_verify("noise", 1.0, unit="mV", max="2 mV")
"""
SENSELESS = """
def test_fraction(gyro_acquire): gyro_acquire(duration="5.5 s")
def test_nothing(gyro_acquire): gyro_acquire(duration="0 s")
def test_unit(gyro_verify): gyro_verify("x", 1.0, unit="mV", max="2 s")
def test_range(gyro_verify): gyro_verify("x", 1.0, unit="mV", min="2 mV", max="1 mV")
def test_rule(gyro_verify): gyro_verify("x", 1.0, unit="mV", max="2 mV", decision="maybe")
"""
NAMES = """
import pytest
@pytest.mark.parametrize("name, value", [("a b", 3.0), ("a_b", 1.0), ("a/b", 1.0)])
def test_names(gyro_verify, name, value):
    gyro_verify("x", value, unit="mV", max="2 mV")
"""


@pytest.fixture
def tiny(project: Project) -> Project:
    project.write("specs/tiny.yaml", TINY)
    return project


def _sessions(project: Project, *tests: str, arguments: tuple[str, ...] = ()) -> list[SessionEnded]:
    for number, text in enumerate(tests):
        project.write(f"test_own_{number}.py", text)
    return project.sessions(
        *(
            Session(spec="tiny.yaml", arguments=(f"test_own_{number}.py", *arguments))
            for number in range(len(tests))
        )
    )


def _own_items(ended: SessionEnded, *, records: bool = False) -> list[dict[str, Any]]:
    """The user's own tests on record, or the recordings that they made."""
    own = [one for one in ended.record["items"] if "::" in one["plan"]["name"]]
    return [one for one in own if (", record " in one["plan"]["name"]) == records]


def _outcomes(ended: SessionEnded) -> list[str]:
    own = _own_items(ended)
    return [attempt["outcome"] for one in own for attempt in one["attempts"]]


def _own_results(record: dict[str, Any]) -> dict[str, dict[str, Any]]:
    return {one["name"]: one for one in record["results"] if one["case"].startswith("test_")}


def test_own_tests_use_the_instrument_and_are_certified(tiny: Project) -> None:
    (ended,) = _sessions(tiny, INSTRUMENT)
    assert ended.code == 0, ended.out
    assert "2 passed" in ended.out
    assert ended.record["verdict"] == "PASS"
    own = _own_results(ended.record)
    assert own["quiet_noise"]["verdict"] == "PASS"
    assert own["offset"]["unit"] == "V"
    (recorded,) = _own_items(ended, records=True)
    recording = recorded["attempts"][0]["recording"]
    assert recording["complete"] is True
    assert recording["sha256"]
    (item,) = _own_items(ended)
    assert item["attempts"][0]["origin"] == "simulated"


def test_own_tests_forbid_a_pass_by_values_assertions_and_whatever_breaks(tiny: Project) -> None:
    values, assertion, skipped, teardown = _sessions(tiny, VALUES, ASSERTION, SKIPPED, TEARDOWN)
    assert [one.code for one in (values, assertion, skipped, teardown)] == [1, 1, 1, 1]
    assert "first = 3" in values.out
    verdicts = {name: one["verdict"] for name, one in _own_results(values.record).items()}
    assert verdicts == {"first": "FAIL", "second": "INCOMPLETE"}
    assert values.record["verdict"] == "INCOMPLETE"
    assert assertion.record["verdict"] == "FAIL"
    assert skipped.record["missing"] == ["test_own_2.py::test_skipped: skipped: later"]
    assert teardown.record["missing"] == ["test_own_3.py::test_teardown: error: teardown: boom"]


def test_own_tests_that_failed_are_not_repeated_until_they_pass(tiny: Project) -> None:
    pytest.importorskip("pytest_rerunfailures")
    failed, repaired = _sessions(tiny, UNTIL_IT_PASSES, LOOSE_CABLE, arguments=("--reruns", "1"))
    assert (failed.code, failed.record["verdict"]) == (1, "FAIL")
    assert "attempt 1 failed and stands" in failed.out
    assert _outcomes(failed) == ["failed"]
    assert (repaired.code, repaired.record["verdict"]) == (0, "PASS"), repaired.out
    assert _outcomes(repaired) == ["error", "passed"]


def test_senseless_requests_are_errors_in_a_line_and_names_are_kept_apart(tiny: Project) -> None:
    senseless, names = _sessions(tiny, SENSELESS, NAMES)
    assert senseless.record["verdict"] == "INCOMPLETE"
    assert "5 failed" in senseless.out
    for text in (
        "gyro_acquire: a duration of 5.5 s is no whole number of intervals of 1 s",
        "'mV' cannot be converted to 's'",
        "gyro_verify: min 2 mV is more than max 1 mV; nothing could pass",
        "gyro_verify: decision 'maybe' is not known; accepted: simple, ",
    ):
        assert text in senseless.out
    assert "Traceback" not in senseless.out
    assert "def __call__" not in senseless.out
    assert _outcomes(names) == ["failed", "passed", "passed"]
    assert names.record["verdict"] == "FAIL"


def test_hooks_are_called(tiny: Project) -> None:
    plugin = """
    def pytest_gyro_acquired(item, attempt):
        print("ACQUIRED", item.name, attempt.recording.samples)
    def pytest_gyro_judged(item, attempt):
        print("JUDGED", attempt.outcome.value)
    def pytest_gyro_certified(record, certificate):
        print("CERTIFIED", record.verdict.value, certificate.suffix)
    """
    (ended,) = tiny.sessions(Session(spec="tiny.yaml", arguments=("-s",), plugin=plugin))
    assert "ACQUIRED rest-1234-r1 40" in ended.out
    assert "JUDGED passed" in ended.out
    assert "CERTIFIED PASS .pdf" in ended.out


def test_own_tests_run_once_for_each_serial_number(tiny: Project) -> None:
    tiny.write(
        "test_own.py",
        """
        def test_offset(instrument, gyro_serial, gyro_verify):
            gyro_verify("offset", instrument.read(), unit="V", min="2 V", max="3 V")
        """,
    )
    ended = tiny.pytest("test_own.py", "--gyro-yes", serial="1234,1235", spec="tiny.yaml")
    assert ended.code == 0, ended.out
    assert "4 passed" in ended
    offsets = [_own_results(tiny.record(serial))["offset"]["value"] for serial in ("1234", "1235")]
    assert offsets[0] != offsets[1]
