"""What goes wrong with table, supply, chamber or a digital gyro: said, kept, INCOMPLETE, and the bench safe."""

import re
from pathlib import Path

import pytest

from gyrotest.records.result import Verdict
from gyrotest.records.run import Outcome, PlannedItem
from gyrotest.simulation.server import has_pty
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
