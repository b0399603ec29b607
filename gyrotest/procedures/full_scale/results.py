"""Measurement ranges as results, the figure of deviations, and what is to be said of saturation."""

from collections.abc import Iterator
from dataclasses import replace

from gyrotest.procedures.full_scale.parameters import RANGE_LABELS, FullScaleParameters
from gyrotest.procedures.full_scale.reach import Reach, Reached, Reaches
from gyrotest.procedures.table_steps import missing_of_table
from gyrotest.procedures.wording import plain
from gyrotest.records.figure import Curve, Figure, Panel, Points, Role
from gyrotest.records.plan import Context
from gyrotest.records.result import Result

_PERCENT = 100.0
_MINUS = "\N{MINUS SIGN}"
_MARGIN = 1.06


def range_results(reaches: Reaches, context: Context) -> Iterator[Result]:
    """Give the range both ways, and each way."""
    yield _range_result("measurement_range", _smaller(reaches.forward, reaches.backward), context)
    yield _range_result("measurement_range_forward", reaches.forward, context)
    yield _range_result("measurement_range_backward", reaches.backward, context)


def _smaller(one: Reach, other: Reach) -> Reach:
    """Return the smaller reach, whose interval holds the doubts of both."""
    uppers = [each.upper_dps for each in (one, other) if each.upper_dps is not None]
    return replace(
        min((one, other), key=lambda each: (each.value_dps, each.left_at is None)),
        lower_dps=min(one.lower_dps, other.lower_dps),
        upper_dps=min(uppers, default=None),
    )


def _range_result(name: str, reach: Reach, context: Context) -> Result:
    parameters: FullScaleParameters = context.parameters
    within = f"within {parameters.linearity} of full scale"
    return Result(
        name=name,
        label=RANGE_LABELS[name],
        value=reach.value_dps,
        unit="deg/s",
        lower_95=reach.lower_dps,
        upper_95=reach.upper_dps,
        at_least=reach.left_at is None,
        condition=f"{within}; {_how_far(reach)}",
        not_included=missing_of_table(context),
    )


def _how_far(reach: Reach) -> str:
    if reach.left_at is None:
        return "at least: the largest rate tested"
    place = f"{'saturated' if reach.left_at.saturated else 'off the line'} at {_rate(reach.left_at)}"
    return place if reach.value_dps else f"{place}: not even the first step is on it"


def saturation_remarks(reaches: Reaches) -> Iterator[str]:
    """Say where saturation was found."""
    for way, reach in (("forward", reaches.forward), ("backward", reaches.backward)):
        first = next((one for one in reach.steps if one.saturated), None)
        if first is None:
            yield f"No saturation found {way}, up to {_rate(reach.steps[-1])}."
            continue
        yield f"Saturation found {way} at {_rate(first)}: {_how(first)}."


def _how(step: Reached) -> str:
    """Say by what saturation was found."""
    record = step.record
    if step.flat and not record.saturated:
        return "the output does not grow any more"
    found = ((record.overloaded, "overloaded"), (record.railed, "at one limit"))
    parts = [f"{count} of {record.dwell.samples} samples {what}" for count, what in found if count]
    return ", ".join(parts)


def _rate(step: Reached) -> str:
    return f"{plain(step.record.rate_dps, 6)} °/s".replace("-", _MINUS)


def range_figure(reaches: Reaches, context: Context) -> Figure:
    """Draw how far each step that is not saturated is from the line, with the limits."""
    parameters: FullScaleParameters = context.parameters
    limit = parameters.linearity.to("") * _PERCENT
    rates = [one.rate_dps for one in reaches.records]
    ends = (_MARGIN * min(rates), _MARGIN * max(rates))
    limits = tuple(
        Curve(x=ends, y=(sign * limit,) * 2, role=Role.LIMIT, label="limit" if sign > 0 else "")
        for sign in (1, -1)
    )
    panel = Panel(
        y_label="Deviation / % of full scale",
        x_label="Rate / (°/s)",
        curves=(Curve(x=ends, y=(0.0, 0.0), role=Role.GUIDE), *limits),
        points=tuple(_points(reaches)),
    )
    return Figure(
        name="range",
        title="Measurement range",
        panels=(panel,),
        caption="Deviation of each step's mean output from the line through the steps to"
        f" {plain(_line_end(reaches, context), 6)} °/s; bars: expanded uncertainty (95 %); dashed: limits."
        " Saturated steps are left out.",
        alt=f"Deviations from the line up to {plain(max(rates), 6)} °/s, limits ±{plain(limit, 4)} %",
    )


def _line_end(reaches: Reaches, context: Context) -> float:
    parameters: FullScaleParameters = context.parameters
    most = parameters.line_to_dps(context.output)
    return max(abs(one.rate_dps) for one in reaches.records if abs(one.rate_dps) <= most * (1.0 + 1e-9))


def _points(reaches: Reaches) -> Iterator[Points]:
    for series, (way, reach) in enumerate(
        (("forward", reaches.forward), ("backward", reaches.backward))
    ):
        drawn = [one for one in reach.steps if one.deviation is not None]
        yield Points(
            x=tuple(one.record.rate_dps for one in drawn),
            y=tuple(_PERCENT * (one.deviation or 0.0) for one in drawn),
            u=tuple(_PERCENT * (one.uncertainty or 0.0) for one in drawn),
            label=way,
            series=series,
        )
