"""What goes wrong with table, supply, chamber or a digital gyro: said, kept, INCOMPLETE, and the bench safe."""

import contextlib
import re
import socket
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import pytest

from gyrotest.errors import SpecError
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
                    for connection in tuple(one._connections):
                        with contextlib.suppress(OSError):
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


OF_GYROS = {
    "unplugged": ("given up after 3 tries", "connection lost"),
    "lost-frames": ("7 samples are lost, of 5000 1000 ppm are allowed (allowed_loss)", ""),
    "lost-counter-period": ("48 samples are lost, of 5000 1000 ppm are allowed (allowed_loss)", ""),
    "bad-crc": ("samples are lost, of 5000 1000 ppm are allowed (allowed_loss)", ""),
    "overload-status": ("overload at sample N (range 400 deg/s)", ""),
    "channel-error": ("reports a channel error or a failed self-check at sample N", ""),
}


@pytest.mark.parametrize(
    ("scenario", "way"),
    [
        *((one, "simulated") for one in OF_GYROS),
        pytest.param("unplugged", "simulated:pty", marks=needs_pty),
        pytest.param("bad-crc", "simulated:pty", marks=needs_pty),
    ],
)
def test_what_befalls_a_digital_gyro_in_mid_run_is_said_and_the_record_kept(
    tmp_path: Path, scenario: str, way: str
) -> None:
    said, event = OF_GYROS[scenario]
    spec = digital(more="allowed_loss: 1000 ppm" if scenario != "bad-crc" else "allowed_loss: 10 ppm")
    said = said if scenario != "bad-crc" else said.replace("1000 ppm", "10 ppm")
    with bench_run(tmp_path, spec, of_gyro(way), scenario=scenario) as ran:
        record = ran.carry_out()
        first = ran.attempt(FIRST)
    assert re.search(re.escape(said).replace("N", r"(19\d\d|2000)"), ran.said[FIRST]), ran.said[FIRST]
    assert any(event in one for one in first.events) or not event
    assert first.outcome is ran.attempt(SECOND).outcome is Outcome.ERROR
    assert first.recording is not None
    assert not first.recording.complete
    assert first.recording.samples > 1400
    assert [one.samples for one in first.recording.dwells] == [5000]
    assert record.verdict is Verdict.INCOMPLETE
    assert max(ran.took_s.values()) < 10.0
    assert not ran.output.on


REFUSED_AT_ONCE = {
    "wrong-baud-rate": "is baud_rate that of the unit?",
    "other-device": "serial number is 1235, the run is for 1234: connect that unit",
    "other-configuration": "its mode is incremental_angle, the station says rate",
}


@pytest.mark.parametrize("model", ["STIM210", "STIM300"])
@pytest.mark.parametrize("scenario", REFUSED_AT_ONCE)
def test_another_unit_setting_or_baud_rate_is_refused_before_anything_is_acquired(
    tmp_path: Path, scenario: str, model: str
) -> None:
    station = of_gyro("simulated", driver=model.lower())
    with bench_run(tmp_path, digital(model), station, scenario=scenario) as ran:
        begun_s = ran.bench.clock.now_s()
        record = ran.carry_out()
        assert ran.bench.clock.now_s() - begun_s < 15.0
    for item in (FIRST, SECOND):
        assert REFUSED_AT_ONCE[scenario] in ran.said[item]
        assert ran.attempt(item).recording is None
    assert record.verdict is Verdict.INCOMPLETE
    assert max(ran.took_s.values()) < 10.0
    assert not ran.output.on


def test_losses_within_the_allowance_are_counted_and_judged_around(tmp_path: Path) -> None:
    spec = digital(more="allowed_loss: 5 %\n    gaps: longest_stretch")
    with bench_run(tmp_path, spec, STATION, scenario="lost-counter-period") as ran:
        record = ran.carry_out()
        first = ran.attempt(FIRST)
    assert record.verdict is Verdict.PASS
    assert first.recording is not None
    assert first.recording.samples == 5000 - 48
    assert any("48 samples lost in 1 gap" in one for one in first.remarks)


BEYOND = (
    DIGITAL.format(model="STIM300", mode="rate")
    + """
  first:
    procedure: scale_factor
    duration: 4 s
    interval: 8 ms
    axes: [z]
    mountings: {z: [1, 0, 0]}
    parameters: {rates: [100 deg/s, 550 deg/s], settle: 1 s}
    limits: {scale_factor_error: {min: -1 %, max: 1 %}}
"""
)


def test_a_rate_beyond_the_range_is_refused_by_its_step(tmp_path: Path) -> None:
    fast = STATION.read_text("utf-8").replace("max_rate: 500", "max_rate: 900")
    with bench_run(tmp_path / "digital", BEYOND, fast) as ran:
        record = ran.carry_out()
        is_safe(ran)
    assert "overload at sample 0 (range 400 deg/s)" in ran.said[FIRST]
    assert "(step 'turn 3' at 550 °/s)" in ran.said[FIRST]
    assert record.verdict is Verdict.INCOMPLETE
    wide = VOLTAGE + turns("first", "[40 deg/s, 80 deg/s, 150 deg/s]")
    with bench_run(tmp_path / "voltage", wide, STATION) as ran:
        record = ran.carry_out()
    assert "step 'turn 5' at 150 °/s: 20 of 20 samples read" in ran.said[FIRST]
    assert "the output stands at its limit" in ran.said[FIRST]
    assert record.verdict is Verdict.INCOMPLETE


def test_a_chamber_that_does_not_reach_its_temperature_is_said(tmp_path: Path) -> None:
    spec = (
        VOLTAGE
        + """
  first:
    procedure: bias_temperature_sensitivity
    duration: 20 s
    interval: 1 s
    mounting: [1, 0, 0]
    parameters: {temperatures: [23 degC, 40 degC], soak: 1 min}
    limits: {bias_temperature_sensitivity: {max: 60 deg/h/degC}}
"""
    )
    with bench_run(tmp_path, spec, STATION, scenario="chamber-does-not-reach") as ran:
        record = ran.carry_out()
    assert "40 °C is asked for, found 23.00 °C after 20 min" in ran.said[FIRST]
    assert record.verdict is Verdict.INCOMPLETE
    kept = ran.attempt(FIRST).recording
    assert kept is not None
    assert (kept.samples, len(kept.dwells)) == (20, 1)


ONE_SIGN = turns("first", "[20 deg/s, 40 deg/s]").replace(
    "settle: 1 s", "settle: 1 s, directions: as_given"
)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        (
            turns("first", "[20 deg/s]"),
            r"spec\.yaml:\d+: cases\.first\.parameters\.rates: 1 rate is too few",
        ),
        (
            ONE_SIGN.replace("nonlinearity", "asymmetry"),
            r"spec\.yaml:\d+: cases\.first\.limits\.asymmetry: needs two rates of each sign",
        ),
    ],
)
def test_rates_that_are_too_few_are_refused_with_their_line(
    tmp_path: Path, text: str, said: str
) -> None:
    with pytest.raises(SpecError, match=said), bench_run(tmp_path, VOLTAGE + text, STATION):
        pass


def test_rates_of_one_sign_leave_the_asymmetry_out(tmp_path: Path) -> None:
    with bench_run(tmp_path, VOLTAGE + ONE_SIGN, STATION) as ran:
        record = ran.carry_out()
        found = {one.name: one.value for one in ran.attempt(FIRST).results}
    assert record.verdict is Verdict.PASS
    assert found.get("asymmetry") is None
    assert found["scale_factor"] is not None


def test_a_protection_beyond_the_supply_says_what_was_asked_of_it(tmp_path: Path) -> None:
    spec = VOLTAGE.replace("over_voltage: 5.5 V", "over_voltage: 50 V") + REST
    with bench_run(tmp_path, spec, STATION) as ran:
        ran.carry_out()
    assert "Data out of range" in ran.said[AT_REST]
    assert "5 V, at most 0.1 A, protection at 50 V" in ran.said[AT_REST]
    assert not ran.output.on


def test_a_digital_gyro_that_starts_anew_in_mid_run_is_refused(tmp_path: Path) -> None:
    with bench_run(tmp_path, digital(), of_gyro("simulated")) as ran:
        off_s: list[float] = []

        def glitch(output: SimulatedOutput, now_s: float) -> None:
            output.switch(now_s, on=False)
            off_s.append(now_s)

        fail_in_mid_run(ran, glitch)
        once(
            ran,
            lambda now_s: bool(off_s) and now_s > off_s[0] + 1.0,
            lambda now_s: ran.output.switch(now_s, on=True),
        )
        record = ran.carry_out()
    assert "the unit starts up anew at sample" in ran.said[FIRST], ran.said
    assert record.verdict is Verdict.INCOMPLETE
