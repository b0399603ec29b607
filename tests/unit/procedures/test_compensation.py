"""Compensation: fitted values applied to other rates, residuals with intervals that hold, files that say how."""

import csv
import dataclasses
import io
import json
from typing import Any

import numpy as np
import pytest

from gyrotest.errors import InsufficientDataError
from gyrotest.procedures.compensation import Compensation, CompensationParameters
from gyrotest.records.figure import Role
from gyrotest.records.plan import Context, Plan, Reduction, Turning
from gyrotest.records.recording import Samples
from gyrotest.records.result import Result
from gyrotest.records.spec import Case, Limit
from gyrotest.records.station import Accuracy
from gyrotest.specification.spec import case_parameters
from gyrotest.units import Quantity
from tests.unit.procedures.bench import by_name
from tests.unit.procedures.turntable import (
    EARTH_DPS,
    Unit,
    counts_output,
    dwells_of,
    samples_of_turns,
    table_case,
    table_context,
    table_output,
)

PARAMETERS = CompensationParameters(scale_factor_from="fit")


def compensation_case(**changes: Any) -> Case:
    return table_case(**{"procedure": "compensation", **changes})


def the_plan(parameters: CompensationParameters = PARAMETERS) -> Plan:
    return Compensation().plan(compensation_case(), parameters)


def fitted(
    scale_factor: float, bias_dps: float, *, earth: str = "Earth's share 11.2 °/h subtracted"
) -> tuple[Result, ...]:
    return (
        Result(
            name="scale_factor",
            label="Scale factor",
            value=scale_factor * 1e3,
            unit="mV/(deg/s)",
            expanded_uncertainty=0.002,
            coverage_factor=2.0,
        ),
        Result(
            name="bias",
            label="Bias",
            value=bias_dps * 3600.0,
            unit="deg/h",
            expanded_uncertainty=9.0,
            coverage_factor=2.1,
            condition=f"at rate 0; {earth}",
        ),
    )


def the_context(earlier: tuple[Result, ...], **changes: Any) -> Context:
    plain: dict[str, Any] = {
        "case": compensation_case(),
        "case_name": "verification",
        "parameters": PARAMETERS,
        "earlier": {"fit": earlier},
    }
    return table_context(the_plan(), **{**plain, **changes})


def reduced(unit: Unit, *, seed: int = 1, **changes: Any) -> Reduction:
    earlier = changes.pop("earlier", fitted(unit.scale_factor, unit.bias_dps))
    return Compensation().reduce(
        samples_of_turns(unit, the_plan(), seed=seed), the_context(earlier, **changes)
    )


UNIT = Unit(scale_factor=0.0502, bias_dps=0.3)


def test_before_is_what_the_nominal_values_leave_and_after_nothing_but_errors() -> None:
    found = by_name(reduced(UNIT).results)
    # 0.4 % of 70 °/s and 0.3 °/s
    assert found["residual_max_before"].value == pytest.approx(0.004 * 70 + 0.3 * 1.004, abs=0.01)
    assert "at 70 °/s, where it is positive" in found["residual_max_before"].condition
    # In the unit of the value itself.
    assert not any("°/h rms" in one.condition for one in found.values())
    rates = np.array([0.0, *(sign * one for one in (15, 30, 50, 70) for sign in (1, -1)), 0.0])
    left = 0.004 * rates + 0.3 * 1.004
    assert found["residual_rms_before"].value == pytest.approx(np.sqrt(np.mean(left**2)), abs=0.01)
    after = found["residual_rms_after"]
    assert (after.value or 1.0) < 0.01
    assert after.lower_95 == 0.0
    assert found["residual_max_after"].lower_95 == 0.0
    assert "scale factor and bias of 'fit'" in after.condition


def test_an_inverted_gyro_leaves_as_little() -> None:
    unit = dataclasses.replace(UNIT, scale_factor=-0.0502)
    output = table_output(scale_factor=Quantity(-50.0, "mV/(deg/s)"))
    found = by_name(reduced(unit, output=output).results)
    assert (found["residual_rms_after"].value or 1.0) < 0.01
    assert (found["residual_rms_before"].value or 0.0) > 0.3


def test_a_bias_that_moved_since_the_fit_is_left() -> None:
    moved = fitted(UNIT.scale_factor, UNIT.bias_dps - 0.05)
    found = by_name(reduced(UNIT, earlier=moved).results)
    after = found["residual_rms_after"]
    assert after.value == pytest.approx(0.05, abs=0.01)
    assert (after.lower_95 or 0.0) > 0.03


def test_intervals_hold_the_true_residuals() -> None:
    """Thirty units, each with its own nonlinearity, table and meter, its coefficients known exactly."""
    plan = the_plan()
    rates = np.array([one.rate_dps or 0.0 for one in dwells_of(plan)])
    held = {"residual_rms_after": 0, "residual_max_after": 0}
    for number in range(30):
        random = np.random.default_rng(number)
        unit = Unit(
            scale_factor=0.05 * (1.0 + random.uniform(-0.005, 0.005)),
            bias_dps=random.normal(0.0, 0.2),
            cubic_ppm=random.uniform(0.0, 1500.0),
            table_gain=random.uniform(-20e-6, 20e-6),
            setting_dps={float(one): random.uniform(-5e-4, 5e-4) for one in rates if one},
            meter_gain=random.uniform(-35e-6, 35e-6),
            meter_offset=random.uniform(-5e-5, 5e-5),
        )
        # what compensation leaves at the table's nominal rates, read by a perfect meter
        true = unit.response(rates) / unit.scale_factor - rates
        size = {
            "residual_rms_after": np.sqrt(np.mean(true**2)),
            "residual_max_after": np.abs(true).max(),
        }
        found = by_name(reduced(unit, seed=number + 1).results)
        for name, truth in size.items():
            one = found[name]
            held[name] += (one.lower_95 or 0.0) <= truth <= (one.upper_95 or 0.0)
    assert min(held.values()) >= 26


def test_repeats_of_the_fit_are_taken_together() -> None:
    earlier = (
        *fitted(UNIT.scale_factor * 0.999, UNIT.bias_dps - 0.1),
        *fitted(UNIT.scale_factor * 1.001, UNIT.bias_dps + 0.1),
    )
    reduction = reduced(UNIT, earlier=earlier)
    assert (by_name(reduction.results)["residual_rms_after"].value or 1.0) < 0.01
    assert content(reduction)["fitted_from"] == {"case": "fit", "fits": 2}


def test_a_bias_that_holds_the_earths_rate_is_applied_as_it_is() -> None:
    earlier = fitted(UNIT.scale_factor, UNIT.bias_dps + EARTH_DPS, earth="Earth's rate not subtracted")
    for changes in ({}, {"site": None}):
        reduction = reduced(UNIT, earlier=earlier, **changes)
        assert (by_name(reduction.results)["residual_rms_after"].value or 1.0) < 0.01
        assert content(reduction)["earth_rate_in_bias"] is True
        assert "Earth" not in content(reduction)["equation_in_words"]


@pytest.mark.parametrize(
    ("earlier", "message"),
    [
        ({}, "judged before this case: none"),
        ({"other": ()}, "judged before this case: 'other'"),
        ({"fit": ()}, "case 'fit' has no scale factor"),
        ({"fit": fitted(0.05, float("nan"))}, "case 'fit' has no bias"),
    ],
)
def test_without_a_fit_before_it_there_is_nothing_to_apply(
    earlier: dict[str, tuple[Result, ...]], message: str
) -> None:
    samples = samples_of_turns(UNIT, the_plan())
    context = dataclasses.replace(the_context(()), earlier=earlier)
    with pytest.raises(InsufficientDataError, match=message):
        Compensation().reduce(samples, context)


def test_what_is_not_known_is_not_included() -> None:
    found = by_name(reduced(UNIT, table=None, accuracy=None).results)
    assert found["residual_rms_after"].not_included == (
        "accuracy of the rate table",
        "accuracy of the meter",
    )
    own = by_name(reduced(UNIT, table=Accuracy(of_reading=Quantity(20.0, "ppm"))).results)
    assert own["residual_max_after"].not_included == ("own error of each setting of the rate table",)


def content(reduction: Reduction) -> Any:
    (text,) = [one.text for one in reduction.exports if one.name == "coefficients.json"]
    return json.loads(text)


def test_the_json_holds_all_that_compensation_needs() -> None:
    found = content(reduced(UNIT, axis="z"))
    assert found["format"] == "gyrotest.coefficients/1"
    assert (found["case"], found["axis"], found["output_kind"]) == ("verification", "z", "voltage")
    assert found["equation"] == "rate = (output - zero_rate) / scale_factor - bias"
    assert found["equation_in_words"].endswith("The Earth's rate about the axis is part of it.")
    values = found["coefficients"]
    assert values["scale_factor"]["value"] == pytest.approx(0.0502)
    assert values["scale_factor"]["unit"] == "V/(deg/s)"
    assert values["scale_factor"]["expanded_uncertainty"] == pytest.approx(2e-6)
    assert values["bias"]["value"] == pytest.approx(0.3)
    assert values["bias"]["expanded_uncertainty"] == pytest.approx(9.0 / 3600.0)
    assert values["zero_rate"] == {"value": 2.5, "unit": "V"}
    assert found["verification"]["residual_rms_after"]["unit"] == "deg/s"


def test_whoever_follows_the_equation_of_the_file_gets_the_rate() -> None:
    found = content(reduced(UNIT))["coefficients"]
    volts = 2.5 + 0.0502 * (42.0 + 0.3)
    names = {"output": volts, **{name: one["value"] for name, one in found.items()}}
    equation = content(reduced(UNIT))["equation"].removeprefix("rate = ")
    assert eval(equation, {}, names) == pytest.approx(42.0)


def test_the_csv_says_the_same_as_the_json() -> None:
    reduction = reduced(UNIT, axis="z")
    (text,) = [one.text for one in reduction.exports if one.name == "coefficients.csv"]
    rows = {row["quantity"]: row for row in csv.DictReader(io.StringIO(text))}
    kept = content(reduction)
    for section in ("coefficients", "verification"):
        for name, entry in kept[section].items():
            assert float(rows[name]["value"]) == entry["value"]
            assert rows[name]["unit"] == entry["unit"]
            assert rows[name]["axis"] == "z"


def test_counts_are_compensated_in_their_unit() -> None:
    unit = Unit(scale_factor=131.5, bias_dps=0.4, zero=0.0)
    plan = the_plan()
    volts = samples_of_turns(unit, plan)
    sampling = dataclasses.replace(volts.sampling, unit="count", noise=None, range=None)
    samples: Samples = dataclasses.replace(volts, sampling=sampling)
    earlier = (
        dataclasses.replace(fitted(0.0, 0.4)[0], value=131.5, unit="count/(deg/s)"),
        fitted(0.0, 0.4)[1],
    )
    context = the_context(earlier, output=counts_output(), accuracy=None)
    reduction = Compensation().reduce(samples, context)
    found = by_name(reduction.results)
    assert (found["residual_rms_after"].value or 1.0) < 0.01
    assert found["residual_rms_after"].not_included == ()
    assert content(reduction)["coefficients"]["scale_factor"]["unit"] == "count/(deg/s)"


def test_the_figure_has_a_panel_before_and_one_after_with_bars_and_a_near_limit() -> None:
    limits = {"residual_max_after": Limit(max=Quantity(0.01, "deg/s"))}
    moved = fitted(UNIT.scale_factor, UNIT.bias_dps - 0.005)
    context_case = compensation_case(limits=limits)
    (figure,) = reduced(UNIT, earlier=moved, case=context_case).figures
    before, after = figure.panels
    assert before.y_label == "Before / (°/s)"
    assert after.y_label == "After / (°/h)"
    assert before.points[0].x == tuple(sorted(before.points[0].x))
    assert len(after.points[0].x) == len(after.points[0].u) == 10
    limit = [one.y[0] for one in after.curves if one.role is Role.LIMIT]
    assert limit == pytest.approx([36.0, -36.0])
    assert not [one for one in before.curves if one.role is Role.LIMIT]


def test_the_plan_rests_and_turns_each_rate_both_ways() -> None:
    steps = the_plan().steps
    rates = [one.stimulus.rate_dps for one in steps if isinstance(one.stimulus, Turning)]
    assert rates == [0.0, 15.0, -15.0, 30.0, -30.0, 50.0, -50.0, 70.0, -70.0, 0.0]
    given = dataclasses.replace(PARAMETERS, rates=(Quantity(-20.0, "deg/s"), Quantity(33.0, "deg/s")))
    turned = [getattr(one.stimulus, "rate_dps", None) for one in the_plan(given).steps]
    assert turned == [0.0, -20.0, 33.0, 0.0]


@pytest.mark.parametrize(
    ("parameters", "key", "message"),
    [
        ({"scale_factor_from": " "}, "parameters.scale_factor_from", "is empty"),
        ({"scale_factor_from": "fit", "rates": []}, "parameters.rates", "is empty"),
        ({"scale_factor_from": "fit", "rates": ["0 deg/s"]}, "parameters.rates[0]", "no turn"),
    ],
)
def test_a_case_that_cannot_verify_is_refused(
    parameters: dict[str, Any], key: str, message: str
) -> None:
    case = compensation_case(parameters=parameters)
    found = dict(Compensation().complaints(case, case_parameters(case, Compensation()), table_output()))
    assert message in found[key]


def test_dropped_samples_are_told() -> None:
    samples = samples_of_turns(UNIT, the_plan())
    values = samples.values.copy()
    values[150] += 1.0
    reduction = Compensation().reduce(
        dataclasses.replace(samples, values=values), the_context(fitted(0.0502, 0.3))
    )
    assert reduction.remarks == ("Outliers: 1 of 1000 samples dropped, in 1 of 10 steps.",)
