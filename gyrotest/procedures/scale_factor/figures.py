"""Figures of a scale-factor test: the response with its residuals, and the table of steps."""

import math

import numpy as np
from numpy.typing import NDArray

from gyrotest.analysis.interval import coverage_factor
from gyrotest.analysis.scale_factor import Linear
from gyrotest.procedures.dwells import DwellRecord
from gyrotest.procedures.step_table import STEP_COLUMNS, mean_places, output_words, step_cells
from gyrotest.procedures.turns import Turns
from gyrotest.procedures.wording import ending, places_of, plain
from gyrotest.records.figure import Curve, Figure, Panel, Points, Role
from gyrotest.records.plan import Context
from gyrotest.records.table import Cell, Column, Table
from gyrotest.units import printed_unit

_PPM = 1e6
_MARGIN = 1.06
_COLUMNS = (
    *STEP_COLUMNS[:4],
    Column(heading="Residual / ppm", share=14, numbers=True),
    Column(heading="U / ppm", share=10, numbers=True),
    *STEP_COLUMNS[4:],
)


def turn_figures(turns: Turns, context: Context) -> tuple[Figure, ...]:
    """Return the figures, in the order of the certificate."""
    return (_response_figure(turns, context),)


def _scale_dps(turns: Turns, context: Context) -> float:
    """Return the rate to which residuals are in proportion: full scale, or the largest tested."""
    full_scale = context.output.full_scale
    return turns.largest_dps if full_scale is None else full_scale.to("deg/s")


def _response_figure(turns: Turns, context: Context) -> Figure:
    full_scale = context.output.full_scale
    scale_dps = _scale_dps(turns, context)
    of = (
        f"{'the largest rate tested' if full_scale is None else 'full scale'}, {plain(scale_dps, 6)} °/s"
    )
    residual, bars = _residuals_ppm(turns, scale_dps)
    return Figure(
        name="response",
        title="Response and residuals",
        panels=(_response_panel(turns), _residual_panel(turns, context, residual, bars)),
        caption="Top: mean output of each step, and the least-squares line. Bottom: what the steps leave, in"
        f" parts per million of {of}; bars: expanded uncertainty (95 %) of each, without what all have in"
        " common" + ("; dashed: limits." if _limits(turns, context) else "."),
        alt=f"Output of {turns.rates_dps.size} steps from {plain(float(turns.rates_dps.min()), 6)} to"
        f" {plain(float(turns.rates_dps.max()), 6)} °/s, residuals within"
        f" {plain(float(np.abs(residual).max()), 3)} ppm",
        table=_steps_table(turns, residual, bars, of),
    )


def _residuals_ppm(turns: Turns, scale_dps: float) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    per = _PPM / (abs(turns.fit.scale_factor.value) * scale_dps)
    bars = np.array([_expanded(turns, one) for one in turns.fit.residuals])
    return turns.fit.residual * per, bars * per


def _expanded(turns: Turns, one: Linear) -> float:
    variance = turns.total(one)
    return coverage_factor(variance.degrees_of_freedom, coverage=0.95) * math.sqrt(variance.value)


def _response_panel(turns: Turns) -> Panel:
    fit, rates = turns.fit, turns.rates_dps
    ends = np.array([rates.min(), rates.max()])
    line = fit.offset.value + fit.scale_factor.value * ends
    outputs = np.array([one.mean for one in turns.turning])
    return Panel(
        y_label=f"Output / {_factor_free(turns.scaling.unit)}",
        x_label="Rate / (°/s)",
        curves=(Curve(x=_drawn(ends), y=_drawn(line), role=Role.MODEL),),
        points=_sides(rates, outputs, None),
    )


def _factor_free(unit: str) -> str:
    printed = printed_unit(unit)
    return f"({printed})" if "/" in printed else printed


def _residual_panel(
    turns: Turns, context: Context, residual: NDArray[np.float64], bars: NDArray[np.float64]
) -> Panel:
    rates = turns.rates_dps
    return Panel(
        y_label="Residual / ppm",
        x_label="Rate / (°/s)",
        curves=(_level(rates, 0.0, Role.GUIDE), *_limits(turns, context)),
        points=_sides(rates, residual, bars),
    )


def _limits(turns: Turns, context: Context) -> tuple[Curve, ...]:
    name = "nonlinearity_of_tested" if context.output.full_scale is None else "nonlinearity"
    limit = context.case.limits.get(name)
    if limit is None or limit.max is None:
        return ()
    most = limit.max.to("ppm")
    return tuple(
        _level(turns.rates_dps, sign * most, Role.LIMIT, "limit" if sign > 0 else "") for sign in (1, -1)
    )


def _level(rates: NDArray[np.float64], y: float, role: Role, label: str = "") -> Curve:
    ends = (_MARGIN * float(min(rates.min(), 0.0)), _MARGIN * float(max(rates.max(), 0.0)))
    return Curve(x=ends, y=(y, y), role=role, label=label)


def _sides(
    rates: NDArray[np.float64], values: NDArray[np.float64], bars: NDArray[np.float64] | None
) -> tuple[Points, ...]:
    """Tell forward and backward turns apart."""
    return tuple(
        Points(
            x=_drawn(rates[chosen]),
            y=_drawn(values[chosen]),
            u=() if bars is None else _drawn(bars[chosen]),
            label=label,
            series=series,
        )
        for series, (label, chosen) in enumerate((("forward", rates > 0.0), ("backward", rates < 0.0)))
        if chosen.any()
    )


def _steps_table(
    turns: Turns, residual: NDArray[np.float64], bars: NDArray[np.float64], of: str
) -> Table:
    left = {
        one.dwell.first: (float(r), float(u))
        for one, r, u in zip(turns.turning, residual, bars, strict=True)
    }
    records = tuple(sorted((*turns.rest, *turns.turning), key=lambda one: one.dwell.first))
    return Table(
        title="Steps",
        note="; ".join(part for part in (f"residuals in ppm of {of}", output_words(records)) if part),
        columns=_COLUMNS,
        rows=tuple(_row(one, mean_places(records), left.get(one.dwell.first)) for one in records),
    )


def _row(record: DwellRecord, places: int, left: tuple[float, float] | None) -> tuple[Cell, ...]:
    cells = step_cells(record, places)
    residual, bar = "–", "–"
    if left is not None:
        residual, bar = ending(left[0], places_of(left[1])), plain(left[1], 2)
    return (*cells[:4], Cell(text=residual), Cell(text=bar), *cells[4:])


def _drawn(values: NDArray[np.float64]) -> tuple[float, ...]:
    return tuple(values.tolist())
