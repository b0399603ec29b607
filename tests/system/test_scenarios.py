"""Every scenario of the simulated bench ends as it is meant to, on both meters and over every way."""

import os
from pathlib import Path

import pytest

from gyrotest.records.result import Verdict
from gyrotest.records.run import Outcome
from gyrotest.simulation.scenarios import SCENARIOS

from .short import only_attempt, short_run

MODELS = ("34401A", "34465A")
# Judged: what a unit is cannot be a fault of the bench. A record at rest does not show the sign of
# the scale factor.
JUDGED = {"nominal": Verdict.PASS, "out-of-limits": Verdict.FAIL, "inverted": Verdict.PASS}
# Ended early, or refused afterwards: what the record must say.
REFUSED = {
    "dead-output": "not distinguishable from the meter",
    "overload": "overload at sample 72",
    "meter-dead": "given up after 3 tries",
    "stuck-reading": "stuck at",
}
# Recovered: what happened, and how often.
RECOVERED = {
    "meter-timeout": ("no reply to", 1),
    "meter-disconnects": ("connection lost", 1),
    "garbled-replies": ("the reply", 3),
}
# What strikes digital gyros, synchronous sources, tables, supplies or chambers has tests of its own elsewhere.
ELSEWHERE = {
    *("lost-frames", "lost-counter-period", "bad-crc", "garbage-on-the-line", "unplugged"),
    *("overload-status", "channel-error", "wrong-baud-rate", "other-device", "other-configuration"),
    *("table-does-not-reach-rate", "table-interlock", "table-refuses"),
    *("daq-overrun", "daq-bad-block", "daq-lost", "encoder-lost", "exciter-silent", "exciter-lost"),
    *("supply-no-voltage", "supply-current-limit", "chamber-does-not-reach"),
}
WAYS = ["tcp", "prologix"] + (["pty", "prologix-pty"] if hasattr(os, "openpty") else [])


def test_every_scenario_is_tested_here() -> None:
    assert {*JUDGED, *REFUSED, *RECOVERED, *ELSEWHERE} == set(SCENARIOS)


@pytest.mark.parametrize("model", MODELS)
@pytest.mark.parametrize("scenario", JUDGED)
def test_a_unit_is_judged(tmp_path: Path, model: str, scenario: str) -> None:
    record = short_run(tmp_path, model, "tcp", scenario=scenario)
    assert record.verdict is JUDGED[scenario]
    attempt = only_attempt(record)
    if record.verdict is Verdict.FAIL:
        assert "angle_random_walk" in attempt.message
        assert "bias_stability_1s" in attempt.message


@pytest.mark.parametrize("model", MODELS)
@pytest.mark.parametrize("scenario", REFUSED)
def test_what_cannot_be_measured_is_an_error_that_names_its_cause(
    tmp_path: Path, model: str, scenario: str
) -> None:
    record = short_run(tmp_path, model, "tcp", scenario=scenario)
    assert record.verdict is Verdict.INCOMPLETE
    (missing,) = record.missing
    assert REFUSED[scenario] in missing
    attempt = only_attempt(record)
    assert attempt.outcome is Outcome.ERROR
    assert attempt.results == ()
    assert attempt.recording is not None
    assert attempt.recording.complete == (scenario == "dead-output")
    assert attempt.recording.samples >= 70  # what was recorded is kept


@pytest.mark.parametrize("model", MODELS)
@pytest.mark.parametrize("scenario", RECOVERED)
def test_a_gap_is_refused_where_the_spec_does_not_say_otherwise(
    tmp_path: Path, model: str, scenario: str
) -> None:
    record = short_run(tmp_path, model, "tcp", scenario=scenario)
    assert record.verdict is Verdict.INCOMPLETE
    (missing,) = record.missing
    cause, _ = RECOVERED[scenario]
    assert cause in missing
    assert "gaps: longest_stretch" in missing
    recording = only_attempt(record).recording
    assert recording is not None
    assert recording.complete


@pytest.mark.parametrize("way", WAYS)
@pytest.mark.parametrize("model", MODELS)
@pytest.mark.parametrize("scenario", RECOVERED)
def test_a_meter_that_comes_back_leaves_a_gap_and_results_of_the_longest_stretch(
    tmp_path: Path, model: str, scenario: str, way: str
) -> None:
    record = short_run(tmp_path, model, way, scenario=scenario, gaps="longest_stretch")
    assert record.verdict is Verdict.PASS
    attempt = only_attempt(record)
    recording = attempt.recording
    assert recording is not None
    assert recording.complete
    cause, times = RECOVERED[scenario]
    if scenario == "meter-disconnects" and way.endswith("pty"):
        cause = "no reply to"  # a serial line cannot hang up
    assert len(recording.gaps) == times
    assert all(cause in gap.reason for gap in recording.gaps)
    assert recording.samples + sum(gap.missing for gap in recording.gaps) == 180
    assert all(0 < gap.missing <= 12 for gap in recording.gaps)
    assert sum("recovered" in event for event in attempt.events) == times
    assert any("has gaps; used: samples" in event for event in attempt.remarks)
    bias = next(one for one in attempt.results if one.name == "bias")
    assert "longest gap-free stretch" in bias.condition
