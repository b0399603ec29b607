"""What a scale-factor case plans, and what it complains of."""

from typing import Any

import pytest

from gyrotest.procedures.scale_factor import ScaleFactor, ScaleFactorParameters
from gyrotest.procedures.scale_factor.parameters import Directions
from gyrotest.records.plan import Turning
from gyrotest.records.spec import Limit, Output
from gyrotest.units import Quantity
from tests.unit.procedures.turntable import plan_of, table_case, table_output


def dps(*values: float) -> tuple[Quantity, ...]:
    return tuple(Quantity(one, "deg/s") for one in values)


def complaints(output: Output | None = None, case: Any = None, **parameters: Any) -> dict[str, str]:
    found = ScaleFactor().complaints(
        case or table_case(), ScaleFactorParameters(**parameters), output or table_output()
    )
    return dict(found)


def test_the_default_plan_is_at_rest_each_rate_both_ways_and_at_rest() -> None:
    plan = plan_of(table_case())
    rates = [one.stimulus.rate_dps for one in plan.steps if isinstance(one.stimulus, Turning)]
    assert rates == [0, 10, -10, 20, -20, 40, -40, 60, -60, 80, -80, 0]
    assert plan.samples == 12 * 100
    assert (plan.warm_up_s, plan.interval_s) == (600.0, 0.1)
    assert plan.steps[0].stimulus == Turning(rate_dps=0.0, settle_s=2.0, tolerance_dps=0.05)
    assert len({one.name for one in plan.steps}) == len(plan.steps)
    assert not any(one.may_saturate for one in plan.steps)


def test_an_explicit_list_of_signed_rates_is_turned_as_it_is() -> None:
    assert ScaleFactorParameters(rates=dps(-10, 20, 40)).signed_rates_dps == (-10, 20, 40)
    given = ScaleFactorParameters(rates=dps(10, 20), directions=Directions.AS_GIVEN)
    assert given.signed_rates_dps == (10, 20)


def test_eleven_levels_and_a_long_rest_are_planned() -> None:
    parameters = ScaleFactorParameters(rates=dps(*range(10, 120, 10)), rest=Quantity(30.0, "s"))
    plan = plan_of(table_case(), parameters)
    assert len(plan.steps) == 24
    assert [plan.steps[0].samples, plan.steps[1].samples, plan.steps[-1].samples] == [300, 100, 300]


def test_a_case_without_faults_has_no_complaints() -> None:
    limits = {name: Limit(max=Quantity(1.0, "%")) for name in ("nonlinearity", "asymmetry")}
    assert complaints(case=table_case(limits=limits)) == {}


@pytest.mark.parametrize(
    ("parameters", "key", "message"),
    [
        ({"rates": ()}, "parameters.rates", "0 rate is too few"),
        ({"rates": dps(10)}, "parameters.rates", "1 rate is too few"),
        ({"rates": dps(-10, -10)}, "parameters.rates", "two at least"),
        ({"rates": dps(10, 0, 20)}, "parameters.rates[1]", "is no turn"),
        ({"settle": Quantity(-1.0, "s")}, "parameters.settle", "less than zero"),
        ({"tolerance": Quantity(0.0, "deg/s")}, "parameters.tolerance", "not more than zero"),
        ({"window": Quantity(-5.0, "%")}, "parameters.window", "not more than zero"),
        ({"outlier_mads": 2.0}, "parameters.outlier_mads", "ordinary noise"),
        ({"rest": Quantity(10.05, "s")}, "parameters.rest", "no whole number of intervals of '0.1 s'"),
        ({"rest": Quantity(1.0, "s")}, "parameters.rest", "at least 1.6 s"),
    ],
)
def test_faulty_parameters_are_told_at_their_key(
    parameters: dict[str, Any], key: str, message: str
) -> None:
    assert message in complaints(**parameters)[key]


def test_a_limit_on_what_one_sign_does_not_give_makes_the_spec_invalid() -> None:
    for name in ("asymmetry", "scale_factor_forward"):
        case = table_case(limits={name: Limit(max=Quantity(1.0, "%"))})
        found = complaints(case=case, rates=dps(-10, -20, -40))
        assert found == {f"limits.{name}": "needs two rates of each sign; see 'parameters.rates'"}
    assert complaints(rates=dps(-10, -20, -40)) == {}


def test_a_limit_of_full_scale_needs_full_scale() -> None:
    case = table_case(limits={"nonlinearity": Limit(max=Quantity(0.1, "%"))})
    found = complaints(table_output(full_scale=None), case=case)
    assert "output.full_scale" in found["limits.nonlinearity"]


def test_several_axes_and_steps_too_short_are_told() -> None:
    output = table_output(axes=("x", "y", "z"))
    assert "the table turns about one" in complaints(output)["axes"]
    assert complaints(output, table_case(axes=("z",))) == {}
    short = table_case(duration=Quantity(1.0, "s"))
    assert "10 samples a step" in complaints(case=short)["duration"]
