"""Random vibration against sines: differences, their uncertainty, and why there are none."""

import dataclasses
import math

import numpy as np
import pytest

from gyrotest.procedures.random_vibration.agreement import Agreement, agreement_results, agreement_with
from gyrotest.procedures.random_vibration.agreement_figure import agreement_figure
from gyrotest.procedures.random_vibration.measured import MeasuredResponse, measured_response
from gyrotest.records.plan import Context
from gyrotest.records.result import Contribution, Result
from gyrotest.records.spec import Limit
from gyrotest.units import Quantity
from tests.unit.procedures.random_vibration_bench import QUIET, case, context, parameters, runs
from tests.unit.procedures.vibration_bench import streamed

COMMON = "source, 0.01 % of reading"


def contribution(source: str, kind: str, standard: float) -> Contribution:
    return Contribution(
        source=source,
        kind=kind,
        distribution="normal",
        half_width="",
        sensitivity="1",
        standard_uncertainty=standard,
    )


def sine_results(
    *frequencies_hz: float, larger: float = 0.0, later_deg: float = 0.0
) -> tuple[Result, ...]:
    """Return what a sine case would have measured, in volts."""
    gains, phases = [], []
    for one in frequencies_hz:
        true = QUIET.response(one)
        value = abs(true) * (1.0 + larger)
        budget = (contribution("noise", "A", 1e-4 * value), contribution(COMMON, "B", 0.05 * value))
        gains.append(
            Result(name=f"sensitivity_{one:g}Hz", label="", value=value, unit="V/(deg/s)", budget=budget)
        )
        phases.append(
            Result(
                name=f"phase_{one:g}Hz",
                label="",
                value=math.degrees(np.angle(true)) + later_deg,
                unit="deg",
                budget=(contribution("noise", "A", 0.01),),
            )
        )
    return (*gains, *phases)


def compared(*results: Result, **changes: object) -> Context:
    given = parameters(compare_with="sine")
    return context(given, earlier={"sine": results}, case=case(**changes))


@pytest.fixture(scope="module")
def measured() -> MeasuredResponse:
    return measured_response(streamed(runs()), context())


def named(agreement: Agreement) -> dict[str, Result]:
    return {one.name: one for one in agreement_results(agreement)}


def test_methods_that_agree_differ_by_no_more_than_their_uncertainty(measured: MeasuredResponse) -> None:
    found = named(agreement_with(measured, compared(*sine_results(25.0, 50.0, 90.0))))
    amplitude, phase = found["amplitude_agreement"], found["phase_agreement"]
    assert (amplitude.unit, phase.unit) == ("%", "deg")
    assert (amplitude.lower_95, phase.lower_95) == (0.0, 0.0)
    assert amplitude.value is not None
    assert amplitude.value < 0.2
    assert amplitude.condition.startswith("with case 'sine', 3 frequencies; largest at ")


def test_a_difference_of_the_methods_is_found(measured: MeasuredResponse) -> None:
    wrong = sine_results(25.0, 50.0, 90.0, larger=-0.02, later_deg=2.0)
    found = named(agreement_with(measured, compared(*wrong)))
    amplitude, phase = found["amplitude_agreement"], found["phase_agreement"]
    assert amplitude.value == pytest.approx(2.04, abs=0.15)
    assert phase.value == pytest.approx(2.0, abs=0.1)
    assert amplitude.lower_95 is not None
    assert amplitude.lower_95 > 1.5


def test_what_errs_alike_in_both_methods_is_left_out_of_their_difference(
    measured: MeasuredResponse,
) -> None:
    """The sines' budget says 5 % for the source's gain, which both have in common."""
    found = agreement_with(measured, compared(*sine_results(50.0)))
    (difference,) = found.amplitude
    assert difference.standard < 0.1
    alone = dataclasses.replace(context(), accuracy=None)
    given = dataclasses.replace(compared(*sine_results(50.0)), accuracy=alone.accuracy)
    (apart,) = agreement_with(measured, given).amplitude
    assert apart.standard == pytest.approx(5.0, rel=0.01)


def test_phases_are_compared_across_the_half_turn(measured: MeasuredResponse) -> None:
    turned = [
        dataclasses.replace(one, value=(one.value or 0.0) + 360.0) if one.unit == "deg" else one
        for one in sine_results(50.0)
    ]
    (difference,) = agreement_with(measured, compared(*turned)).phase
    assert abs(difference.value) < 0.1


def test_sines_outside_the_band_are_not_compared(measured: MeasuredResponse) -> None:
    found = agreement_with(measured, compared(*sine_results(5.0, 50.0, 150.0)))
    assert [one.frequency_hz for one in found.amplitude] == [50.0]
    none = named(agreement_with(measured, compared(*sine_results(5.0, 150.0))))
    assert none["amplitude_agreement"].value is None
    assert "has no frequency within 20 … 100 Hz" in none["phase_agreement"].condition


def test_a_case_that_was_not_measured_leaves_the_agreement_without_a_value(
    measured: MeasuredResponse,
) -> None:
    found = named(agreement_with(measured, compared()))
    assert found["amplitude_agreement"].value is None
    assert found["amplitude_agreement"].condition == (
        "case 'sine' has no sensitivities (yet); put it before this case, and see that it is measured; once"
        " it is, 'gyrotest judge' compares them"
    )
    assert agreement_figure(agreement_with(measured, compared()), compared()) == ()


def test_without_a_case_to_compare_with_nothing_is_said(measured: MeasuredResponse) -> None:
    assert named(agreement_with(measured, context())) == {}


def test_the_comparison_is_drawn_with_the_goals_and_tabled(measured: MeasuredResponse) -> None:
    limits = {"phase_agreement": Limit(max=Quantity(0.5, "deg"))}
    given = compared(*sine_results(25.0, 50.0, 90.0), limits=limits)
    (figure,) = agreement_figure(agreement_with(measured, given), given)
    amplitude, phase = ([c.y[0] for c in panel.curves] for panel in figure.panels)
    assert (amplitude, phase) == ([0.0, 1.0, -1.0], [0.0, 0.5, -0.5])
    assert "goals, 1 % and 0.5 °" in figure.caption
    assert figure.table is not None
    row = [cell.text for cell in figure.table.rows[1]]
    assert row[0] == "50 Hz"
    assert float(row[1]) == pytest.approx(1e3 * abs(QUIET.response(50.0)), rel=1e-3)
    assert row[3].lstrip("\N{MINUS SIGN}").startswith("0.0")
