"""Bias by reversal: the value, and what a reversal does not tell from a bias."""

import dataclasses
import math
from typing import Any

import pytest

from gyrotest.errors import InsufficientDataError
from gyrotest.procedures.bias_reversal import BiasReversal, BiasReversalParameters
from gyrotest.records.result import Result
from gyrotest.units import Quantity
from tests.unit.procedures.bench import by_name, voltage_output
from tests.unit.procedures.turntable import (
    Unit,
    plan_of,
    samples_of_turns,
    table_case,
    table_context,
)

CASE = table_case(procedure="bias_reversal")
SILENT = Unit(noise={"angle_random_walk": 1e-6})


def bias(unit: Unit, *, seed: int = 1, **changes: Any) -> Result:
    parameters = BiasReversalParameters(**changes.pop("parameters", {}))
    plan = plan_of(CASE, parameters, BiasReversal())
    context = table_context(plan, case=CASE, parameters=parameters, **changes)
    found = BiasReversal().reduce(samples_of_turns(unit, plan, seed=seed), context)
    return by_name(found.results)["bias"]


def earlier(**slopes: float) -> dict[str, tuple[Result, ...]]:
    slope = Result(
        name="scale_factor",
        label="",
        value=slopes.get("scale_factor", 50.1),
        unit="mV/(deg/s)",
        expanded_uncertainty=0.002,
        coverage_factor=2.0,
    )
    asymmetry = Result(
        name="asymmetry",
        label="",
        value=80.0,
        unit="ppm",
        lower_95=60.0,
        upper_95=slopes.get("asymmetry", 100.0),
    )
    return {"line": (slope, asymmetry)}


def lines(one: Result) -> dict[str, float]:
    return {line.source: line.standard_uncertainty for line in one.budget}


def test_the_bias_is_half_the_sum_over_the_scale_factor_less_the_earths_share() -> None:
    found = bias(SILENT)
    assert found.value == pytest.approx(0.3, abs=1e-5)
    assert found.condition.startswith("±40 °/s; nominal scale factor; Earth's share 11.2 °/h")


def test_an_asymmetry_leaves_half_of_it_times_the_rate() -> None:
    uneven = dataclasses.replace(SILENT, asymmetry_ppm=100.0)
    found = bias(uneven, parameters={"asymmetry": Quantity(100.0, "ppm")})
    assert (found.value or 0.0) - 0.3 == pytest.approx(0.002, rel=1e-2)  # 7.2 °/h
    assert lines(found)["scale-factor asymmetry"] == pytest.approx(0.002 / math.sqrt(3.0))
    assert abs((found.value or 0.0) - 0.3) < (found.expanded_uncertainty or 0.0)


def test_unequal_rates_leave_half_their_difference() -> None:
    unequal = dataclasses.replace(SILENT, setting_dps={40.0: 0.0005, -40.0: 0.0003})
    assert (bias(unequal).value or 0.0) - 0.3 == pytest.approx(0.0004, rel=1e-2)
    found = lines(bias(SILENT))["table, own errors of the two settings"]
    assert found == pytest.approx(0.0005 / math.sqrt(2.0) / math.sqrt(3.0))


def test_scale_factor_and_asymmetry_may_come_from_an_earlier_case() -> None:
    unit = dataclasses.replace(SILENT, scale_factor=0.0501)
    found = bias(unit, parameters={"scale_factor_from": "line"}, earlier=earlier())
    assert found.value == pytest.approx(0.3, abs=1e-5)
    assert "scale factor from case 'line'" in found.condition
    standard = math.hypot(80e-6, 20e-6 / 1.96)  # its sign is not used: all of it counts
    assert lines(found)["scale-factor asymmetry"] == pytest.approx(standard * 20.0)
    assert lines(found)["scale factor from case 'line'"] == pytest.approx(
        0.001 / 50.1 * (0.3 + 11.2 / 3600.0), rel=1e-2
    )
    assert found.not_included == ()


def test_an_earlier_case_without_scale_factor_is_an_error() -> None:
    with pytest.raises(InsufficientDataError, match="case 'line' has no scale factor"):
        bias(SILENT, parameters={"scale_factor_from": "line"})


def test_what_is_not_known_is_not_included() -> None:
    assert bias(SILENT).not_included == ("scale-factor asymmetry",)
    output = voltage_output(scale_factor_uncertainty=None)
    found = bias(SILENT, output=output, table=None, accuracy=None)
    assert found.not_included == (
        "own error of each setting of the rate table",
        "scale-factor asymmetry",
        "uncertainty of the scale factor",
        "accuracy of the meter",
    )


def test_the_truth_is_recovered_over_many_units() -> None:
    scores = []
    for seed in range(40):
        found = bias(Unit(), seed=seed, parameters={"asymmetry": Quantity(0.0, "ppm")})
        standard = (found.expanded_uncertainty or 0.0) / (found.coverage_factor or 1.0)
        scores.append(((found.value or 0.0) - 0.3) / standard)
    mean = sum(scores) / len(scores)
    assert abs(mean) < 0.5
    assert 0.5 < math.sqrt(sum((one - mean) ** 2 for one in scores) / 39.0) < 1.3


def test_the_plan_turns_forward_and_backward_and_faults_are_told() -> None:
    parameters = BiasReversalParameters(rate=Quantity(20.0, "deg/s"))
    plan = BiasReversal().plan(CASE, parameters)
    assert [(one.name, getattr(one.stimulus, "rate_dps", None)) for one in plan.steps] == [
        ("forward", 20.0),
        ("backward", -20.0),
    ]
    faulty = BiasReversalParameters(
        rate=Quantity(-20.0, "deg/s"), asymmetry=Quantity(1.0, "ppm"), scale_factor_from="line"
    )
    found = dict(BiasReversal().complaints(CASE, faulty, voltage_output()))
    assert list(found) == ["parameters.rate", "parameters.asymmetry"]
