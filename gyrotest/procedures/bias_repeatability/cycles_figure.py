"""The figure: the bias of each power cycle with its uncertainty, their mean, and the spread about it."""

from collections.abc import Iterator

from gyrotest.analysis.repeatability import Repeatability
from gyrotest.procedures.drawn_units import rate_unit
from gyrotest.procedures.wording import plain
from gyrotest.records.figure import Curve, Figure, Panel, Points, Role
from gyrotest.records.plan import Context
from gyrotest.records.result import Result
from gyrotest.units import conversion_factor

_MINUS = "\N{MINUS SIGN}"
_NEAR = 1.0  # how many times the span of the points a limit may lie beyond them and be drawn
_SIDE = 0.5


def cycles_figure(found: tuple[Result, ...], spread: Repeatability, context: Context) -> Figure:
    """Draw the bias of each power cycle; `spread` is that of the biases in °/s."""
    values = [(one.value or 0.0) * conversion_factor(one.unit, "deg/s") for one in found]
    bars = [(one.expanded_uncertainty or 0.0) * conversion_factor(one.unit, "deg/s") for one in found]
    unit = rate_unit(max(abs(one) for one in values))
    cycles = tuple(float(number) for number in range(1, spread.count + 1))
    ends = (cycles[0] - _SIDE, cycles[-1] + _SIDE)
    points = Points(
        x=cycles,
        y=tuple(one * unit.factor for one in values),
        u=tuple(one * unit.factor for one in bars) if any(bars) else (),
    )
    levels = [
        (spread.mean, Role.MEAN, "mean"),
        (spread.mean + spread.deviation, Role.GUIDE, "+s"),
        (spread.mean - spread.deviation, Role.GUIDE, f"{_MINUS}s"),
        *_limits(values, context),
    ]
    curves = tuple(
        Curve(x=ends, y=(level * unit.factor,) * 2, role=role, label=label)
        for level, role, label in levels
    )
    mean, deviation = (plain(one * unit.factor, 5) for one in (spread.mean, spread.deviation))
    return Figure(
        name="bias_per_power_cycle",
        title="Bias per power cycle",
        panels=(
            Panel(
                y_label=f"Bias / ({unit.name})",
                x_label="Power cycle",
                height=1.2,
                curves=curves,
                points=(points,),
            ),
        ),
        note=f"{spread.count} power cycles, mean {mean} {unit.name}, s = {deviation} {unit.name}".replace(
            "-", _MINUS
        ),
        caption=_caption(bars=any(bars)),
        alt=f"Bias of {spread.count} power cycles from {plain(min(values), 4)} to"
        f" {plain(max(values), 4)} °/s, standard deviation {plain(spread.deviation, 4)} °/s",
    )


def _limits(values: list[float], context: Context) -> Iterator[tuple[float, Role, str]]:
    """Give the limits on the bias that lie near enough not to press the points together."""
    low, high = min(values), max(values)
    reach = _NEAR * (high - low)
    limit = context.case.limits.get("bias")
    for end in () if limit is None else (limit.min, limit.max):
        if end is not None and low - reach <= end.to("deg/s") <= high + reach:
            yield end.to("deg/s"), Role.LIMIT, "limit"


def _caption(*, bars: bool) -> str:
    told = "bars: its expanded uncertainty, much of which is common to all cycles; " if bars else ""
    return f"Points: bias after each power-on; {told}line: mean; dotted: mean ± s."
