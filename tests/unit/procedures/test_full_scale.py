"""Measurement range: how far the output stays on the line, and where it saturates."""

import dataclasses
from typing import Any

import numpy as np
import pytest

from gyrotest.errors import InsufficientDataError
from gyrotest.procedures.full_scale import FullScale, FullScaleParameters
from gyrotest.records.plan import Plan, Reduction
from gyrotest.records.recording import Samples
from gyrotest.records.spec import Output
from gyrotest.records.station import Accuracy
from gyrotest.units import Quantity
from tests.unit.procedures.bench import by_name
from tests.unit.procedures.turntable import (
    Unit,
    dwells_of,
    plan_of,
    samples_of_turns,
    table_case,
    table_context,
    table_output,
)

CASE = table_case(procedure="full_scale", duration=Quantity(5.0, "s"))
LINEARITY = Quantity(0.1, "%")
PARAMETERS = FullScaleParameters(linearity=LINEARITY, up_to=Quantity(120.0, "deg/s"))


def planned(parameters: FullScaleParameters = PARAMETERS) -> Plan:
    return plan_of(CASE, parameters, FullScale())


def reduced(samples: Samples, **changes: Any) -> Reduction:
    parameters = changes.pop("parameters", PARAMETERS)
    context = table_context(planned(parameters), case=CASE, parameters=parameters, **changes)
    return FullScale().reduce(samples, context)


def clipped(volts: tuple[float, float], noise_v: float = 0.0) -> Samples:
    samples = samples_of_turns(Unit(bias_dps=0.0), planned())
    values = np.clip(samples.values, *volts)
    values = values + np.random.default_rng(1).normal(0.0, noise_v, values.shape) if noise_v else values
    return dataclasses.replace(samples, values=values)


def test_the_plan_may_saturate_but_not_at_rest() -> None:
    plan = planned()
    rates = [getattr(one.stimulus, "rate_dps", None) for one in plan.steps]
    assert rates[:5] == [0.0, 10.0, -10.0, 20.0, -20.0]
    assert rates[-2:] == [-120.0, 0.0]
    assert [one.may_saturate for one in plan.steps] == [False, *([True] * 24), False]


def test_a_gyro_that_stays_on_the_line_reaches_at_least_the_largest_rate() -> None:
    found = reduced(samples_of_turns(Unit(), planned()))
    whole = by_name(found.results)["measurement_range"]
    # How far beyond it reaches is not known.
    assert (whole.value, whole.lower_95, whole.upper_95) == (120.0, 120.0, None)
    assert whole.condition == "within 0.1 % of full scale; at least: the largest rate tested"
    assert found.remarks[0] == "No saturation found forward, up to 120 °/s."


def test_overloads_are_data_and_end_the_range() -> None:
    found = reduced(samples_of_turns(Unit(bias_dps=0.0, saturation=5.25), planned()))
    for name in ("measurement_range", "measurement_range_forward", "measurement_range_backward"):
        one = by_name(found.results)[name]
        assert (one.value, one.upper_95) == (100.0, 110.0)
    assert by_name(found.results)["measurement_range_backward"].condition.endswith(
        "saturated at −110 °/s"
    )
    assert "Saturation found forward at 110 °/s: 50 of 50 samples overloaded" in found.remarks[0]


@pytest.mark.parametrize("noise_v", [0.0, 3e-6])
def test_a_rail_is_found_by_the_values_each_way_apart(noise_v: float) -> None:
    found = by_name(reduced(clipped((2.5 - 4.25, 2.5 + 5.6), noise_v)).results)
    assert found["measurement_range_forward"].value == 110.0
    assert found["measurement_range_backward"].value == 80.0
    assert found["measurement_range"].value == 80.0
    assert (found["measurement_range"].lower_95, found["measurement_range"].upper_95) == (80.0, 90.0)


def test_both_ways_are_no_surer_than_the_less_sure_way() -> None:
    """Beyond 50 °/s the two ways bend apart: the interval of the smaller range holds both doubts."""
    bent = Unit(asymmetry_ppm=1500.0, cubic_ppm=2000.0, noise={"angle_random_walk": 0.03})
    for seed in range(1, 21):
        found = by_name(reduced(samples_of_turns(bent, planned(), seed=seed)).results)
        both, *ways = (found[f"measurement_range{way}"] for way in ("", "_forward", "_backward"))
        assert both.value == min(one.value or 0.0 for one in ways)
        assert both.lower_95 == min(one.lower_95 or 0.0 for one in ways)
        uppers = [one.upper_95 for one in ways if one.upper_95 is not None]
        assert both.upper_95 == min(uppers, default=None)


def test_an_output_that_is_never_on_the_line_has_no_range_and_fails_a_minimum() -> None:
    rates = np.array([one.rate_dps or 0.0 for one in dwells_of(planned())])
    samples = samples_of_turns(Unit(), planned())
    # A dead band: nothing up to 15 °/s, the whole rate beyond.
    dead = np.repeat(np.where(np.abs(rates) < 15.0, -0.05 * rates, 0.0), 50)
    found = by_name(
        reduced(dataclasses.replace(samples, values=samples.values + dead[:, None])).results
    )["measurement_range"]
    assert (found.value, found.lower_95, found.upper_95) == (0.0, 0.0, 10.0)
    assert found.condition.endswith("off the line at 10 °/s: not even the first step is on it")


def test_a_table_whose_settings_own_errors_are_not_known_is_named() -> None:
    table = Accuracy(of_reading=Quantity(20.0, "ppm"))
    found = by_name(reduced(samples_of_turns(Unit(), planned()), table=table).results)
    assert found["measurement_range"].not_included == ("own error of each setting of the rate table",)


def test_a_slow_bend_leaves_the_line_where_the_linearity_says() -> None:
    bent = Unit(cubic_ppm=2000.0)
    found = by_name(reduced(samples_of_turns(bent, planned())).results)["measurement_range"]
    rates = np.arange(10.0, 121.0, 10.0)
    both = np.concatenate((rates[:5], -rates[:5]))
    line = np.polyfit(both, bent.response(both), 1)
    off = np.abs(bent.response(rates) - line[0] * rates) / (0.05 * 100.0)
    truth = rates[off <= 1e-3].max()
    assert found.lower_95 is not None
    assert found.upper_95 is not None
    assert found.lower_95 <= truth <= found.upper_95
    assert "off the line at" in found.condition


def test_a_line_of_saturated_steps_is_refused() -> None:
    with pytest.raises(InsufficientDataError, match="the line is fitted to this step"):
        reduced(samples_of_turns(Unit(saturation=2.0), planned()))


def test_the_figure_has_limits_and_a_bar_for_each_step_on_a_scale() -> None:
    figure, steps = reduced(samples_of_turns(Unit(saturation=5.25), planned())).figures
    (panel,) = figure.panels
    assert [len(one.u) for one in panel.points] == [10, 10]
    assert steps.table is not None
    assert len(steps.table.rows) == 26


@pytest.mark.parametrize(
    ("parameters", "key", "message"),
    [
        ({}, "parameters", "neither 'up_to' nor 'rates'"),
        ({"up_to": Quantity(90.0, "deg/s")}, "parameters.up_to", "does not reach full scale"),
        ({"up_to": Quantity(120.0, "deg/s"), "steps": 1}, "parameters.steps", "not between 2 and"),
        ({"up_to": Quantity(120.0, "deg/s"), "steps": 3}, "parameters.up_to", "two steps for the line"),
        (
            {"rates": (Quantity(50.0, "deg/s"), Quantity(20.0, "deg/s"))},
            "parameters.rates",
            "do not rise",
        ),
        (
            {"rates": (Quantity(50.0, "deg/s"),), "up_to": Quantity(120.0, "deg/s")},
            "parameters.up_to",
            "beside 'rates'",
        ),
    ],
)
def test_faulty_parameters_are_told_at_their_key(
    parameters: dict[str, Any], key: str, message: str
) -> None:
    found = FullScale().complaints(
        CASE, FullScaleParameters(linearity=LINEARITY, **parameters), table_output()
    )
    assert message in dict(found)[key]


def test_full_scale_itself_is_needed() -> None:
    output: Output = table_output(full_scale=None)
    assert "output.full_scale" in dict(FullScale().complaints(CASE, PARAMETERS, output))["procedure"]


def test_means_of_steps_at_a_limit_are_told_to_the_digits_of_the_others() -> None:
    _, steps = reduced(clipped((2.5 - 4.25, 2.5 + 5.6), 3e-6)).figures
    assert steps.table is not None
    means = [row[3].text.removesuffix(" V") for row in steps.table.rows]
    assert {len(one.partition(".")[2]) for one in means} == {6}
