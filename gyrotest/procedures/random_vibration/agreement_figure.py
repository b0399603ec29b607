"""The comparison of the methods: differences over the band in a plot and in a table."""

from gyrotest.analysis.interval import coverage_factor
from gyrotest.procedures.random_vibration.agreement import Agreement, Difference
from gyrotest.procedures.random_vibration.measurands import AMPLITUDE_AGREEMENT, PHASE_AGREEMENT
from gyrotest.procedures.random_vibration.parameters import RandomVibrationParameters
from gyrotest.procedures.wording import ending, places_of, plain
from gyrotest.records.figure import Curve, Figure, Panel, Points, Role, Scale
from gyrotest.records.plan import Context
from gyrotest.records.table import Cell, Column, Table
from gyrotest.units import Quantity, printed_unit

_BEYOND = 1.08
_MINUS = "\N{MINUS SIGN}"


def agreement_figure(agreement: Agreement, context: Context) -> tuple[Figure, ...]:
    """Draw the differences with their uncertainties; nothing where there are none."""
    if not agreement.amplitude:
        return ()
    parameters: RandomVibrationParameters = context.parameters
    goals = {
        name: _goal(context, name, goal)
        for name, goal in (
            (AMPLITUDE_AGREEMENT, parameters.amplitude_goal),
            (PHASE_AGREEMENT, parameters.phase_goal),
        )
    }
    return (
        Figure(
            name="agreement",
            title="Random vibration and sines",
            panels=(
                _panel("Sensitivity / %", "", agreement.amplitude, goals[AMPLITUDE_AGREEMENT], "%"),
                _panel("Phase / °", "Frequency / Hz", agreement.phase, goals[PHASE_AGREEMENT], "deg"),
            ),
            caption=f"Response by random vibration less that by sines (case '{agreement.case}'); bars: expanded"
            " uncertainty (95 %) of the difference, without what errs alike in both; dashed: limits or goals,"
            f" {printed_unit(str(goals[AMPLITUDE_AGREEMENT]))} and"
            f" {printed_unit(str(goals[PHASE_AGREEMENT]))}.",
            alt=f"Differences of the methods at {len(agreement.amplitude)} frequencies",
            table=_table(agreement),
        ),
    )


def _goal(context: Context, name: str, goal: Quantity) -> Quantity:
    limit = context.case.limits.get(name)
    return goal if limit is None or limit.max is None else limit.max


def _panel(
    y_label: str, x_label: str, differences: tuple[Difference, ...], goal: Quantity, unit: str
) -> Panel:
    x = tuple(one.frequency_hz for one in differences)
    ends = (min(x, default=1.0) / _BEYOND, max(x, default=1.0) * _BEYOND)
    most = goal.to(unit)
    return Panel(
        y_label=y_label,
        x_label=x_label,
        x_scale=Scale.LOG,
        curves=(
            Curve(x=ends, y=(0.0, 0.0), role=Role.GUIDE),
            *(Curve(x=ends, y=(sign * most,) * 2, role=Role.LIMIT) for sign in (1, -1)),
        ),
        points=(
            Points(x=x, y=tuple(one.value for one in differences), u=tuple(map(_expanded, differences))),
        ),
    )


def _expanded(one: Difference) -> float:
    return coverage_factor(one.freedom, coverage=0.95) * one.standard


def _table(agreement: Agreement) -> Table:
    unit = printed_unit(agreement.amplitude[0].unit)
    of = f" / ({unit})" if unit else ""
    phases = {one.frequency_hz: one for one in agreement.phase}
    return Table(
        title="Methods compared",
        note="random less sine; U without what errs alike in both",
        columns=(
            Column(heading="Frequency", share=12),
            Column(heading=f"Random{of}", share=17, numbers=True),
            Column(heading=f"Sine{of}", share=17, numbers=True),
            Column(heading="Diff. / %", share=11, numbers=True),
            Column(heading="U / %", share=9, numbers=True),
            Column(heading="Random / °", share=12, numbers=True),
            Column(heading="Sine / °", share=12, numbers=True),
            Column(heading="Diff. / °", share=11, numbers=True),
            Column(heading="U / °", share=9, numbers=True),
        ),
        rows=tuple(
            (
                Cell(text=f"{plain(one.frequency_hz, 6)} Hz"),
                *_cells(one, abs(one.random) / 100.0),
                *(_cells(phases[one.frequency_hz], 1.0) if one.frequency_hz in phases else _ABSENT),
            )
            for one in agreement.amplitude
        ),
    )


_ABSENT = (Cell(text="–"),) * 4


def _cells(one: Difference, per: float) -> tuple[Cell, ...]:
    """Tell both values, their difference and its uncertainty, which is `per` as large in the values' unit."""
    uncertainty = _expanded(one)
    places, own = places_of(uncertainty), places_of(uncertainty * per)
    return (
        Cell(text=ending(one.random, own)),
        Cell(text=ending(one.sine, own)),
        Cell(text=ending(one.value, places)),
        Cell(text=ending(uncertainty, places)),
    )
