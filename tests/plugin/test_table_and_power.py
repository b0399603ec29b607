"""Rate table, power and digital gyros as the user has them: interrupted, resumed, refused, taken part by part."""

import json
import signal
import sys
from typing import Any

import pytest

from gyrotest.specification.lookup import shipped_specs

from .project import Ended, Project, Session

posix = pytest.mark.skipif(sys.platform == "win32", reason="signals are sent as POSIX does")
TABLE = """
model: SHORT50
serial_pattern: '[0-9]{4,8}'
output:
  kind: voltage
  scale_factor: 50 mV/(deg/s)
  scale_factor_uncertainty: 0.5 %
  zero_rate: 2.5 V
  full_scale: 100 deg/s
  bandwidth: 50 Hz
supply: {voltage: 5 V, current_limit: 100 mA, over_voltage: 5.5 V}
cases:
  turns:
    procedure: scale_factor
    duration: 10 s
    interval: 0.5 s
    repeats: 2
    mounting: [1, 0, 0]
    parameters: {rates: [20 deg/s, 40 deg/s], settle: 1 s}
    limits: {nonlinearity: {max: 1000 ppm}}
  rest:
    procedure: bias_repeatability
    duration: 40 s
    interval: 1 s
    repeats: 2
    between_repeats: power_cycle
    mounting: [1, 0, 0]
    limits: {bias_repeatability: {max: 1 deg/s, over: repeats}}
"""
DIGITAL = """
model: STIM300
serial_pattern: '[0-9]{4,8}'
output: {kind: rate, axes: [x, y, z], mode: rate, full_scale: 400 deg/s, bandwidth: 33 Hz}
supply: {voltage: 5 V, current_limit: 500 mA, over_voltage: 5.5 V}
cases:
  still:
    procedure: static
    duration: 8 s
    interval: 8 ms
    mountings: {x: [0, 1, 0], y: [0, 0, 1], z: [1, 0, 0]}
    parameters: {smoothing: [1 s]}
    limits: {bias: {min: -2 deg/s, max: 2 deg/s}}
  coefficients:
    procedure: scale_factor
    duration: 4 s
    interval: 8 ms
    axes: [z]
    mountings: {z: [1, 0, 0]}
    parameters: {rates: [20 deg/s, 60 deg/s], settle: 1 s}
    limits: {scale_factor_error: {min: -1 %, max: 1 %}}
  compensation:
    procedure: compensation
    duration: 4 s
    interval: 8 ms
    axes: [z]
    mountings: {z: [1, 0, 0]}
    parameters: {scale_factor_from: coefficients, rates: [30 deg/s]}
    limits: {residual_rms_after: {max: 0.1 deg/s}}
"""
# The process ends itself, or a user's hook breaks, at a sample that is known. What the simulated bench
# looked like when it was left is written down when it closes.
ENDS_ITSELF = """
import json, os, signal
import numpy as np
from pathlib import Path
from gyrotest.acquisition.acquire import Acquisition
from gyrotest.simulation.bench import SimulatedBench

kept, closed = Acquisition._keep, SimulatedBench.close
left = []

def keep(self, tracks, block):
    kept(self, tracks, block)
    if self._base + block.first + len(block.flags) >= int(os.environ["END_AT"]) and not left:
        left.append(self)
        {what}

def close(self):
    state = {{}}
    if "table" in self._peers:
        now_s = self.clock.now_s()
        self.clock.sleep_until(now_s + 10.0)
        angles = self._peers["table"].table.angle_deg(np.array([now_s + 5.0, now_s + 10.0]))
        state["turned_deg"] = abs(float(angles[1] - angles[0]))
    if "supply" in self._peers:
        state["on"] = self._peers["supply"].output(1).on
    if state:
        Path("left.json").write_text(json.dumps(state))
    closed(self)

SimulatedBench.close = close
if "END_AT" in os.environ:
    Acquisition._keep = keep
"""


def end_in_mid_run(
    project: Project, what: str, *, spec: str, at: int, more: tuple[str, ...] = ()
) -> Ended:
    project.write("conftest.py", ENDS_ITSELF.format(what=what))
    return project.pytest(*more, spec=spec, environment={"END_AT": str(at)})


def kill(number: signal.Signals) -> str:
    return f"os.kill(os.getpid(), signal.{number.name})"


def left(project: Project) -> Any:
    return json.loads((project.path / "left.json").read_text(encoding="utf-8"))


def results(project: Project, out: str = "reports") -> dict[str, list[tuple[str, str, float]]]:
    (path,) = (project.path / out).glob("1234/*/run.json")
    record = json.loads(path.read_text(encoding="utf-8"))
    return {
        attempt["item"]: [(one["name"], one.get("axis", ""), one["value"]) for one in attempt["results"]]
        for item in record["items"]
        for attempt in item["attempts"][-1:]
        if attempt["results"]
    }


def agree(project: Project, part: str, whole: str = "reports") -> set[str]:
    """The items of a part of a run, whose values are those of the whole run."""
    of_part, of_whole = results(project, part), results(project, whole)
    for item, found in of_part.items():
        for one, expected in zip(found, of_whole[item], strict=True):
            assert one[:2] == expected[:2]
            # Sums of the bench's time differ in the last digit by how much of it has passed.
            assert one[2] == pytest.approx(expected[2], rel=1e-10), (item, one, expected)
    return set(of_part)


@posix
def test_a_run_that_is_ended_in_mid_turn_is_safe_goes_on_and_has_the_values_of_the_whole(
    project: Project,
) -> None:
    project.write("specs/table.yaml", TABLE)
    ended = end_in_mid_run(project, kill(signal.SIGTERM), spec="table.yaml", at=70)
    assert ended.code == 2, ended.out
    assert left(project) == {"turned_deg": pytest.approx(0.0, abs=0.01), "on": False}
    attempt = project.record()["items"][0]["attempts"][0]
    assert attempt["outcome"] == "interrupted"
    assert [one["rate_dps"] for one in attempt["recording"]["dwells"]] == [0.0, 20.0, -20.0, 40.0]
    assert 70 <= attempt["recording"]["samples"] < 80
    assert "INCOMPLETE" in project.certificates()[0].name
    (run,) = project.runs()
    project.write("conftest.py", "")
    whole, part, resumed = project.sessions(
        Session(spec="table.yaml"),
        Session(spec="table.yaml", arguments=("-k", "r2")),
        Session(spec="table.yaml", arguments=("--gyro-resume", str(run))),
    )
    assert [one.code for one in (whole, part, resumed)] == [0, 1, 0], resumed.out
    assert agree(project, "out_1", "out_0") == {"turns-1234-r2", "rest-1234-r2"}
    assert len(agree(project, "reports", "out_0")) == 6
    assert project.record()["verdict"] == "PASS"
    attempts = project.record()["items"][0]["attempts"]
    assert [one["outcome"] for one in attempts] == ["interrupted", "passed"]


def test_a_hook_that_breaks_leaves_the_bench_safe(project: Project) -> None:
    project.write("specs/table.yaml", TABLE)
    watching = ENDS_ITSELF.format(what="pass")
    project.write(
        "conftest.py", watching + "def pytest_gyro_acquired(item):\n    raise RuntimeError('boom')\n"
    )
    ended = project.pytest("-k", "turns", spec="table.yaml", environment={"END_AT": "1000000"})
    assert ended.code == 1, ended.out
    assert left(project) == {"turned_deg": pytest.approx(0.0, abs=0.01), "on": False}
    record = project.record()
    assert record["verdict"] == "INCOMPLETE"
    assert "boom" in record["items"][0]["attempts"][0]["message"]
    assert "INCOMPLETE" in project.certificates()[0].name


@posix
def test_an_exception_in_mid_turn_leaves_the_bench_safe_and_the_next_item_goes_on(
    project: Project,
) -> None:
    project.write("specs/table.yaml", TABLE)
    ended = end_in_mid_run(project, "raise RuntimeError('boom')", spec="table.yaml", at=70)
    assert ended.code == 1, ended.out
    assert left(project) == {"turned_deg": pytest.approx(0.0, abs=0.01), "on": False}
    record = project.record()
    assert record["verdict"] == "INCOMPLETE"
    outcomes = [item["attempts"][0]["outcome"] for item in record["items"]]
    assert outcomes == ["error", "passed", "skipped", "passed", "passed", "passed"]
    attempt = record["items"][0]["attempts"][0]
    assert "boom" in attempt["message"]
    assert attempt["recording"]["samples"] >= 70


def test_what_the_table_cannot_do_is_refused_and_nothing_is_sent(project: Project) -> None:
    text = (shipped_specs() / "stations" / "simulated.yaml").read_text(encoding="utf-8")
    project.write("specs/table.yaml", TABLE)
    project.write("specs/fast.yaml", TABLE.replace("40 deg/s]", "600 deg/s]"))
    project.write("cables.yaml", text.replace("slip_ring: true", "max_turns: 1"))
    too_fast = end_in_mid_run(project, "pass", spec="fast.yaml", at=10**9)
    wound_up = project.pytest(
        "--gyro-station", "cables.yaml", spec="table.yaml", environment={"END_AT": "1000000"}
    )
    assert (too_fast.code, wound_up.code) == (4, 4)
    assert "600 deg/s is more than the table's 500 deg/s (motion.max_rate)" in too_fast
    assert "turns from its start, the cables allow ±1 (motion.max_turns)" in wound_up
    assert not (project.path / "left.json").exists()
    assert not (project.path / "reports").exists()


@pytest.mark.slow
def test_axes_dwells_and_exports_are_reported_verified_and_judged_anew(project: Project) -> None:
    project.write("specs/digital.yaml", DIGITAL)
    ended = project.pytest(spec="digital.yaml")
    assert ended.code == 0, ended.out
    (run,) = project.runs()
    exports = {path.name for path in run.rglob("*") if path.suffix in {".csv", ".json"}}
    assert any("coefficients" in one for one in exports), exports
    stricter = project.write("stricter.yaml", DIGITAL.replace("max: 0.1 deg/s", "max: 1e-6 deg/s"))
    told = project.python(f"""
        from gyrotest.cli import main
        assert main(["verify", "{run}"]) == 0
        assert main(["report", "{run}"]) == 0
        main(["judge", "{run}", "--spec", "{stricter}"])
    """)
    assert told.code == 0, told.out
    assert "FAIL" in told
