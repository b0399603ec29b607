"""The figure: bias against temperature, the line through it, what the sensitivity says, and a table."""

from collections.abc import Iterator

import numpy as np

from gyrotest.analysis.interval import NORMAL_95
from gyrotest.analysis.temperature import TemperatureLine, TemperatureSensitivity
from gyrotest.procedures.bias_temperature_sensitivity.set_points import SetPoints
from gyrotest.procedures.wording import plain
from gyrotest.records.figure import Curve, Figure, Panel, Points, Role
from gyrotest.records.plan import Context
from gyrotest.records.table import Cell, Column, Table

_DPH = 3600.0
_MINUS = "\N{MINUS SIGN}"
_HIGHEST = 2.0  # how many times farther than the biases a limit's lines may reach and be drawn
_COLUMNS = (
    Column(heading="Set point / °C", share=15),
    Column(heading="Temperature / °C", share=17, numbers=True),
    Column(heading="Records", share=10, numbers=True),
    Column(heading="Bias / (°/h)", share=16, numbers=True),
    Column(heading="Change from room / (°/h)", share=22, numbers=True),
    Column(heading="Per °C / (°/h/°C)", share=18, numbers=True),
)


def temperature_figure(
    points: SetPoints, worst: TemperatureSensitivity, line: TemperatureLine, context: Context
) -> Figure:
    """Draw the bias of each record over its temperature."""
    order = np.argsort(points.record_degc, kind="stable")
    bars = NORMAL_95 * points.record_u_dps * _DPH
    panel = Panel(
        y_label="Bias / (°/h)",
        x_label="Temperature / °C",
        height=1.6,
        curves=tuple(_curves(points, worst, line, context)),
        points=(
            Points(
                x=tuple(points.record_degc[order].tolist()),
                y=tuple((points.record_bias_dps[order] * _DPH).tolist()),
                u=tuple(bars[order].tolist()),
            ),
        ),
    )
    low, high = (plain(float(one), 3) for one in _ends(points))
    return Figure(
        name="bias_over_temperature",
        title="Bias over temperature",
        panels=(panel,),
        note=f"{len(points.records)} records; temperatures: {points.reader.name}",
        caption="Points: mean bias of a record; bars: 95 %, by the record's own noise. Brown: line of least"
        " squares; dotted: the sensitivity, either way from the room temperature.",
        alt=f"Bias at temperatures from {low} to {high} °C, sensitivity"
        f" {plain(worst.value * _DPH, 3)} °/h/°C".replace("-", _MINUS),
        table=_table(points),
    )


def _ends(points: SetPoints) -> tuple[float, float]:
    return float(points.record_degc.min()), float(points.record_degc.max())


def _curves(
    points: SetPoints, worst: TemperatureSensitivity, line: TemperatureLine, context: Context
) -> Iterator[Curve]:
    low, high = _ends(points)
    room = float(points.temperature_degc[points.room])
    fitted = tuple((line.at_room + line.slope * (one - room)) * _DPH for one in (low, high))
    yield Curve(x=(low, high), y=fitted, role=Role.MODEL)
    yield from _cone(worst.value, points, Role.GUIDE)
    limit = context.case.limits.get("bias_temperature_sensitivity")
    if limit is not None and limit.max is not None:
        allowed = limit.max.to("deg/s/degC")
        if allowed <= _HIGHEST * worst.value:
            yield from _cone(allowed, points, Role.LIMIT, "limit")


def _cone(per_c: float, points: SetPoints, role: Role, label: str = "") -> Iterator[Curve]:
    """Give the lines from the room's point on which the bias changes so much a °C, up and down."""
    low, high = _ends(points)
    room, at_room = (float(one[points.room]) for one in (points.temperature_degc, points.bias_dps))
    x = (low, room, high)
    for sign in (1.0, -1.0):
        y = tuple((at_room + sign * per_c * abs(one - room)) * _DPH for one in x)
        yield Curve(x=x, y=y, role=role, label=label if sign > 0.0 else "")


def _table(points: SetPoints) -> Table:
    return Table(
        title="Set points",
        note="biases less the Earth's share" if points.share_dps is not None else "",
        columns=_COLUMNS,
        rows=tuple(_row(points, place) for place in range(points.set_degc.size)),
        sentences=(
            "Changes are rounded by their uncertainty from noise and from the bias's wander between the records.",
        ),
    )


def _row(points: SetPoints, place: int) -> tuple[Cell, ...]:
    room = points.room
    change = float(points.bias_dps[place] - points.bias_dps[room]) * _DPH
    distance_c = float(points.temperature_degc[place] - points.temperature_degc[room])
    half = NORMAL_95 * points.change_uncertainty_dps(place) * _DPH
    per_c = Cell(text="–") if place == room else _rounded(change / distance_c, half / abs(distance_c))
    own = NORMAL_95 * float(np.sqrt(points.covariance[place, place])) * _DPH
    return (
        Cell(text=_text(points.set_degc[place], 4)),
        Cell(text=_text(points.temperature_degc[place], 4)),
        Cell(text=str(points.visits(place))),
        _rounded(float(points.bias_dps[place]) * _DPH, own),
        Cell(text="–") if place == room else _rounded(change, half),
        per_c,
    )


def _text(value: float, digits: int) -> str:
    return plain(float(value), digits).replace("-", _MINUS)


def _rounded(value: float, half: float) -> Cell:
    return Cell(value=value, lower_95=value - half, upper_95=value + half)
