"""A rotation stage in whole runs: two units at once, what goes wrong, and units mounted by hand."""

import contextlib
import re
import socket
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from gyrotest.errors import AcquisitionError, RefusedError
from gyrotest.records.result import Verdict
from gyrotest.records.run import Outcome, PlannedItem
from gyrotest.runner.bench import Bench
from gyrotest.simulation.clock import VirtualClock
from gyrotest.simulation.server import TcpServer, has_pty
from gyrotest.simulation.table import SimulatedTable
from gyrotest.simulation.table_peer import TablePeer
from gyrotest.specification.lookup import shipped_specs

from .bench_run import SHORT_TURN, BenchRun, bench_run

STATION = (shipped_specs() / "stations" / "simulated.yaml").read_text("utf-8")
needs_pty = pytest.mark.skipif(not has_pty(), reason="this platform has no pseudo-terminals")
FIRST, SECOND, BOTH = "gravity-1234-r1", "gravity-1234-r2", "gravity-1234-repeats"
TABLES = ["driver: acutrol3000", pytest.param("driver: aerosmith", marks=needs_pty)]


def with_stage(driver: str) -> str:
    """The shipped station with another controller of its stage."""
    # Its rate follows from two positions, which are closer together here than by default.
    of_pty = "simulated:pty\n    settings: {rate_span: 300 ms}"
    way = of_pty if "aerosmith" in driver else "simulated"
    before, stage, after = STATION.partition("  stage: ")
    assert stage
    return (
        before
        + stage
        + re.sub(
            r"driver: acutrol3000\n    resource: simulated",
            f"{driver}\n    resource: {way}",
            after,
            count=1,
        )
    )


def stage_of(ran: BenchRun) -> SimulatedTable:
    ran.simulated.address("stage")
    peer = ran.simulated._peers["stage"]
    assert isinstance(peer, TablePeer)
    return peer.table


def angles_deg(ran: BenchRun) -> list[float]:
    """Where the stage is at every tick of the clock from now on, the latest last."""
    clock, found = ran.bench.clock, list[float]()
    stage = stage_of(ran)
    assert isinstance(clock, VirtualClock)
    clock.subscribe(lambda now_s: found.append(float(stage.angle_deg(np.array([now_s]))[0])))
    return found


def once(ran: BenchRun, due: Callable[[float], bool], strike: Callable[[], None]) -> None:
    """Let something happen on the simulated bench, the first time that it is due."""
    clock, struck = ran.bench.clock, list[float]()

    def moved(now_s: float) -> None:
        if not struck and due(now_s):
            struck.append(now_s)
            strike()

    assert isinstance(clock, VirtualClock)
    clock.subscribe(moved)


@pytest.mark.parametrize("driver", TABLES)
def test_a_stage_turns_within_its_turn_and_the_record_says_how(tmp_path: Path, driver: str) -> None:
    with bench_run(tmp_path, SHORT_TURN, with_stage(driver)) as ran:
        seen = angles_deg(ran)
        record = ran.carry_out()
        assert ran.said == {}
        recordings = [ran.attempt(one).recording for one in (FIRST, SECOND)]
        # Nobody was asked: the simulated bench mounts its units itself.
        assert "Mounted turned by 90° about its own x axis." in ran.attempt(SECOND).remarks
        assert seen[-1] == pytest.approx(0.0, abs=0.3)
    assert record.verdict is Verdict.PASS
    assert -0.5 <= min(seen) <= 0.5 < 345.0 < max(seen) <= 360.5
    for one in recordings:
        assert one is not None
        assert [each.rate_dps for each in one.dwells] == [None, 12.0, -12.0, None]
        assert [each.position_deg for each in one.dwells] == [0.0, None, None, 0.0]
        assert one.dwells[1].measured_rate_dps == pytest.approx(12.0, abs=0.01)
        assert one.dwells[3].measured_position_deg == pytest.approx(0.0, abs=0.1)


OF_STAGES = {
    "table-does-not-reach-rate": r"12 deg/s is demanded, 7\.[0-9]* deg/s read back .*is stopped",
    "table-refuses": "refused; ",
    "table-interlock": r"interlock fault of axis 1|12 deg/s is demanded, [-.0-9e]* deg/s read back on its way"
    "|does not come to",
}


@pytest.mark.parametrize("driver", TABLES)
@pytest.mark.parametrize("scenario", OF_STAGES)
def test_a_stage_that_fails_is_said_each_time_and_left_at_rest(
    tmp_path: Path, scenario: str, driver: str
) -> None:
    with bench_run(tmp_path, SHORT_TURN, with_stage(driver), scenario=scenario) as ran:
        seen = angles_deg(ran)
        record = ran.carry_out()
        for item in (FIRST, SECOND):
            assert re.search(OF_STAGES[scenario], ran.said[item]), ran.said[item]
            assert "(step '" in ran.said[item]
            assert ran.attempt(item).outcome is Outcome.ERROR
        assert "lacks" in ran.said[BOTH]
        kept = ran.attempt(FIRST).recording
        ran.bench.clock.sleep_until(ran.bench.clock.now_s() + 2.0)
        assert abs(stage_of(ran).read_rate_dps()) < 0.01
    assert kept is not None
    assert not kept.complete
    assert min(seen) >= -0.5
    assert max(seen) <= 360.5
    assert record.verdict is Verdict.INCOMPLETE


def test_a_stage_whose_connection_is_lost_is_stopped_over_another_and_used_again(tmp_path: Path) -> None:
    with bench_run(tmp_path, SHORT_TURN, STATION) as ran:
        stage = stage_of(ran)
        seen = angles_deg(ran)
        port = int(ran.simulated.address("stage").split("::")[2])

        def lose() -> None:
            for one in ran.simulated._wires._servers:
                if isinstance(one, TcpServer) and one.port == port:
                    for connection in tuple(one._connections):
                        with contextlib.suppress(OSError):
                            connection.shutdown(socket.SHUT_RDWR)

        once(ran, lambda _: stage.demanded_dps == 12.0 and seen[-1] > 100.0, lose)
        record = ran.carry_out(before=lambda _: _at_rest(stage))
        outcomes = [ran.attempt(one).outcome for one in (FIRST, SECOND)]
        kept = ran.attempt(FIRST).recording
    assert "connection lost" in ran.said[FIRST]
    assert "(step 'turn 1 forward' at 12 °/s)" in ran.said[FIRST]
    assert outcomes == [Outcome.ERROR, Outcome.PASSED]
    assert kept is not None
    assert [one.name for one in kept.dwells] == ["rest before", "turn 1 forward"]
    assert min(seen) >= -0.5
    assert max(seen) <= 360.5
    assert record.verdict is Verdict.INCOMPLETE


def _at_rest(stage: SimulatedTable) -> None:
    assert abs(stage.read_rate_dps()) < 0.1


def without(*keys: str) -> str:
    """The shipped station without some lines, each with what is indented below it."""
    text = STATION
    for key in keys:
        text, count = re.subn(rf"(?m)^( *){key}:[^\n]*\n(?:\1 +[^\n]*\n)*", "", text, count=1)
        assert count == 1, key
    return text


@pytest.mark.parametrize(
    ("station", "said"),
    [
        (
            without("shaft"),
            "instrument 'stage' has no 'shaft'; state how it lies, e.g. {azimuth: 37 deg",
        ),
        (
            without("azimuth"),
            "the shaft of instrument 'stage' has no 'azimuth'; state where the stage's x",
        ),
        (without("site"), "does not say where it stands; give it a 'site', e.g. {latitude: 48.1 deg}"),
        (
            STATION.replace("    encoder: {angle: angle, accuracy: 0.005 deg}\n", ""),
            "slot 'shaft_x' of station 'Simulated bench' has no encoder; give it an 'encoder'",
        ),
        (
            STATION.replace("frame: {x: x, y: y, z: z}", "frame: {x: -y, y: x, z: z}"),
            "slot 'shaft_x' of station 'Simulated bench' puts the sensitive axis x along the shaft",
        ),
        (STATION.replace(", max_turns: 1}", ", max_turns: 0.5}"), "of its cables ±0.5 turns are stated"),
        (
            STATION.replace(
                "max_acceleration: 50 deg/s/s, max_turns", "max_acceleration: 8 deg/s/s, max_turns"
            ),
            "the run-up of 15° is too short: from rest to 12 deg/s at 8 deg/s²",
        ),
    ],
    ids=["shaft", "azimuth", "site", "encoder", "frame", "cables", "run-up"],
)
def test_what_a_station_lacks_for_a_stage_is_refused_at_the_door_with_what_to_add(
    tmp_path: Path, station: str, said: str
) -> None:
    with pytest.raises(RefusedError) as caught, bench_run(tmp_path, SHORT_TURN, station):
        raise AssertionError("the door is open")
    assert said in str(caught.value)
    assert str(caught.value).startswith("gravity: ")


class Operator:
    """Who mounts units by hand, and looks at the stage before."""

    def __init__(self, ran: BenchRun, *, willing: bool = True) -> None:
        self._ran = ran
        self._willing = willing
        self.asked: list[str] = []

    def confirm(self, text: str) -> None:
        self.asked.append(text)
        assert stage_of(self._ran).demanded_dps == 0.0
        assert abs(stage_of(self._ran).read_rate_dps()) < 0.1
        if not self._willing:
            raise AcquisitionError(f"{text}: stopped by the operator")


@pytest.fixture
def by_hand(monkeypatch: pytest.MonkeyPatch) -> None:
    """The units of the simulated bench are mounted by somebody."""
    monkeypatch.setattr(Bench, "by_hand", property(lambda _: True))


@pytest.mark.usefixtures("by_hand")
def test_the_operator_is_asked_between_the_mountings_and_the_record_says_so(tmp_path: Path) -> None:
    with bench_run(tmp_path, SHORT_TURN, STATION) as ran:
        operator = Operator(ran)
        ran.run.confirm = operator.confirm
        record = ran.carry_out()
        remarks = [ran.attempt(one).remarks for one in (FIRST, SECOND)]
    assert record.verdict is Verdict.PASS
    (asked,) = operator.asked
    assert asked == (
        "gravity-1234-r2: 'stage' is at rest and switched off; the power stays on. Mount unit 1234 in slot"
        " 'shaft_x' turned by 90° about its own x axis; angles count right-handed about that axis, from the"
        " mounting that the slot describes"
    )
    assert not any("Mounted" in one for one in remarks[0])
    assert "Mounted turned by 90° about its own x axis, as the operator confirmed." in remarks[1]


@pytest.mark.usefixtures("by_hand")
def test_a_run_that_begins_with_the_second_mounting_asks_for_it_and_again_for_the_first(
    tmp_path: Path,
) -> None:
    with bench_run(tmp_path, SHORT_TURN, STATION) as ran:
        operator = Operator(ran)
        ran.run.confirm = operator.confirm
        first, second, _ = ran.run.header.plan
        for item in (second, first):
            ran.run.judge(item, ran.run.acquire(item))
        remarks = ran.attempt(FIRST).remarks
    assert operator.asked[0].startswith(
        "gravity-1234-r2: 'stage' has not been switched on; the power stays on. Mount unit 1234"
    )
    assert "as its slot describes it (turned by 0° about its own x axis)" in operator.asked[1]
    assert any("as its slot describes it" in one and "confirmed" in one for one in remarks)


@pytest.mark.usefixtures("by_hand")
def test_an_operator_who_stops_ends_the_acquisition_and_is_asked_again(tmp_path: Path) -> None:
    with bench_run(tmp_path, SHORT_TURN, STATION) as ran:
        refusing, willing = Operator(ran, willing=False), Operator(ran)
        ran.run.confirm = refusing.confirm
        ran.carry_out()
        assert ran.attempt(SECOND).outcome is Outcome.ERROR
        assert "stopped by the operator" in ran.said[SECOND]
        ran.run.confirm = willing.confirm
        ran.said.clear()
        ran.carry_out()
        assert ran.said == {}
        assert [one.outcome for one in ran.run.folder.attempts(SECOND)] == [
            Outcome.ERROR,
            Outcome.PASSED,
        ]
    assert len(refusing.asked) == len(willing.asked) == 1


@pytest.mark.usefixtures("by_hand")
def test_what_stands_in_the_record_tells_how_the_unit_was_mounted_last(tmp_path: Path) -> None:
    with bench_run(tmp_path, SHORT_TURN, STATION) as ran:
        ran.run.confirm = Operator(ran).confirm
        second: PlannedItem = ran.run.header.plan[1]
        ran.run.judge(second, ran.run.acquire(second))
        # Another process goes on with the run, and knows nothing but its record.
        ran.bench.mounted = type(ran.bench.mounted)()
        operator = Operator(ran)
        ran.run.confirm = operator.confirm
        first = ran.run.header.plan[0]
        ran.run.judge(first, ran.run.acquire(first))
    (asked,) = operator.asked
    assert "as its slot describes it" in asked
