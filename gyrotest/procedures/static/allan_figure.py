"""The Allan plot: the curve with its band, guides through the read-offs, floor, limits, datasheet."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gyrotest.analysis.allan import FLAT
from gyrotest.procedures.static.noise_results import (
    DPH,
    PER_ROOT_HOUR,
    NoiseAnalysis,
    duty_note,
    find_minimum,
)
from gyrotest.procedures.static.record import StaticRecord
from gyrotest.procedures.static.time_figures import Unit, rate_unit
from gyrotest.procedures.static.wording import plain
from gyrotest.records.figure import Band, Curve, Figure, Mark, Panel, Role, Scale
from gyrotest.records.plan import Context
from gyrotest.records.result import Result
from gyrotest.units import Quantity, printed_unit

_GUIDE_DECADES = 1.0


@dataclass(frozen=True, slots=True, kw_only=True)
class _Axes:
    """The averaging times drawn, the unit of the deviations, and by how much dead time raises them."""

    first_s: float
    last_s: float
    rate: Unit
    folding: float

    def line(self, walk_dps: float, first_s: float, last_s: float, role: Role, label: str = "") -> Curve:
        """Draw slope −1/2 through `walk_dps` at 1 s."""
        x = (max(first_s, self.first_s), min(last_s, self.last_s))
        y = tuple(walk_dps / float(np.sqrt(tau)) * self.rate.factor for tau in x)
        return Curve(x=x, y=y, role=role, label=label)

    def level(self, deviation_dps: float, role: Role, label: str = "") -> Curve:
        """Draw slope 0."""
        return Curve(
            x=(self.first_s, self.last_s),
            y=(deviation_dps * self.rate.factor,) * 2,
            role=role,
            label=label,
        )


def allan_figure(
    record: StaticRecord, noise: NoiseAnalysis, results: tuple[Result, ...], context: Context
) -> Figure:
    """Draw the Allan deviation of a record."""
    curve = noise.overlapping
    rate = rate_unit(float(curve.deviation_dps.max()))
    named = {one.name: one for one in results}
    axes = _Axes(
        first_s=float(curve.tau_s[0]),
        last_s=float(curve.tau_s[-1]),
        rate=rate,
        folding=_folding(named["angle_random_walk_apparent"], named["angle_random_walk"]),
    )
    x = tuple(curve.tau_s.tolist())
    panel = Panel(
        y_label=f"Allan deviation / ({rate.name})",
        x_label="Averaging time τ / s",
        x_scale=Scale.LOG,
        y_scale=Scale.LOG,
        bands=(Band(x=x, lower=_drawn(curve.lower_dps, rate), upper=_drawn(curve.upper_dps, rate)),),
        curves=(
            *_floor(record, axes),
            *_limits(axes, noise, context),
            *_datasheet(axes, context.datasheet),
            *(() if record.rounding else _guides(axes, noise)),
            Curve(
                x=tuple(noise.classic.tau_s.tolist()),
                y=_drawn(noise.classic.deviation_dps, rate),
                role=Role.MEAN,
                label="classic",
            ),
            Curve(x=x, y=_drawn(curve.deviation_dps, rate), role=Role.DATA),
        ),
        marks=() if record.rounding else tuple(_marks(axes, noise, named)),
    )
    return Figure(
        name="allan_deviation",
        title="Allan deviation",
        panels=(panel,),
        note=_joined("overlapping estimator, 68 % confidence band", duty_note(record)),
        caption=_caption(record, axes, context),
        alt=f"Allan deviation from {plain(axes.first_s, 4)} s to {plain(axes.last_s, 4)} s,"
        f" lowest {plain(float(curve.deviation_dps.min()) * DPH, 3)} °/h",
    )


def _folding(as_read: Result, corrected: Result) -> float:
    """Return the factor by which white noise reads too large; 1 where it is not known."""
    if not as_read.value or not corrected.value:
        return 1.0
    return as_read.value / corrected.value


def _joined(*parts: str) -> str:
    return ", ".join(part for part in parts if part)


def _caption(record: StaticRecord, axes: _Axes, context: Context) -> str:
    sentences = [
        "Heavy line: overlapping estimator; thin line: classic one, of groups side by side.",
        "Dotted: slopes −1/2 and 0 through the read-offs.",
    ]
    if set(context.case.limits) & {"allan_minimum", "bias_instability_coefficient", "angle_random_walk"}:
        sentences.append("Dashed: limits.")
    if set(context.datasheet) & {"allan_minimum", "bias_instability_coefficient", "angle_random_walk"}:
        sentences.append("Dash-dotted: datasheet.")
    if axes.folding != 1.0:
        sentences.append(
            "Dead time raises white noise in the curve, and the lines of the angle random walk with it,"
            f" {plain(axes.folding, 3)} times."
        )
    if record.floor_dps:
        sentences.append("Grey: the meter's own noise.")
    return " ".join(sentences)


def _floor(record: StaticRecord, axes: _Axes) -> Iterator[Curve]:
    """Give the meter's own white noise, where it is known."""
    if record.floor_dps:
        walk = record.floor_dps * float(np.sqrt(record.interval_s))
        yield axes.line(walk, axes.first_s, axes.last_s, Role.FLOOR, "meter's own noise")


def _guides(axes: _Axes, noise: NoiseAnalysis) -> Iterator[Curve]:
    walk = noise.model.angle_random_walk
    if walk.resolved:
        read_s = _read_off_s(axes)
        reach = 10.0**_GUIDE_DECADES
        yield axes.line(walk.value, read_s / reach, read_s * reach, Role.GUIDE, "slope −1/2")
    minimum = find_minimum(noise)
    if minimum is not None:
        yield axes.level(minimum.spread_dps.value, Role.GUIDE)


def _read_off_s(axes: _Axes) -> float:
    """Return 1 s, or the averaging time next to it."""
    return min(max(1.0, axes.first_s), axes.last_s)


def _marks(axes: _Axes, noise: NoiseAnalysis, named: Mapping[str, Result]) -> Iterator[Mark]:
    walk = named["angle_random_walk_apparent"]
    if noise.model.angle_random_walk.resolved and walk.value is not None:
        tau_s = _read_off_s(axes)
        y = noise.model.angle_random_walk.value / float(np.sqrt(tau_s)) * axes.rate.factor
        kind = "ARW" if _same(walk, named["angle_random_walk"]) else "ARW as read"
        yield Mark(x=tau_s, y=y, label=f"{kind} {plain(walk.value, 3)} °/√h")
    minimum = find_minimum(noise)
    if minimum is not None:
        value = minimum.spread_dps.value
        sign = "" if minimum.reached else "≤ "
        label = f"minimum {sign}{plain(value * DPH, 3)} °/h at τ = {plain(minimum.tau_s, 3)} s"
        yield Mark(x=minimum.tau_s, y=value * axes.rate.factor, label=label)


def _same(one: Result, other: Result) -> bool:
    return one.value == other.value


def _limits(axes: _Axes, noise: NoiseAnalysis, context: Context) -> Iterator[Curve]:
    limits = context.case.limits
    for name, folding in (("angle_random_walk", axes.folding), ("angle_random_walk_apparent", 1.0)):
        if name in limits and limits[name].max is not None:
            end_s = _white_until_s(noise)
            yield from _walk_line(
                axes, limits[name].max, end_s, Role.LIMIT, "limit ARW", folding=folding
            )
            break
    for name, factor, label in _LEVELS:
        if name in limits and limits[name].max is not None:
            yield from _level_line(axes, limits[name].max, factor, Role.LIMIT, f"limit {label}")


_LEVELS = (
    ("allan_minimum", 1.0, "minimum"),
    ("bias_instability_coefficient", FLAT, "coefficient × 0.664"),
)


def _datasheet(axes: _Axes, datasheet: Mapping[str, Quantity]) -> Iterator[Curve]:
    yield from _walk_line(
        axes,
        datasheet.get("angle_random_walk"),
        axes.last_s,
        Role.DATASHEET,
        "datasheet ARW",
        folding=axes.folding,
    )
    for name, factor, label in _LEVELS:
        yield from _level_line(axes, datasheet.get(name), factor, Role.DATASHEET, f"datasheet {label}")


def _walk_line(
    axes: _Axes, walk: Quantity | None, last_s: float, role: Role, label: str, *, folding: float
) -> Iterator[Curve]:
    if walk is not None:
        value = folding * walk.to("deg/sqrt(h)") / PER_ROOT_HOUR
        text = f"{label} {_written(walk)}"
        yield axes.line(value, axes.first_s, last_s, role, text)


def _level_line(
    axes: _Axes, level: Quantity | None, factor: float, role: Role, label: str
) -> Iterator[Curve]:
    if level is not None:
        yield axes.level(level.to("deg/s") * factor, role, f"{label} {_written(level)}")


def _written(quantity: Quantity) -> str:
    return f"{plain(quantity.value, 6)} {printed_unit(quantity.unit)}"


def _white_until_s(noise: NoiseAnalysis) -> float:
    """Return the averaging time at which flicker noise takes over, at least a decade of times."""
    walk = noise.model.angle_random_walk.value
    bias = noise.model.bias_instability_coefficient.value
    first = float(noise.overlapping.tau_s[0])
    crossing = (walk / (FLAT * bias)) ** 2 if bias > 0.0 else float(noise.overlapping.tau_s[-1])
    return max(crossing, 10.0 * first)


def _drawn(values: NDArray[np.float64], rate: Unit) -> tuple[float, ...]:
    return tuple((values * rate.factor).tolist())
