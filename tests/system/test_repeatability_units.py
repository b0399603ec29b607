"""Simulated units over power cycles and in the chamber: intervals hold the truth, results agree with it."""

import statistics
from pathlib import Path

import pytest

from gyrotest.records.result import JudgedResult
from gyrotest.records.run import RunRecord
from gyrotest.records.spec import SpecDocument
from gyrotest.specification.spec import load_spec
from gyrotest.units import conversion_factor

from .units import run_units

pytestmark = [pytest.mark.slow]
UNITS = [str(4000 + 37 * number) for number in range(30)]
TURN_ON_DPS = 0.15  # of the shipped station
SPEC = """
model: MEMS50
output:
  kind: voltage
  scale_factor: 50 mV/(deg/s)
  scale_factor_uncertainty: 0.5 %
  zero_rate: 2.5 V
  full_scale: 100 deg/s
  bandwidth: 50 Hz
supply: {voltage: 5 V, current_limit: 100 mA, over_voltage: 5.5 V}
cases:
  cycles:
    procedure: bias_repeatability
    warm_up: 10 min
    duration: 2 min
    interval: 1 s
    repeats: 5
    between_repeats: power_cycle
    mounting: [1, 0, 0]
    limits: {}
  chamber:
    procedure: bias_temperature_sensitivity
    duration: 4 min
    interval: 1 s
    mounting: [1, 0, 0]
    parameters: {temperatures: [-40 degC, 0 degC, 60 degC, 85 degC]}
    limits: {}
"""


@pytest.fixture(scope="module")
def records(tmp_path_factory: pytest.TempPathFactory) -> list[RunRecord]:
    folder = tmp_path_factory.mktemp("cycles")
    (folder / "spec.yaml").write_text(SPEC, encoding="utf-8")
    spec: SpecDocument = load_spec(folder / "spec.yaml")
    return list(run_units(Path(folder), UNITS, spec=spec))


def result(record: RunRecord, name: str) -> JudgedResult:
    (found,) = [one for one in record.results if one.name == name]
    return found


def interval(one: JudgedResult, unit: str) -> tuple[float, float]:
    factor = conversion_factor(one.unit, unit)
    assert one.lower_95 is not None
    assert one.upper_95 is not None
    return one.lower_95 * factor, one.upper_95 * factor


def true_slope_dph(record: RunRecord) -> float:
    (attempt,) = [item.last for item in record.items if item.plan.case == "chamber"]
    assert attempt is not None
    return attempt.truth["temperature_sensitivity_dps_per_c"] * 3600.0


def test_intervals_of_the_repeatability_hold_the_turn_on_spread(records: list[RunRecord]) -> None:
    ends = [interval(result(one, "bias_repeatability"), "deg/s") for one in records]
    assert sum(low <= TURN_ON_DPS <= high for low, high in ends) >= 26


def test_intervals_of_the_temperature_sensitivity_hold_the_truth(records: list[RunRecord]) -> None:
    held = 0
    for one in records:
        low, high = interval(result(one, "bias_temperature_sensitivity"), "deg/h/degC")
        held += low <= abs(true_slope_dph(one)) <= high
    assert held >= 26


def test_the_slope_over_temperature_is_within_its_uncertainty(records: list[RunRecord]) -> None:
    zs = []
    for record in records:
        one = result(record, "bias_temperature_slope")
        assert one.value is not None
        assert one.expanded_uncertainty is not None
        assert one.coverage_factor is not None
        standard = one.expanded_uncertainty / one.coverage_factor
        zs.append((one.value - true_slope_dph(record)) / standard)
    assert abs(statistics.mean(zs)) <= 0.55
    assert 0.65 <= statistics.stdev(zs) <= 1.4
