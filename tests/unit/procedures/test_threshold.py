"""Threshold and resolution: dead zones found, noise that does not decide, tables that are not good enough."""

import dataclasses
from dataclasses import dataclass
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from gyrotest.conformity import judge
from gyrotest.errors import InsufficientDataError
from gyrotest.procedures.threshold import (
    Resolution,
    ResolutionParameters,
    Threshold,
    ThresholdParameters,
)
from gyrotest.records.plan import Context, Reduction, Turning
from gyrotest.records.result import Result, Verdict
from gyrotest.records.spec import Case, Limit
from gyrotest.records.station import Accuracy
from gyrotest.specification.spec import case_parameters
from gyrotest.units import Quantity
from tests.unit.procedures.bench import by_name
from tests.unit.procedures.turntable import (
    Unit,
    dwells_of,
    samples_of_turns,
    table_case,
    table_context,
    table_output,
)

VALUE = Quantity(0.05, "deg/s")
FROM_REST = ThresholdParameters(value=VALUE)
AROUND = ResolutionParameters(value=VALUE, around=Quantity(-10.0, "deg/s"))
NOISE = {"angle_random_walk": 0.002}
TABLE = Accuracy(of_reading=Quantity(20.0, "ppm"), of_setting=Quantity(0.0005, "deg/s"))


@dataclass(frozen=True, kw_only=True)
class Stiff(Unit):
    """A unit that does not feel rates about `sticks_at_dps` that differ from it by less than `zone_dps`."""

    zone_dps: float = 0.0
    sticks_at_dps: float = 0.0

    def response(self, rate_dps: NDArray[np.float64]) -> NDArray[np.float64]:
        away = rate_dps - self.sticks_at_dps
        felt = self.sticks_at_dps + np.where(np.abs(away) < self.zone_dps, 0.0, away)
        return self.scale_factor * felt


def small_case(**changes: Any) -> Case:
    return table_case(**{"procedure": "threshold", **changes})


def reduced(
    unit: Unit, parameters: ThresholdParameters = FROM_REST, *, seed: int = 1, **changes: Any
) -> Reduction:
    procedure = Resolution() if isinstance(parameters, ResolutionParameters) else Threshold()
    plan = procedure.plan(small_case(), parameters)
    context: Context = dataclasses.replace(
        table_context(plan, case=small_case(), parameters=parameters, table=TABLE), **changes
    )
    return procedure.reduce(samples_of_turns(unit, plan, seed=seed), context)


def found(reduction: Reduction) -> Result:
    return reduction.results[0]


def stiff(zone_dps: float, sticks_at_dps: float = 0.0, **noise: float) -> Stiff:
    return Stiff(zone_dps=zone_dps, sticks_at_dps=sticks_at_dps, noise=noise or dict(NOISE))


@pytest.mark.parametrize(("zone_dps", "threshold"), [(0.02, 0.025), (0.03, 0.05), (0.06, 0.1)])
def test_the_threshold_is_the_smallest_change_beyond_the_dead_zone(
    zone_dps: float, threshold: float
) -> None:
    one = found(reduced(stiff(zone_dps)))
    assert (one.name, one.value, one.at_most) == ("threshold", pytest.approx(threshold), False)
    assert (one.lower_95 or 0.0) < zone_dps < (one.upper_95 or 0.0)
    assert one.lower_95 == pytest.approx(threshold / 2.0, abs=1e-3)
    assert "is not followed" in one.condition


def test_the_resolution_is_found_around_a_rate() -> None:
    one = found(reduced(stiff(0.03, sticks_at_dps=-10.0), AROUND))
    assert (one.name, one.value) == ("resolution", pytest.approx(0.05))
    assert "from −10 °/s" in one.condition


def test_a_dead_zone_at_rest_is_no_matter_of_resolution() -> None:
    one = found(reduced(stiff(0.03), AROUND))
    assert one.at_most


def test_a_smallest_change_that_is_followed_is_an_upper_bound() -> None:
    one = found(reduced(stiff(0.0)))
    assert (one.value, one.at_most, one.lower_95) == (pytest.approx(0.0125), True, 0.0)
    assert "nothing smaller was tried" in one.condition


def test_an_inverted_gyro_follows_as_well() -> None:
    unit = dataclasses.replace(stiff(0.03), scale_factor=-0.05)
    output = table_output(scale_factor=Quantity(-50.0, "mV/(deg/s)"))
    assert found(reduced(unit, output=output)).value == pytest.approx(0.05)


def test_a_gyro_with_the_wrong_sign_follows_nothing() -> None:
    unit = dataclasses.replace(stiff(0.0), scale_factor=-0.05)
    one = found(reduced(unit))
    assert one.condition.startswith("more than that")


def verdict(one: Result, most: float) -> Verdict | None:
    case = small_case()
    (measurand, _) = Threshold().measurands(case, FROM_REST, table_output())
    limit = Limit(max=Quantity(most, "deg/s"))
    return judge(measurand, one, limit, case="threshold", repeat=1).verdict


def test_a_gyro_that_follows_none_of_the_changes_fails_every_limit_that_is_allowed() -> None:
    one = found(reduced(stiff(0.5)))
    assert one.value == pytest.approx(0.1)
    assert one.upper_95 is None
    assert verdict(one, 0.099) is Verdict.FAIL
    case = small_case(limits={"threshold": Limit(max=Quantity(0.1, "deg/s"))})
    complaints = dict(Threshold().complaints(case, FROM_REST, table_output()))
    assert "below the largest, 0.1 deg/s" in complaints["limits.threshold.max"]


def test_noise_that_hides_the_changes_leaves_it_open_and_never_passes() -> None:
    one = found(reduced(stiff(0.0, angle_random_walk=1.0)))
    assert one.value is None
    assert "noise does not let tell" in one.condition
    assert verdict(one, 0.06) is Verdict.INCOMPLETE


def test_noise_makes_the_threshold_larger_and_not_smaller() -> None:
    """Forty noisy units with a dead zone of 0.03 °/s: none is found to follow less."""
    values = [
        found(reduced(stiff(0.03, angle_random_walk=0.015), seed=seed)).value for seed in range(40)
    ]
    assert min(one for one in values if one is not None) >= 0.05 - 1e-9
    assert values.count(pytest.approx(0.05)) >= 30


def test_the_response_at_the_stated_value_has_its_uncertainty() -> None:
    zs = []
    for seed in range(30):
        one = by_name(reduced(stiff(0.0), seed=seed).results)["threshold_response"]
        standard = (one.expanded_uncertainty or 0.0) / (one.coverage_factor or 1.0)
        zs.append(((one.value or 0.0) - 100.0) / standard)
    # the weaker of two independent responses: on average 0.56 of a standard uncertainty too small
    assert -1.1 < np.mean(zs) < 0.0
    assert 0.5 < np.std(zs) < 1.3


@pytest.mark.parametrize(
    ("table", "message"),
    [
        (None, "is not known; state 'accuracy.of_setting'"),
        (Accuracy(of_reading=Quantity(20.0, "ppm")), "is not known; state 'accuracy.of_setting'"),
        (
            Accuracy(of_reading=Quantity(0.0, "ppm"), of_setting=Quantity(0.015, "deg/s")),
            "more than a third of the value 0.05 deg/s",
        ),
    ],
)
def test_a_table_that_is_not_good_enough_is_refused(table: Accuracy | None, message: str) -> None:
    with pytest.raises(InsufficientDataError, match=message):
        reduced(stiff(0.0), table=table)


def test_two_settings_are_worse_than_one() -> None:
    """0.0125 °/s of half-width leave U = 0.0144 °/s of a change from rest, and 0.0204 of one around a rate."""
    table = Accuracy(of_reading=Quantity(0.0, "ppm"), of_setting=Quantity(0.0125, "deg/s"))
    assert found(reduced(stiff(0.0), table=table)).value
    with pytest.raises(InsufficientDataError, match="more than a third"):
        reduced(stiff(0.0), AROUND, table=table)


def test_a_table_that_does_not_turn_so_slowly_is_refused() -> None:
    plan = Threshold().plan(small_case(), FROM_REST)
    stuck = tuple(dataclasses.replace(one, measured_rate_dps=0.0) for one in dwells_of(plan))
    with pytest.raises(InsufficientDataError, match="does it turn so slowly"):
        reduced(stiff(0.0), dwells=stuck)


def test_a_recording_that_lacks_steps_is_refused() -> None:
    plan = Threshold().plan(small_case(), FROM_REST)
    with pytest.raises(InsufficientDataError, match="60 of 65 steps"):
        reduced(stiff(0.0), dwells=dwells_of(plan)[:60])


def test_the_plan_goes_up_and_down_between_steps_at_the_base() -> None:
    parameters = dataclasses.replace(AROUND, levels=(1.0, 2.0), steps=1)
    plan = Resolution().plan(small_case(), parameters)
    turnings = [one.stimulus for one in plan.steps if isinstance(one.stimulus, Turning)]
    assert [one.rate_dps for one in turnings] == pytest.approx(
        [-10.0, -9.95, -10.0, -10.05, -10.0, -9.9, -10.0, -10.1, -10.0]
    )
    # a table that is settled only within a change would not make one
    assert turnings[1].tolerance_dps == pytest.approx(0.05 / 3.0)


def test_the_figure_shows_both_ways_with_bars_and_one_half() -> None:
    (figure,) = reduced(stiff(0.03)).figures
    (panel,) = figure.panels
    assert [one.label for one in panel.points] == ["up", "down"]
    assert all(len(one.x) == len(one.u) == 4 for one in panel.points)
    assert panel.curves[0].y == (50.0, 50.0)
    assert figure.table is not None
    assert [row[-1].text for row in figure.table.rows] == ["not followed"] * 2 + ["followed"] * 2


@pytest.mark.parametrize(
    ("parameters", "key", "message"),
    [
        ({"value": "0 deg/s"}, "parameters.value", "not more than zero"),
        ({"value": "0.05 deg/s", "steps": 0}, "parameters.steps", "between 1 and 100"),
        ({"value": "0.05 deg/s", "levels": [2, 1]}, "parameters.levels", "rising"),
        ({"value": "0.05 deg/s", "levels": [0.5, 2]}, "parameters.levels", "1 among them"),
        ({"value": "1 deg/s", "around": "1 deg/s"}, "parameters.around", "not beyond"),
    ],
)
def test_a_case_that_cannot_measure_it_is_refused(
    parameters: dict[str, Any], key: str, message: str
) -> None:
    case = small_case(parameters=parameters)
    checked = case_parameters(case, Resolution())
    complaints = dict(Resolution().complaints(case, checked, table_output()))
    assert message in complaints[key]


def test_a_sound_case_is_accepted_and_measures_two_things() -> None:
    case = small_case(limits={"threshold": Limit(max=Quantity(0.05, "deg/s"))})
    assert not list(Threshold().complaints(case, FROM_REST, table_output()))
    measured = Threshold().measurands(case, FROM_REST, table_output())
    assert [one.name for one in measured] == ["threshold", "threshold_response"]
