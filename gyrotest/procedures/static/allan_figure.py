"""The Allan plot: curve, band, fit with its components, read-offs, limits, datasheet; beneath it the terms."""

from collections.abc import Iterator, Mapping

import numpy as np

from gyrotest.analysis.allan import AllanDeviation
from gyrotest.procedures.allan_curves import (
    component_curves,
    confidence_band,
    deviation_curve,
    fitted_curve,
)
from gyrotest.procedures.drawn_units import Unit, rate_unit
from gyrotest.procedures.rest.record import RestRecord
from gyrotest.procedures.static.allan_lines import Lines, floor_walk
from gyrotest.procedures.static.noise_results import DPH, NoiseAnalysis, duty_note
from gyrotest.procedures.static.terms import ANGLE_WALK, TERMS
from gyrotest.procedures.static.terms_table import terms_table
from gyrotest.procedures.wording import plain
from gyrotest.records.figure import Curve, Figure, Mark, Panel, Role, Scale
from gyrotest.records.plan import Context
from gyrotest.records.result import Result

_HEIGHT, _TALL = 0.9, 1.25  # the lower one leaves room for the record above and the table beneath


def allan_figure(
    record: RestRecord, noise: NoiseAnalysis, results: tuple[Result, ...], context: Context
) -> Figure:
    """Draw the Allan deviation of a record, the table of its noise terms beneath it."""
    curve = noise.overlapping
    named = {one.name: one for one in results}
    rate = rate_unit(float(curve.deviation_dps.max()))
    highest = {name: one.max for name, one in context.case.limits.items() if one.max is not None}
    lines = Lines(
        noise=noise,
        rate=rate,
        folding=_folding(named),
        limits=highest,
        datasheet=context.datasheet,
    )
    panel = Panel(
        y_label=f"Allan deviation / ({rate.name})",
        x_label="Averaging time τ / s",
        x_scale=Scale.LOG,
        y_scale=Scale.LOG,
        height=_TALL
        if context.case.repeats == 1
        else _HEIGHT,  # a page a repeat, where there are several
        bands=(confidence_band(curve, per_dps=rate.factor),),
        curves=(
            *lines.floor(record),
            *lines.drawn(),
            _classic(noise.classic, rate),
            *(() if record.rounding else _fitted(noise, rate)),
            deviation_curve(curve, per_dps=rate.factor),
        ),
        marks=() if record.rounding else tuple(_marks(noise, rate, named)),
    )
    return Figure(
        name="allan_deviation",
        title="Allan deviation",
        panels=(panel,),
        note=", ".join(
            part for part in ("overlapping estimator, 68 % confidence band", duty_note(record)) if part
        ),
        caption=" ".join(_caption(record, lines)),
        alt=f"Allan deviation from {plain(float(curve.tau_s[0]), 4)} s to"
        f" {plain(float(curve.tau_s[-1]), 4)} s,"
        f" lowest {plain(float(curve.deviation_dps.min()) * DPH, 3)} °/h",
        table=None if record.rounding else terms_table(noise, named, context),
    )


def _folding(named: Mapping[str, Result]) -> float:
    """Return the factor by which white noise reads too large; 1 where it is not known."""
    as_read, corrected = named["angle_random_walk_apparent"].value, named["angle_random_walk"].value
    return as_read / corrected if as_read and corrected else 1.0


def _classic(curve: AllanDeviation, rate: Unit) -> Curve:
    return Curve(
        x=tuple(curve.tau_s.tolist()),
        y=tuple((curve.deviation_dps * rate.factor).tolist()),
        role=Role.MEAN,
    )


def _fitted(noise: NoiseAnalysis, rate: Unit) -> Iterator[Curve]:
    """Give the fitted curve and its components, but no component that the record does not resolve."""
    curve, model = noise.overlapping, noise.model
    resolved = {one.letter for one in TERMS if one.of(model).resolved}
    for component in component_curves(curve, model, per_dps=rate.factor):
        if component.label in resolved:
            yield component
    yield fitted_curve(curve, model, per_dps=rate.factor)


def _marks(noise: NoiseAnalysis, rate: Unit, named: Mapping[str, Result]) -> Iterator[Mark]:
    walk, lowest = noise.model.angle_random_walk, noise.minimum
    as_read = named["angle_random_walk_apparent"].value
    if walk.resolved and as_read is not None:
        first_s, last_s = float(noise.overlapping.tau_s[0]), float(noise.overlapping.tau_s[-1])
        tau_s = min(max(1.0, first_s), last_s)  # 1 s, or the averaging time next to it
        kind = "ARW" if as_read == named[ANGLE_WALK.name].value else "ARW as read"
        y = walk.value / float(np.sqrt(tau_s)) * rate.factor
        yield Mark(x=tau_s, y=y, label=f"{kind} {plain(as_read, 3)} °/√h")
    if lowest is not None:
        sign = "" if lowest.reached else "≤ "
        value = f"{sign}{plain(lowest.deviation_dps * DPH, 3)} °/h"
        label = f"minimum {value} at τ = {plain(lowest.tau_s, 3)} s"
        yield Mark(x=lowest.tau_s, y=lowest.deviation_dps * rate.factor, label=label)


def _caption(record: RestRecord, lines: Lines) -> Iterator[str]:
    yield "Heavy: overlapping estimator; thin: classic one."
    if not record.rounding:
        yield "Brown: fit and, thin, those of its terms that are resolved, by letter."
    roles = {one.role for one in lines.drawn()}
    if Role.LIMIT in roles:
        yield "Dashed: limits."
    if Role.DATASHEET in roles:
        yield "Dash-dotted: datasheet."
    if lines.folding != 1.0:
        yield (
            f"Dead time raises white noise {plain(lines.folding, 3)} times, in the curve and in the lines"
            " of the angle random walk."
        )
    walk = floor_walk(record)
    if walk is not None and lines.floor_is_far_below(record):
        yield f"The meter's own noise is far below: {plain(walk * DPH, 2)} °/h at 1 s."
    elif walk is not None:
        yield "Grey: the meter's own noise."
