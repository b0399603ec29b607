"""Simulated units on the rate table, each with its own table, supply and meter errors: the truth, honestly."""

import math
import statistics
from pathlib import Path

import numpy as np
import pytest

from gyrotest.records.result import JudgedResult
from gyrotest.records.run import Attempt, RunRecord
from gyrotest.simulation.response import response_of
from gyrotest.specification.spec import load_spec
from gyrotest.units import conversion_factor

from .units import run_units

pytestmark = [pytest.mark.slow]
UNITS = [str(6000 + 41 * number) for number in range(30)]
RATES_DPS = np.array([sign * rate for rate in (10, 20, 40, 60, 80, 100) for sign in (1.0, -1.0)])
SPEC = """
model: MEMS50
output:
  kind: voltage
  scale_factor: 50 mV/(deg/s)
  zero_rate: 2.5 V
  full_scale: 100 deg/s
  bandwidth: 50 Hz
supply: {voltage: 5 V, current_limit: 100 mA, over_voltage: 5.5 V}
cases:
  scale_factor:
    procedure: scale_factor
    warm_up: 30 min
    duration: 30 s
    interval: 1 s
    mounting: [1, 0, 0]
    parameters: {rates: [10 deg/s, 20 deg/s, 40 deg/s, 60 deg/s, 80 deg/s, 100 deg/s]}
  reversal:
    procedure: bias_reversal
    duration: 60 s
    interval: 1 s
    mounting: [1, 0, 0]
    parameters: {scale_factor_from: scale_factor}
"""


@pytest.fixture(scope="module", params=["nominal", "inverted"])
def records(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> list[RunRecord]:
    folder: Path = tmp_path_factory.mktemp("table")
    (folder / "spec.yaml").write_text(SPEC, encoding="utf-8")
    spec = load_spec(folder / "spec.yaml")
    return list(run_units(folder, UNITS, spec=spec, scenario=request.param))


def measured(record: RunRecord, case: str, name: str, unit: str) -> tuple[JudgedResult, float]:
    (found,) = [one for one in record.results if (one.case, one.name) == (case, name)]
    return found, conversion_factor(found.unit, unit)


def attempt(record: RunRecord, case: str) -> Attempt:
    (found,) = [item.last for item in record.items if item.plan.case == case]
    assert found is not None
    return found


def z(record: RunRecord, case: str, name: str, unit: str, truth: float) -> float:
    found, factor = measured(record, case, name, unit)
    assert found.value is not None
    assert found.expanded_uncertainty is not None
    assert found.coverage_factor is not None
    assert not found.not_included
    standard = found.expanded_uncertainty * factor / found.coverage_factor
    return (found.value * factor - truth) / standard


def holds(record: RunRecord, name: str, truth: float) -> bool:
    found, factor = measured(record, "scale_factor", name, "")
    assert found.lower_95 is not None
    assert found.upper_95 is not None
    return found.lower_95 * factor <= truth <= found.upper_95 * factor


def line(record: RunRecord, rates_dps: np.ndarray) -> tuple[float, float]:
    """Slope and output at rate 0 of the least-squares line through the noise-free response, no bias."""
    response = response_of(attempt(record, "scale_factor").truth)
    slope, at_zero = np.polyfit(rates_dps, response.output(rates_dps) - response.zero_rate, 1)
    return float(slope), float(at_zero)


def true_nonlinearity(record: RunRecord) -> float:
    response = response_of(attempt(record, "scale_factor").truth)
    slope, at_zero = line(record, RATES_DPS)
    rest = response.output(RATES_DPS) - response.zero_rate - slope * RATES_DPS - at_zero
    return float(np.max(np.abs(rest)) / (abs(slope) * 100.0))


def true_asymmetry(record: RunRecord) -> float:
    forward, _ = line(record, RATES_DPS[RATES_DPS > 0])
    backward, _ = line(record, RATES_DPS[RATES_DPS < 0])
    return abs(forward - backward) / abs((forward + backward) / 2)


def assert_honest(found: list[float]) -> None:
    assert abs(statistics.fmean(found)) <= 0.55, found
    assert 0.65 <= statistics.stdev(found) <= 1.4, found


def test_scale_factor_is_within_its_stated_uncertainty(records: list[RunRecord]) -> None:
    assert_honest(
        [z(one, "scale_factor", "scale_factor", "V*s/deg", line(one, RATES_DPS)[0]) for one in records]
    )


def test_bias_from_the_line_is_within_its_stated_uncertainty(records: list[RunRecord]) -> None:
    def truth(record: RunRecord) -> float:
        slope, at_zero = line(record, RATES_DPS)
        return attempt(record, "scale_factor").truth["bias_dps"] + at_zero / slope

    assert_honest([z(one, "scale_factor", "bias", "deg/s", truth(one)) for one in records])


def test_bias_by_reversal_is_within_its_stated_uncertainty(records: list[RunRecord]) -> None:
    assert_honest(
        [
            z(one, "reversal", "bias", "deg/s", attempt(one, "reversal").truth["bias_dps"])
            for one in records
        ]
    )


def test_intervals_of_nonlinearity_hold_the_truth(records: list[RunRecord]) -> None:
    assert sum(holds(one, "nonlinearity", true_nonlinearity(one)) for one in records) >= 26


def test_intervals_of_asymmetry_hold_the_truth(records: list[RunRecord]) -> None:
    assert sum(holds(one, "asymmetry", true_asymmetry(one)) for one in records) >= 26


def test_the_sign_of_an_inverted_unit_is_said(records: list[RunRecord]) -> None:
    found, _ = measured(records[0], "scale_factor", "scale_factor", "V*s/deg")
    assert found.value is not None
    said = any("opposite sign" in text for text in attempt(records[0], "scale_factor").remarks)
    assert said == (found.value < 0.0)
    assert math.copysign(
        1.0, attempt(records[0], "scale_factor").truth["scale_factor"]
    ) == math.copysign(1.0, found.value)
