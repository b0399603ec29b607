"""What goes wrong with table, supply, chamber or a digital gyro: said, kept, INCOMPLETE, and the bench safe."""

import re
import socket
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import pytest

from gyrotest.records.result import Verdict
from gyrotest.records.run import Outcome, PlannedItem
from gyrotest.simulation.clock import VirtualClock
from gyrotest.simulation.server import TcpServer, has_pty
from gyrotest.simulation.supply import OutputFault, SimulatedOutput
from gyrotest.specification.lookup import shipped_specs

from .bench_run import BenchRun, bench_run

STATION = shipped_specs() / "stations" / "simulated.yaml"
needs_pty = pytest.mark.skipif(not has_pty(), reason="this platform has no pseudo-terminals")
VOLTAGE = """
model: SHORT50
output:
  kind: voltage
  scale_factor: 50 mV/(deg/s)
  scale_factor_uncertainty: 0.5 %
  zero_rate: 2.5 V
  full_scale: 100 deg/s
  bandwidth: 50 Hz
supply: {voltage: 5 V, current_limit: 100 mA, over_voltage: 5.5 V}
cases:
"""
TURNS = """
  {name}:
    procedure: scale_factor
    duration: 10 s
    interval: 0.5 s
    mounting: [1, 0, 0]
    parameters: {{rates: {rates}, settle: 1 s}}
    limits: {{nonlinearity: {{max: 1000 ppm}}}}
"""
REST = """
  rest:
    procedure: static
    duration: 40 s
    interval: 1 s
    mounting: [1, 0, 0]
    parameters: {smoothing: [1 s]}
    limits: {bias: {min: -2 deg/s, max: 2 deg/s}}
"""
FIRST, SECOND, AT_REST = "first-1234-r1", "second-1234-r1", "rest-1234-r1"


def turns(name: str, rates: str = "[20 deg/s, 40 deg/s]") -> str:
    return TURNS.format(name=name, rates=rates)


TWICE = VOLTAGE + turns("first") + turns("second") + REST
AEROSMITH = "driver: aerosmith\n    resource: simulated:pty"


def with_table(text: str) -> str:
    return STATION.read_text("utf-8").replace("driver: acutrol3000\n    resource: simulated", text)


def is_safe(ran: BenchRun) -> None:
    assert ran.table.demanded_dps == 0.0
    assert ran.turned_deg(10.0) < 0.01


TABLES = ["driver: acutrol3000\n    resource: simulated", pytest.param(AEROSMITH, marks=needs_pty)]
OF_TABLES = {
    "table-does-not-reach-rate": r"20 deg/s is demanded, 1[12][.0-9]* deg/s read back.*is stopped; look at",
    "table-refuses": "refused; ",
    "table-interlock": "interlock fault of axis 1.*start the run again|left its rate: .*look at its interlocks",
}


@pytest.mark.parametrize("table", TABLES)
@pytest.mark.parametrize("scenario", OF_TABLES)
def test_a_table_that_fails_is_said_each_time_and_left_at_rest(
    tmp_path: Path, scenario: str, table: str
) -> None:
    def resting(item: PlannedItem) -> None:
        if item.name != FIRST:
            assert abs(ran.table.read_rate_dps()) < 0.1

    with bench_run(tmp_path, TWICE, with_table(table), scenario=scenario) as ran:
        record = ran.carry_out(before=resting)
        is_safe(ran)
        for item in (FIRST, SECOND):
            assert re.search(OF_TABLES[scenario], ran.said[item]), ran.said[item]
            assert "(step '" in ran.said[item]
            assert ran.attempt(item).outcome is Outcome.ERROR
            assert ran.took_s[item] < 10.0
        assert ran.attempt(AT_REST).outcome is Outcome.PASSED
        kept = ran.attempt(FIRST).recording
    assert kept is not None
    assert not kept.complete
    if scenario != "table-refuses":
        assert kept.dwells[0].name == "rest before"
        assert kept.samples >= 20
    assert record.verdict is Verdict.INCOMPLETE
    assert len(record.missing) == 2
    assert not ran.output.on


def once(ran: BenchRun, due: Callable[[float], bool], strike: Callable[[float], None]) -> None:
    """Let something happen on the simulated bench, the first time that it is due."""
    clock, struck = ran.bench.clock, []

    def moved(now_s: float) -> None:
        if not struck and due(now_s):
            struck.append(now_s)
            strike(now_s)

    assert isinstance(clock, VirtualClock)
    clock.subscribe(moved)


def test_a_table_whose_connection_is_lost_is_stopped_over_another_and_used_again(tmp_path: Path) -> None:
    with bench_run(tmp_path, TWICE, STATION) as ran:
        port = int(ran.simulated.address("table").split("::")[2])
        turning_since: list[float] = []

        def in_mid_dwell(now_s: float) -> bool:
            if ran.table.demanded_dps == 40.0:
                turning_since.append(now_s)
            return bool(turning_since) and now_s > turning_since[0] + 4.0

        def lose(_: float) -> None:
            for one in ran.simulated._wires._servers:
                if isinstance(one, TcpServer) and one.port == port:
                    for connection in one._connections:
                        connection.shutdown(socket.SHUT_RDWR)

        def resting(item: PlannedItem) -> None:
            assert abs(ran.table.read_rate_dps()) < 0.1

        once(ran, in_mid_dwell, lose)
        record = ran.carry_out(before=resting)
        is_safe(ran)
        attempts = [ran.attempt(name) for name in (FIRST, SECOND, AT_REST)]
    assert turning_since
    assert "connection lost" in ran.said[FIRST]
    assert "see that the table is at rest" in ran.said[FIRST]
    assert "(step 'turn 3' at 40 °/s)" in ran.said[FIRST]
    assert [one.outcome for one in attempts] == [Outcome.ERROR, Outcome.PASSED, Outcome.PASSED]
    kept = attempts[0].recording
    assert kept is not None
    assert 60 < kept.samples < 80
    assert [one.rate_dps for one in kept.dwells] == [0.0, 20.0, -20.0, 40.0]
    assert record.verdict is Verdict.INCOMPLETE


def shorted(output: SimulatedOutput, now_s: float) -> None:
    output.figures = replace(output.figures, fault=OutputFault.SHORTED)
    output.set_voltage(now_s, output.voltage_set_v)


def switched_off(output: SimulatedOutput, now_s: float) -> None:
    output.switch(now_s, on=False)


def tripped(output: SimulatedOutput, now_s: float) -> None:
    output.set_protection(now_s, 3.0)


def fail_in_mid_run(ran: BenchRun, how: Callable[[SimulatedOutput, float], None]) -> None:
    powered: list[float] = []

    def due(now_s: float) -> bool:
        if "supply" in ran.simulated._peers and ran.output.on_since_s is not None:
            powered.append(now_s)
        return bool(powered) and now_s > powered[0] + 25.0

    once(ran, due, lambda now_s: how(ran.output, now_s))


OF_SUPPLIES = {
    "supply-no-voltage": "the voltage does not come up: 5 V at up to 0.1 A is asked for, found 0 V",
    "supply-current-limit": "in current limit: 5 V at up to 0.1 A is asked for, found 0.5 V and 0.1 A; is the",
}


@pytest.mark.parametrize("scenario", OF_SUPPLIES)
def test_a_supply_that_does_not_come_up_is_said_and_left_off(tmp_path: Path, scenario: str) -> None:
    with bench_run(tmp_path, VOLTAGE + turns("first") + REST, STATION, scenario=scenario) as ran:
        record = ran.carry_out(before=lambda _: None)
        assert not ran.output.on
        assert "table" not in ran.simulated._peers  # nothing was turned without power
    for item in (FIRST, AT_REST):
        assert OF_SUPPLIES[scenario] in ran.said[item]
        assert ran.attempt(item).outcome is Outcome.ERROR
    assert record.verdict is Verdict.INCOMPLETE


@pytest.mark.parametrize(
    ("how", "said", "goes_on"),
    [
        (switched_off, "the supply failed in the meantime: 5 V at up to 0.1 A is asked for", True),
        (shorted, "in current limit: 5 V", False),
        (tripped, "the over-voltage protection has tripped", False),
    ],
)
def test_a_supply_that_fails_in_mid_run_is_found_and_switched_off(
    tmp_path: Path, how: Callable[[SimulatedOutput, float], None], said: str, goes_on: bool
) -> None:
    with bench_run(tmp_path, VOLTAGE + REST + turns("second"), STATION) as ran:
        fail_in_mid_run(ran, how)
        record = ran.carry_out()
        kept = ran.attempt(AT_REST).recording
        second = ran.attempt(SECOND)
    assert said in ran.said[AT_REST]
    assert kept is not None
    assert kept.samples == 40
    assert second.outcome is (Outcome.PASSED if goes_on else Outcome.ERROR)
    assert record.verdict is Verdict.INCOMPLETE
    assert not ran.output.on


DIGITAL = """
model: {model}
output: {{kind: rate, axes: [x, y, z], mode: {mode}, full_scale: 400 deg/s, bandwidth: 33 Hz}}
supply: {{voltage: 5 V, current_limit: 500 mA, over_voltage: 5.5 V}}
cases:
"""
STILL = """
  {name}:
    procedure: static
    duration: 40 s
    interval: 8 ms
    {more}
    mountings: {{x: [0, 1, 0], y: [0, 0, 1], z: [1, 0, 0]}}
    parameters: {{smoothing: [1 s]}}
    limits: {{bias: {{min: -2 deg/s, max: 2 deg/s}}}}
"""


def digital(model: str = "STIM300", *, more: str = "allowed_loss: 1000 ppm", mode: str = "rate") -> str:
    cases = STILL.format(name="first", more=more) + STILL.format(name="second", more=more)
    return DIGITAL.format(model=model, mode=mode) + cases


def of_gyro(resource: str, *, driver: str = "stim300") -> str:
    """The station with another way to a gyro, and with a short patience."""
    found = f"driver: {driver}\n    resource: simulated"
    text = STATION.read_text("utf-8")
    assert found in text
    return text.replace(found, f"driver: {driver}\n    resource: {resource}\n    io_timeout: 0.2 s")


def test_a_digital_gyro_that_falls_silent_as_its_supply_fails_blames_the_supply(tmp_path: Path) -> None:
    with bench_run(tmp_path, digital(), of_gyro("simulated")) as ran:
        fail_in_mid_run(ran, switched_off)
        record = ran.carry_out()
        first, second = (ran.attempt(name) for name in (FIRST, SECOND))
    assert "the supply failed in the meantime: 5 V at up to 0.5 A" in ran.said[FIRST]
    assert "what came of it" in ran.said[FIRST]
    assert first.recording is not None
    assert first.recording.samples > 2000
    assert second.outcome is Outcome.PASSED, ran.said
    assert record.verdict is Verdict.INCOMPLETE
    assert not ran.output.on
