"""Scale factor by steps on a table: values, budgets, intervals, what is said and drawn."""

import dataclasses
import math
import re
from typing import Any

import numpy as np
import pytest

from gyrotest.conformity import judge
from gyrotest.errors import InsufficientDataError
from gyrotest.procedures.scale_factor import ScaleFactor, ScaleFactorParameters
from gyrotest.records.figure import Role
from gyrotest.records.plan import Reduction
from gyrotest.records.recording import Sampling
from gyrotest.records.result import Result, Verdict
from gyrotest.records.spec import Limit, Output, OutputKind, Over
from gyrotest.records.station import Accuracy
from gyrotest.units import Quantity
from tests.unit.procedures.bench import by_name
from tests.unit.procedures.turntable import (
    Unit,
    counts_output,
    plan_of,
    samples_of_turns,
    table_case,
    table_context,
    table_output,
)

SILENT = Unit(noise={"angle_random_walk": 1e-6})
PLAN = plan_of(table_case())


def reduced(unit: Unit, **changes: Any) -> Reduction:
    parameters = changes.get("parameters") or ScaleFactorParameters()
    plan = plan_of(changes.get("case") or table_case(), parameters)
    sampling = changes.pop("sampling", None)
    samples = samples_of_turns(unit, plan, sampling=sampling)
    return ScaleFactor().reduce(samples, table_context(plan, **changes))


def results(unit: Unit, **changes: Any) -> dict[str, Result]:
    return by_name(reduced(unit, **changes).results)


def budget(one: Result) -> dict[str, float]:
    return {line.source: line.standard_uncertainty for line in one.budget}


def test_every_measurand_of_one_acquisition_has_a_result_in_its_unit() -> None:
    context, found = table_context(PLAN), results(Unit())
    measured = ScaleFactor().measurands(context.case, context.parameters, context.output)
    assert [one.name for one in measured] == list(found)
    for one in measured:
        assert (found[one.name].unit, found[one.name].label) == (one.unit, one.label)


def test_a_straight_gyro_is_found_as_it_is() -> None:
    found = results(dataclasses.replace(SILENT, scale_factor=0.0501))
    assert found["scale_factor"].value == pytest.approx(50.1, rel=1e-6)
    assert found["scale_factor_error"].value == pytest.approx(0.2, rel=1e-3)
    assert found["scale_factor_error"].condition == "nominal 50 mV/(°/s)"
    assert found["bias"].value == pytest.approx(0.3, abs=1e-5)
    assert "Earth's share 11.2 °/h subtracted" in found["bias"].condition
    assert found["nonlinearity"].value == pytest.approx(0.0, abs=0.2)
    assert found["scale_factor"].condition == "10 steps, −80 °/s … 80 °/s"


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_nonlinearity_and_asymmetry_are_positive_whatever_the_sign(sign: float) -> None:
    unit = dataclasses.replace(
        SILENT, scale_factor=sign * 0.05, cubic_ppm=1000.0, asymmetry_ppm=sign * 300.0
    )
    found = results(unit, output=table_output(scale_factor=Quantity(sign * 50.0, "mV/(deg/s)")))
    rates = np.array(ScaleFactorParameters().signed_rates_dps)
    response = unit.response(rates)
    residual = response - np.polyval(np.polyfit(rates, response, 1), rates)
    largest = np.abs(residual).max() / (0.05 * 100.0) * 1e6
    assert found["nonlinearity"].value == pytest.approx(largest, rel=0.01)
    assert found["nonlinearity_of_tested"].value == pytest.approx(largest / 0.8, rel=0.01)
    assert found["nonlinearity"].condition.startswith(
        "of full scale 100 °/s, tested to 80 °/s; largest at"
    )
    assert found["asymmetry"].value == pytest.approx(300.0, rel=0.02)
    assert found["asymmetry"].condition.startswith("the forward" if sign > 0 else "the backward")
    assert found["scale_factor"].value == pytest.approx(sign * 50.0, rel=1e-3)


def test_the_budget_of_the_scale_factor_has_the_table_and_the_meter_after_the_fit() -> None:
    one = results(Unit())["scale_factor"]
    lines = budget(one)
    assert lines["table, 20 ppm of the rate"] == pytest.approx(20e-6 * 50.0 / math.sqrt(3), rel=1e-3)
    assert lines["meter, 35 ppm of reading"] == pytest.approx(35e-6 * 50.0 / math.sqrt(3), rel=1e-3)
    rates = np.array(ScaleFactorParameters().signed_rates_dps)
    own = 50.0 * 0.0005 / math.sqrt(3) / math.sqrt(float(rates @ rates))
    assert lines["table, own error of each setting"] == pytest.approx(own, rel=1e-3)
    combined = math.sqrt(sum(one**2 for one in lines.values()))
    assert one.expanded_uncertainty == pytest.approx((one.coverage_factor or 0.0) * combined)
    assert one.not_included == ()


def test_the_meters_gain_leaves_a_bias_alone_but_for_the_nominal_output_at_rest() -> None:
    lines = budget(results(Unit())["bias"])
    assert lines["meter, 35 ppm of reading"] == pytest.approx(
        35e-6 * 2.5 / 0.05 / math.sqrt(3), rel=1e-3
    )
    assert lines["meter, 5 ppm of range"] == pytest.approx(5e-6 * 10.0 / 0.05 / math.sqrt(3), rel=1e-3)
    output = table_output(zero_rate=Quantity(0.0, "V"))
    centred = dataclasses.replace(Unit(), zero=0.0)
    assert "meter, 35 ppm of reading" not in budget(results(centred, output=output)["bias"])


def test_what_is_not_known_is_not_included() -> None:
    found = results(Unit(), table=None, accuracy=None)
    assert found["scale_factor"].not_included == ("accuracy of the rate table", "accuracy of the meter")
    assert found["nonlinearity"].not_included == ("accuracy of the rate table",)
    gain = Accuracy(of_reading=Quantity(20.0, "ppm"))
    own = results(Unit(), table=gain, since_power_on_s=None)
    assert own["asymmetry"].not_included == ("own error of each setting of the rate table",)
    assert own["bias"].not_included[-1] == "drift before the record (time of power-on not known)"


def test_the_intervals_of_nonlinearity_and_asymmetry_begin_at_zero_where_noise_explains_them() -> None:
    for name in ("nonlinearity", "asymmetry"):
        one = results(Unit())[name]
        assert one.lower_95 == 0.0
        assert (one.value or 0.0) < (one.upper_95 or 0.0)
        assert one.expanded_uncertainty is None


def test_the_output_at_rest_is_told_and_its_drift_taken_out() -> None:
    ramp = samples_of_turns(SILENT, PLAN)
    times = np.concatenate([one.began_s + 0.1 * np.arange(100) for one in table_context(PLAN).dwells])
    values = ramp.values + 0.05 * 1e-4 * times[:, None]
    found = by_name(
        ScaleFactor().reduce(dataclasses.replace(ramp, values=values), table_context(PLAN)).results
    )
    assert found["rest_difference"].value == pytest.approx(143.0 * 1e-4 * 3600.0, rel=1e-2)
    assert found["rest_difference"].condition == "143 s apart"
    assert found["scale_factor"].value == pytest.approx(50.0, rel=1e-6)


def test_a_digital_gyro_has_a_ratio_and_one_in_counts_has_counts() -> None:
    rate = Output(kind=OutputKind.RATE, full_scale=Quantity(100.0, "deg/s"))
    unit = dataclasses.replace(SILENT, scale_factor=0.9901, zero=0.0)
    sampling = Sampling(interval_s=0.1, aperture_s=0.1, unit="deg/s")
    found = results(unit, output=rate, accuracy=None, sampling=sampling)
    assert (found["scale_factor"].value, found["scale_factor"].unit) == (pytest.approx(0.9901), "")
    assert found["scale_factor_error"].value == pytest.approx(-0.99, rel=1e-3)
    assert found["scale_factor_error"].condition == "nominal 1"
    assert found["scale_factor"].not_included == ()
    counting = dataclasses.replace(
        SILENT, scale_factor=-131.0, zero=0.0, noise={"angle_random_walk": 0.01}
    )
    sampling = dataclasses.replace(sampling, unit="count")
    output = dataclasses.replace(counts_output(), scale_factor=Quantity(-131.0, "count/(deg/s)"))
    counts = results(counting, output=output, accuracy=None, sampling=sampling)["scale_factor"]
    assert (counts.value, counts.unit) == (pytest.approx(-131.0, rel=1e-4), "count/(deg/s)")


def test_an_inverted_gyro_is_reported_and_not_refused() -> None:
    found = reduced(dataclasses.replace(Unit(), scale_factor=-0.05))
    assert any("opposite sign" in one for one in found.remarks)
    assert by_name(found.results)["scale_factor_error"].value == pytest.approx(-200.0, rel=1e-3)


def test_without_full_scale_only_the_tested_range_is_judged() -> None:
    output = dataclasses.replace(table_output(), full_scale=None)
    found = results(Unit(), output=output)
    assert found["nonlinearity"].value is None
    assert found["nonlinearity"].condition == "'output.full_scale' is not given"
    assert found["nonlinearity_of_tested"].value is not None


def test_rates_of_one_sign_have_no_asymmetry() -> None:
    parameters = ScaleFactorParameters(rates=(Quantity(-10.0, "deg/s"), Quantity(-40.0, "deg/s")))
    found = reduced(Unit(), parameters=parameters)
    named = by_name(found.results)
    assert named["asymmetry"].value is None
    assert named["scale_factor_forward"].value is None
    assert named["scale_factor_backward"].value == pytest.approx(50.0, rel=1e-3)
    assert "Deviation: 0 rates forward and 2 backward" in found.remarks[0]
    measured = ScaleFactor().measurands(table_case(), parameters, table_output())
    asymmetry = next(one for one in measured if one.name == "asymmetry")
    limit = Limit(max=Quantity(100.0, "ppm"))
    judged = judge(asymmetry, named["asymmetry"], limit, case="c", repeat=1)
    assert judged.verdict is Verdict.INCOMPLETE


def test_an_output_that_does_not_follow_the_table_is_refused() -> None:
    with pytest.raises(InsufficientDataError, match="is this the axis"):
        reduced(dataclasses.replace(Unit(), scale_factor=0.0005))


def test_dropped_samples_and_a_read_back_close_to_the_tolerance_are_said() -> None:
    samples = samples_of_turns(Unit(), PLAN)
    values = samples.values.copy()
    values[150] = 9.0
    context = table_context(PLAN)
    off = tuple(
        dataclasses.replace(one, measured_rate_dps=20.04) if one.rate_dps == 20.0 else one
        for one in context.dwells
    )
    context = dataclasses.replace(context, dwells=off)
    remarks = ScaleFactor().reduce(dataclasses.replace(samples, values=values), context).remarks
    assert remarks[0] == "Outliers: 1 of 1200 samples dropped, in 1 of 12 steps."
    assert "read-back is off by 0.04 °/s at 20 °/s" in remarks[1]


def test_the_figure_has_both_ways_apart_the_limits_and_a_table_of_steps() -> None:
    case = table_case(limits={"nonlinearity": Limit(max=Quantity(0.1, "%"))})
    (figure,) = reduced(Unit(), case=case).figures
    response, residuals = figure.panels
    assert [one.label for one in response.points] == ["forward", "backward"]
    assert all(len(one.u) == len(one.x) == 5 for one in residuals.points)
    limits = [one.y[0] for one in residuals.curves if one.role is Role.LIMIT]
    assert limits == pytest.approx((1000.0, -1000.0))
    assert figure.table is not None
    assert len(figure.table.rows) == 12
    assert {len(row) for row in figure.table.rows} == {len(figure.table.columns)}
    assert [cell.text for cell in figure.table.rows[2]][:3] == ["turn 2", "−10", "−10.0000"]
    assert figure.table.note == (
        "residuals in ppm of full scale, 100 °/s; mean output less the nominal one at rest, 2.5 V"
    )
    texts = [cell.text for row in figure.table.rows for cell in row]
    assert not [text for text in texts if re.search(r"[0-9]e[+-]?[0-9]", text)]


def slopes(*values: float) -> tuple[tuple[Result, ...], ...]:
    return tuple(
        (Result(name="scale_factor", label="", value=one, unit="mV/(deg/s)"),) for one in values
    )


def test_repeatability_is_the_spread_over_the_mean() -> None:
    context = table_context(PLAN, case=table_case(repeats=3))
    (found,) = ScaleFactor().reduce_repeats(slopes(-50.0, -50.01, -49.99), context).results
    assert (found.value, found.unit) == (pytest.approx(200.0), "ppm")
    assert (found.lower_95, found.upper_95) == (
        pytest.approx(200.0 * 0.5207, rel=1e-3),
        pytest.approx(200.0 * 6.285, rel=1e-3),
    )
    assert found.condition == "3 repeats, no power cycle between"
    measured = ScaleFactor().measurands(context.case, context.parameters, context.output)
    assert (measured[-1].name, measured[-1].over) == (found.name, Over.REPEATS)


@pytest.mark.parametrize(
    ("repeats", "message"),
    [(slopes(50.0), "1 of 1"), (slopes(50.0, float("nan")), "1 of 2"), (slopes(50.0, 50.0), "same")],
)
def test_a_repeatability_needs_repeats_that_differ(
    repeats: tuple[tuple[Result, ...], ...], message: str
) -> None:
    with pytest.raises(InsufficientDataError, match=message):
        ScaleFactor().reduce_repeats(repeats, table_context(PLAN))
