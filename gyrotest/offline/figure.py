"""The Allan plot of analyses: one with its fit and read-offs, several over one another with a legend."""

from collections.abc import Iterator, Sequence

import numpy as np

from gyrotest.offline.analysis import Analysis
from gyrotest.offline.readings import Reading, readings
from gyrotest.offline.titles import titles
from gyrotest.procedures.allan_curves import (
    component_curves,
    confidence_band,
    deviation_curve,
    fitted_curve,
)
from gyrotest.procedures.drawn_units import Unit, rate_unit
from gyrotest.procedures.static.terms import ANGLE_WALK, TERMS, Term
from gyrotest.procedures.wording import plain
from gyrotest.records.figure import Curve, Figure, Mark, Panel, Role, Scale
from gyrotest.units import Quantity, printed_unit

_LETTERS = {ANGLE_WALK: "ARW"}
_DRAWN = "overlapping estimator, 68 % confidence"
_ABOVE, _BELOW = 2.0, 0.5  # of the curves' highest and lowest point: no line of a datasheet goes further


def allan_plot(analyses: Sequence[Analysis]) -> Figure:
    """Draw one or several records' Allan deviations."""
    highest = max(float(one.curve.deviation_dps.max()) for one in analyses)
    rate = rate_unit(highest)
    single = len(analyses) == 1
    panel = Panel(
        y_label=f"Allan deviation / ({rate.name})",
        x_label="Averaging time τ / s",
        x_scale=Scale.LOG,
        y_scale=Scale.LOG,
        bands=tuple(
            confidence_band(one.curve, per_dps=rate.factor, series=place)
            for place, one in enumerate(analyses)
        ),
        curves=(
            *_datasheet(analyses, rate),
            *(_fitted(analyses[0], rate) if single else ()),
            *(
                deviation_curve(
                    one.curve, per_dps=rate.factor, series=place, label="" if single else name
                )
                for place, (one, name) in enumerate(zip(analyses, titles(analyses), strict=True))
            ),
        ),
        marks=tuple(_marks(analyses[0], rate)) if single else (),
        note=f"{titles(analyses)[0]}: {_DRAWN}" if single else _DRAWN,
        legend=not single,
    )
    return Figure(
        name="allan_deviation",
        title="Allan deviation",
        panels=(panel,),
        alt=f"Allan deviation of {', '.join(titles(analyses))}",
    )


def _fitted(analysis: Analysis, rate: Unit) -> Iterator[Curve]:
    yield from component_curves(analysis.curve, analysis.model, per_dps=rate.factor)
    yield fitted_curve(analysis.curve, analysis.model, per_dps=rate.factor)


def _marks(analysis: Analysis, rate: Unit) -> Iterator[Mark]:
    named = {one.name: one for one in readings(analysis)}
    walk = analysis.model.angle_random_walk
    tau_s = analysis.curve.tau_s
    if walk.resolved:
        at_s = min(max(1.0, float(tau_s[0])), float(tau_s[-1]))
        read = named.get("angle_random_walk_apparent", named["angle_random_walk"])
        kind = "ARW as read" if "angle_random_walk_apparent" in named else "ARW"
        yield Mark(x=at_s, y=walk.value / at_s**0.5 * rate.factor, label=f"{kind} {_value(read)}")
    if analysis.minimum is not None:
        lowest = analysis.minimum
        text = f"minimum {_value(named['allan_minimum'])} at τ = {plain(lowest.tau_s, 3)} s"
        yield Mark(x=lowest.tau_s, y=lowest.deviation_dps * rate.factor, label=text)


def _value(reading: Reading) -> str:
    sign = "≤ " if reading.at_most else ""
    return f"{sign}{plain(reading.value or 0.0, 3)} {printed_unit(reading.unit)}"


def _datasheet(analyses: Sequence[Analysis], rate: Unit) -> Iterator[Curve]:
    """Draw the datasheet's figures, where they are near the curves."""
    stated = analyses[0].datasheet
    first_s = min(float(one.curve.tau_s[0]) for one in analyses)
    last_s = max(float(one.curve.tau_s[-1]) for one in analyses)
    if "allan_minimum" in stated:
        y = stated["allan_minimum"].to("deg/s") * rate.factor
        text = f"datasheet minimum {_written(stated['allan_minimum'])}"
        yield Curve(x=(first_s, last_s), y=(y, y), role=Role.DATASHEET, label=text)
    for term in TERMS:
        if term.name in stated:
            yield from _sloped(analyses, term, stated[term.name], rate)


def _sloped(analyses: Sequence[Analysis], term: Term, stated: Quantity, rate: Unit) -> Iterator[Curve]:
    tau_s = np.unique(np.concatenate([one.curve.tau_s for one in analyses]))
    line = stated.to(term.dimension.value) * term.at_1_s * tau_s**term.slope
    highest = max(float(one.curve.deviation_dps.max()) for one in analyses)
    lowest = min(float(one.curve.deviation_dps.min()) for one in analyses)
    shown = np.flatnonzero((line <= _ABOVE * highest) & (line >= _BELOW * lowest))
    if shown.size > 1:
        ends = shown[[0, -1]]
        yield Curve(
            x=tuple(tau_s[ends].tolist()),
            y=tuple((line[ends] * rate.factor).tolist()),
            role=Role.DATASHEET,
            label=f"datasheet {_LETTERS.get(term, term.letter)} {_written(stated)}",
        )


def _written(quantity: Quantity) -> str:
    return f"{plain(quantity.value, 6)} {printed_unit(quantity.unit)}"
