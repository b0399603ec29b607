"""The figure: what is left of each rate before and after compensation, with uncertainty bars."""

from collections.abc import Iterator

import numpy as np

from gyrotest.analysis.interval import NORMAL_95
from gyrotest.procedures.compensation.verification import Residuals, Verification
from gyrotest.procedures.drawn_units import Unit, rate_unit
from gyrotest.procedures.wording import rate_text
from gyrotest.records.figure import Curve, Figure, Panel, Points, Role
from gyrotest.records.plan import Context
from gyrotest.records.spec import Limit

_FAR = 3.0  # how many times larger than the largest residual a limit may be and still be drawn


def residuals_figure(found: Verification, context: Context) -> Figure:
    """Draw the residuals over the rate, each panel in its own scale."""
    before, after = (
        _panel(when, residuals, found, context.case.limits.get(f"residual_max_{when}"))
        for when, residuals in (("before", found.before), ("after", found.after))
    )
    largest = tuple(
        rate_text(float(np.abs(one.values_dps).max()), 3) for one in (found.before, found.after)
    )
    return Figure(
        name="compensation",
        title="Residual before and after compensation",
        panels=(before, after),
        note=f"{found.rates_dps.size} steps; largest {largest[0]} before, {largest[1]} after",
        caption="Rate by the gyro less the table's. Top: by the nominal scale factor and zero; bottom: by the"
        " fitted scale factor and bias. Bars: 95 %, by noise, table and meter.",
        alt=f"Residual rates at {found.rates_dps.size} steps, largest {largest[0]} before and"
        f" {largest[1]} after compensation",
    )


def _panel(when: str, residuals: Residuals, found: Verification, limit: Limit | None) -> Panel:
    largest = float(np.abs(residuals.values_dps).max())
    unit = rate_unit(largest)
    order = np.argsort(found.rates_dps, kind="stable")
    bars = NORMAL_95 * residuals.standard_dps
    rates = found.rates_dps[order]
    return Panel(
        y_label=f"{when.capitalize()} / ({unit.name})",
        x_label="Table rate / (°/s)",
        curves=tuple(_lines((float(rates[0]), float(rates[-1])), largest, unit, limit)),
        points=(
            Points(
                x=tuple(rates.tolist()),
                y=tuple((residuals.values_dps[order] * unit.factor).tolist()),
                u=tuple((bars[order] * unit.factor).tolist()),
            ),
        ),
    )


def _lines(
    ends: tuple[float, float], largest_dps: float, unit: Unit, limit: Limit | None
) -> Iterator[Curve]:
    """Give the zero, and the limit of either sign where it does not press the points together."""
    yield Curve(x=ends, y=(0.0, 0.0), role=Role.GUIDE)
    if limit is None or limit.max is None:
        return
    allowed = limit.max.to("deg/s")
    if allowed <= _FAR * largest_dps:
        for sign, label in ((1.0, "limit"), (-1.0, "")):
            yield Curve(x=ends, y=(sign * allowed * unit.factor,) * 2, role=Role.LIMIT, label=label)
