"""Simulated units on the level shaft, each with its own azimuth, tilt and encoder errors: the truth, honestly."""

from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from gyrotest.records.run import Attempt, RunRecord
from gyrotest.specification.spec import load_spec
from gyrotest.units import conversion_factor

from .units import run_units

pytestmark = [pytest.mark.slow]
UNITS = [str(7000 + 37 * number) for number in range(30)]
SPEC = """
model: MEMS50
output:
  kind: voltage
  scale_factor: 50 mV/(deg/s)
  scale_factor_uncertainty: 0.5 %
  zero_rate: 2.5 V
  full_scale: 100 deg/s
  bandwidth: 50 Hz
cases:
  turning:
    procedure: g_sensitivity
    warm_up: 30 min
    duration: 12 s
    interval: 50 ms
    repeats: 2
    parameters: {rate: 15 deg/s, run_up: 12 deg, turns: 3}
"""


@pytest.fixture(scope="module")
def records(tmp_path_factory: pytest.TempPathFactory) -> list[RunRecord]:
    """Half of them in the slot of the x gyro, half in that of the z gyro."""
    folder: Path = tmp_path_factory.mktemp("shaft")
    (folder / "spec.yaml").write_text(SPEC, encoding="utf-8")
    spec = load_spec(folder / "spec.yaml")
    return [
        record
        for place in (0, 1)
        for record in run_units(folder, UNITS[place::2], spec=spec, place=place)
    ]


def attempts(record: RunRecord) -> Iterator[Attempt]:
    """The acquisitions of both mountings."""
    for item in record.items:
        if item.plan.repeat is not None:
            assert item.last is not None, item.plan.name
            yield item.last


def z(record: RunRecord, name: str, unit: str, truth: float) -> float:
    (found,) = [one for one in record.results if one.name == name]
    assert found.value is not None
    assert found.expanded_uncertainty is not None
    assert found.coverage_factor is not None
    assert not found.not_included
    factor = conversion_factor(found.unit, unit)
    return (found.value * factor - truth) / (found.expanded_uncertainty * factor / found.coverage_factor)


@pytest.mark.parametrize("axis", ["x", "y", "z"])
def test_every_coefficient_is_recovered_within_its_uncertainty(
    records: list[RunRecord], axis: str
) -> None:
    scores = []
    for record in records:
        first, second = attempts(record)
        name = f"g_sensitivity_{axis}"
        truth = first.truth[f"{name}_dps_per_g"]
        assert truth == second.truth[f"{name}_dps_per_g"]
        scores.append(z(record, name, "deg/s/g", truth))
    assert abs(np.mean(scores)) <= 0.55
    assert 0.65 <= np.std(scores, ddof=1) <= 1.4


def test_the_bias_of_each_mounting_is_recovered(records: list[RunRecord]) -> None:
    """Less the drift by the shaft's tilt, which is in the uncertainty."""
    scores = []
    for record in records:
        for attempt in attempts(record):
            (bias,) = [one for one in attempt.results if one.name == "bias"]
            assert bias.value is not None
            assert bias.expanded_uncertainty is not None
            assert bias.coverage_factor is not None
            standard = bias.expanded_uncertainty / bias.coverage_factor
            scores.append((bias.value - attempt.truth["bias_dps"]) / standard)
    assert abs(np.mean(scores)) <= 0.55
    assert np.std(scores, ddof=1) <= 1.4


def test_both_mountings_agree_and_the_lean_of_the_sensitive_axis_is_found(
    records: list[RunRecord],
) -> None:
    agreements, leans = [], []
    for record in records:
        agreements.append(z(record, "agreement_difference", "deg/s/g", 0.0))
        for attempt in attempts(record):
            (found,) = [one for one in attempt.results if one.name == "mounted_cross_axis"]
            assert found.value is not None
            assert found.expanded_uncertainty is not None
            assert found.coverage_factor is not None
            sign = -1.0 if "−" in found.condition.split(":")[1] else 1.0
            truth = 100.0 * sign * attempt.truth["table_share"]
            leans.append((found.value - truth) / (found.expanded_uncertainty / found.coverage_factor))
    for scores in (agreements, leans):
        assert abs(np.mean(scores)) <= 0.55
        assert 0.65 <= np.std(scores, ddof=1) <= 1.4


def test_each_unit_lies_on_a_shaft_with_errors_of_its_own(records: list[RunRecord]) -> None:
    truths = [next(attempts(record)).truth for record in records]
    for name in ("shaft_azimuth_error_deg", "shaft_index_error_deg", "misalignment_deg"):
        assert len({one[name] for one in truths}) == len(records)
