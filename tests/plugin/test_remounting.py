"""Units that are mounted anew between two repeats: asked for, answered, or in two runs that are joined."""

import json
from pathlib import Path
from typing import Any

from gyrotest.runner.folder import HEADER

from .project import Project

# A turn of the stage at 12 degrees a second lasts 30 s.
GRAVITY = """
model: SHORT50
serial_pattern: '[0-9]{4,8}'
output:
  kind: voltage
  scale_factor: 50 mV/(deg/s)
  scale_factor_uncertainty: 0.5 %
  zero_rate: 2.5 V
  full_scale: 100 deg/s
  bandwidth: 50 Hz
cases:
  gravity:
    procedure: g_sensitivity
    warm_up: 10 min
    duration: 2 s
    interval: 20 ms
    repeats: 2
    parameters: {rate: 12 deg/s, run_up: 15 deg, turns: 1}
    limits:
      g_sensitivity_x: {min: -0.5 deg/s/g, max: 0.5 deg/s/g, over: repeats}
      g_sensitivity_y: {min: -0.5 deg/s/g, max: 0.5 deg/s/g, over: repeats}
      g_sensitivity_z: {min: -0.5 deg/s/g, max: 0.5 deg/s/g, over: repeats}
"""
# Somebody mounts the units of the simulated bench.
BY_HAND = """
from gyrotest.runner.bench import Bench
Bench.by_hand = property(lambda bench: True)
"""
ASKED = "Mount unit 1234 in slot 'shaft_x' turned by 90° about its own x axis"
CONFIRMED = "Mounted turned by 90° about its own x axis, as the operator confirmed."


def records(project: Project) -> dict[str, Any]:
    """The records of the latest runs, by serial number."""
    found = sorted(project.path.glob("reports/*/*/run.json"))
    return {path.parent.parent.name: json.loads(path.read_text(encoding="utf-8")) for path in found}


def run_folder(project: Project) -> Path:
    (found,) = project.path.glob("reports/1234/*")
    return found.relative_to(project.path)


def outcomes(record: Any) -> dict[str, list[str]]:
    return {
        item["plan"]["name"]: [attempt["outcome"] for attempt in item["attempts"]]
        for item in record["items"]
    }


def last(record: Any, item: str) -> Any:
    (found,) = [one for one in record["items"] if one["plan"]["name"] == item]
    return found["attempts"][-1]


def test_two_runs_with_a_mounting_each_are_joined_and_the_second_asks_for_it(project: Project) -> None:
    project.write("specs/gravity.yaml", GRAVITY)
    project.write("by_hand.py", BY_HAND)
    today = project.pytest("-p", "by_hand", "-k", "r1", spec="gravity.yaml")
    assert today.code == 1, today.out
    assert "1234: INCOMPLETE" in today
    assert "Mount unit" not in today
    resume = ("--gyro-resume", str(run_folder(project)))
    # Nobody is there, and nobody has answered: nothing is measured as if it were mounted so.
    unasked = project.pytest("-p", "by_hand", *resume, spec="gravity.yaml")
    assert unasked.code == 1, unasked.out
    assert ASKED in unasked
    assert "nobody is there to do it (no terminal); say --gyro-yes if it is done" in unasked
    tomorrow = project.pytest("-p", "by_hand", "--gyro-yes", *resume, spec="gravity.yaml")
    assert tomorrow.code == 0, tomorrow.out
    assert "1234: PASS" in tomorrow
    record = records(project)["1234"]
    assert outcomes(record) == {
        "gravity-1234-r1": ["passed"],
        "gravity-1234-r2": ["error", "passed"],
        "gravity-1234-repeats": ["skipped", "passed"],
    }
    assert CONFIRMED in last(record, "gravity-1234-r2")["remarks"]
    assert not any("Mounted" in one for one in last(record, "gravity-1234-r1")["remarks"])
    assert {one["name"] for one in last(record, "gravity-1234-repeats")["results"]} >= {
        "g_sensitivity_x",
        "g_sensitivity_y",
        "g_sensitivity_z",
    }


def test_two_units_on_one_stage_are_turned_at_once_and_certified_each_for_itself(
    project: Project,
) -> None:
    project.write("specs/gravity.yaml", GRAVITY)
    project.write("by_hand.py", BY_HAND)
    ended = project.pytest("-p", "by_hand", "--gyro-yes", spec="gravity.yaml", serial="1234,1235")
    assert ended.code == 0, ended.out
    # Each repeat is acquired once, for both.
    assert ended.out.count("samples every 0.02 s") == 2
    found = records(project)
    assert sorted(found) == ["1234", "1235"]
    truths, angles = [], []
    for serial, record in found.items():
        assert record["verdict"] == "PASS"
        assert all(one == ["passed"] for one in outcomes(record).values())
        attempt = last(record, f"gravity-{serial}-r2")
        assert CONFIRMED in attempt["remarks"]
        assert [one["name"] for one in attempt["instruments"]] == ["shaft_daq", "stage"]
        truths.append(attempt["truth"]["turn_on_bias_dps"])
        angles.append([one["began_s"] for one in attempt["recording"]["dwells"]])
    headers = [*sorted(project.path.glob(f"reports/*/*/{HEADER}"))]
    slots = [json.loads(path.read_text(encoding="utf-8"))["slot"] for path in headers]
    assert slots == ["shaft_x", "shaft_z"]
    assert truths[0] != truths[1]
    assert angles[0] == angles[1]
    assert len([*project.path.glob("reports/*/*/*_PASS.pdf")]) == 2
