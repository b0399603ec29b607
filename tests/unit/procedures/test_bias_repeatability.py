"""Bias repeatability: the worked example, the budget of a cycle and of the mean, honest intervals."""

import math
from typing import Any

import numpy as np
import pytest

from gyrotest.analysis.earth import EARTH_RATE_DPS
from gyrotest.errors import InsufficientDataError
from gyrotest.procedures.bias_repeatability import BiasRepeatability, BiasRepeatabilityParameters
from gyrotest.records.figure import Role
from gyrotest.records.plan import Context, Reduction
from gyrotest.records.result import Result
from gyrotest.records.spec import Between, Case, Limit, Over
from gyrotest.units import Quantity
from tests.unit.analysis.generator import DPH, gyro_noise
from tests.unit.procedures.bench import (
    by_name,
    samples_of,
    static_case,
    static_context,
    voltage_output,
    voltages,
)

EXAMPLE_DPS = (0.18789, 0.17844, 0.16965, 0.18459, 0.19401)
EARTH_DPS = EARTH_RATE_DPS * math.sin(math.radians(48.0))
NOISE = {"angle_random_walk": 30 * DPH, "bias_instability": 4 * DPH}


def cycles_case(**changes: Any) -> Case:
    plain = {
        "procedure": "bias_repeatability",
        "duration": Quantity(2.0, "min"),
        "repeats": 5,
        "between_repeats": Between.POWER_CYCLE,
    }
    return static_case(**{**plain, **changes})


def cycles_context(**changes: Any) -> Context:
    plain = {"case": cycles_case(), "parameters": BiasRepeatabilityParameters()}
    return static_context(**{**plain, **changes})


def known(values: tuple[float, ...], unit: str = "deg/s") -> tuple[tuple[Result, ...], ...]:
    return tuple((Result(name="bias", label="Bias", value=value, unit=unit),) for value in values)


def over(values: tuple[float, ...], **changes: Any) -> Reduction:
    return BiasRepeatability().reduce_repeats(known(values), cycles_context(**changes))


def test_the_sources_worked_example() -> None:
    found = by_name(over(EXAMPLE_DPS).results)
    assert found["bias_mean"].value == pytest.approx(0.182916, abs=1e-9)
    repeatability = found["bias_repeatability"]
    assert repeatability.unit == "deg/h"
    assert (repeatability.value or 0.0) / 3600.0 == pytest.approx(0.00930915, abs=5e-9)
    assert (repeatability.upper_95 or 0.0) / 3600.0 == pytest.approx(0.0267, abs=1e-4)


def test_cycles_in_another_unit_give_the_same() -> None:
    context = cycles_context()
    values = tuple(one * 3600.0 for one in EXAMPLE_DPS)
    found = by_name(BiasRepeatability().reduce_repeats(known(values, "deg/h"), context).results)
    assert (found["bias_mean"].value, found["bias_mean"].unit) == (pytest.approx(0.182916), "deg/s")


def test_the_mean_is_as_uncertain_as_its_scatter_and_what_all_cycles_share() -> None:
    repeats = tuple(cycle(seed, bias) for seed, bias in enumerate(EXAMPLE_DPS))
    context = cycles_context()
    mean = by_name(BiasRepeatability().reduce_repeats(repeats, context).results)["bias_mean"]
    scatter = mean.budget[0]
    assert scatter.degrees_of_freedom == 4
    assert scatter.standard_uncertainty == pytest.approx(0.0093 / math.sqrt(5), rel=0.05)
    assert [one.source for one in mean.budget[1:]] == [
        one.source for one in repeats[0][0].budget if one.kind == "B"
    ]
    combined = math.sqrt(sum(one.standard_uncertainty**2 for one in mean.budget))
    assert mean.expanded_uncertainty == pytest.approx((mean.coverage_factor or 0.0) * combined)
    assert (mean.coverage_factor or 0.0) > 2.0
    assert "subtracted" in mean.condition


def cycle(seed: int, bias_dps: float, samples: int = 120, **noise: float) -> tuple[Result, ...]:
    rate = gyro_noise(samples, seed=seed, **{**NOISE, **noise}) + bias_dps + EARTH_DPS
    return BiasRepeatability().reduce(voltages(rate), cycles_context()).results


def test_a_cycle_has_the_bias_of_its_record_with_its_budget() -> None:
    (bias,) = cycle(1, 0.18)
    u = (bias.expanded_uncertainty or 0.0) / (bias.coverage_factor or 1.0)
    assert abs((bias.value or 0.0) - 0.18) < 3.0 * u
    assert bias.budget[0].source == "noise and drift over 120 s"
    white_dps = 30 * DPH / math.sqrt(120.0)
    assert white_dps < bias.budget[0].standard_uncertainty < 5.0 * white_dps


def test_intervals_hold_the_turn_on_spread_although_cycles_have_noise_of_their_own() -> None:
    """Thirty units of six cycles, the noise of a cycle's mean as large as the turn-on spread."""
    spread_dps = 30 * DPH / math.sqrt(60.0)
    held, plain = 0, []
    for unit in range(30):
        random = np.random.default_rng(100 + unit)
        biases = spread_dps * random.standard_normal(6)
        repeats = tuple(cycle(1000 * unit + place, one, samples=60) for place, one in enumerate(biases))
        context = cycles_context(case=cycles_case(repeats=6))
        found = by_name(BiasRepeatability().reduce_repeats(repeats, context).results)
        result = found["bias_repeatability"]
        held += (result.lower_95 or 0.0) / 3600.0 <= spread_dps <= (result.upper_95 or 0.0) / 3600.0
        plain.append((result.value or 0.0) / 3600.0)
        assert "contains the noise of each repeat" in result.condition
    assert held >= 26
    assert np.sqrt(np.mean(np.square(plain))) > 1.2 * spread_dps


def test_fewer_than_five_cycles_are_a_printed_deviation() -> None:
    assert over(EXAMPLE_DPS).remarks == ()
    (remark,) = over(EXAMPLE_DPS[:3]).remarks
    assert remark.startswith("3 power cycles: fewer than the 5")


def test_a_cycle_without_a_bias_is_refused() -> None:
    with pytest.raises(InsufficientDataError, match="2 of 3 repeats have a bias"):
        over((0.1, math.nan, 0.2))


def test_the_figure_has_a_point_a_cycle_with_its_bar_and_the_limits_that_are_near() -> None:
    limit = Limit(min=Quantity(-2.0, "deg/s"), max=Quantity(720.0, "deg/h"))
    repeats = tuple(cycle(seed, bias) for seed, bias in enumerate(EXAMPLE_DPS))
    context = cycles_context(case=cycles_case(limits={"bias": limit}))
    reduction = BiasRepeatability().reduce_repeats(repeats, context)
    (figure,) = reduction.figures
    (panel,) = figure.panels
    (points,) = panel.points
    assert points.x == (1.0, 2.0, 3.0, 4.0, 5.0)
    assert points.y == pytest.approx([(one.value or 0.0) * 3600.0 for (one,) in repeats])
    assert points.u == pytest.approx([(one.expanded_uncertainty or 0.0) * 3600.0 for (one,) in repeats])
    levels = {(one.role, one.label): one.y[0] for one in panel.curves}
    mean = by_name(reduction.results)["bias_mean"].value or 0.0
    deviation = by_name(reduction.results)["bias_repeatability"].value
    assert levels[Role.MEAN, "mean"] == pytest.approx(mean * 3600.0)
    assert levels[Role.GUIDE, "+s"] - levels[Role.MEAN, "mean"] == pytest.approx(deviation)
    assert [y for (role, _), y in levels.items() if role is Role.LIMIT] == pytest.approx([720.0])


def test_large_biases_are_drawn_in_degrees_per_second_and_cycles_without_uncertainty_have_no_bars() -> (
    None
):
    (figure,) = over((0.6, 0.7, 0.65, 0.62, 0.66)).figures
    assert figure.panels[0].y_label == "Bias / (°/s)"
    assert figure.panels[0].points[0].u == ()
    assert "bars" not in figure.caption


@pytest.mark.parametrize(
    ("changes", "key", "message"),
    [
        ({"between_repeats": Between.NOTHING}, "between_repeats", "between_repeats: power_cycle"),
        ({"repeats": 1}, "repeats", "repeats: 5"),
        ({"duration": Quantity(20.0, "s")}, "duration", "36 are needed"),
    ],
)
def test_a_case_that_cannot_measure_it_is_refused(
    changes: dict[str, Any], key: str, message: str
) -> None:
    context = cycles_context()
    found = dict(
        BiasRepeatability().complaints(
            cycles_case(**changes), BiasRepeatabilityParameters(), context.output
        )
    )
    assert message in found[key]
    assert len(found) == 1


def test_what_is_measured_and_acquired() -> None:
    case, parameters = cycles_case(), BiasRepeatabilityParameters()
    assert not list(BiasRepeatability().complaints(case, parameters, cycles_context().output))
    measured = {
        one.name: one.over for one in BiasRepeatability().measurands(case, parameters, voltage_output())
    }
    assert measured == {"bias": None, "bias_repeatability": Over.REPEATS, "bias_mean": Over.REPEATS}
    plan = BiasRepeatability().plan(case, parameters)
    assert (plan.samples, plan.interval_s, plan.warm_up_s) == (120, 1.0, 600.0)
    assert not plan.turns


def test_a_dead_output_is_refused() -> None:
    with pytest.raises(InsufficientDataError, match="not distinguishable from the meter"):
        BiasRepeatability().reduce(samples_of(np.full(120, 2.5)), cycles_context())
