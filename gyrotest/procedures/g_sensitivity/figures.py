"""Figures of one mounting: drift and what the model leaves over the angle, drift over time before and after."""

import math
from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from gyrotest.analysis.drift_spread import averages
from gyrotest.analysis.g_sensitivity import Term
from gyrotest.analysis.interval import NORMAL_95
from gyrotest.analysis.level_shaft import Circle, specific_force_g
from gyrotest.procedures.drawn_units import Unit, rate_unit, time_unit
from gyrotest.procedures.g_sensitivity.mounting_record import MountingRecord
from gyrotest.procedures.g_sensitivity.mounting_results import MountingResults, averaged_s
from gyrotest.procedures.wording import plain
from gyrotest.records.figure import Curve, Figure, Panel, Points, Role

_Array = NDArray[np.float64]
_DRAWN = 121
_HAIR_DEG = 1.0
_WAYS = ((1, "forward"), (0, "back"), (-1, "at rest"))


def mounting_figures(found: MountingRecord, results: MountingResults) -> tuple[Figure, ...]:
    """Return the figures, in the order of the certificate."""
    unit = rate_unit(float(np.abs(found.found.drift).max()))
    return (_angle_figure(found, unit), _time_figure(found, results, unit))


def _angle_figure(found: MountingRecord, unit: Unit) -> Figure:
    drift, left = found.found.drift * unit.factor, found.found.fit.residuals * unit.factor
    covariance = found.found.fit.noise_covariance * unit.factor**2
    turning = found.found.arcs.turns
    what = f"all turns, {plain(found.span_s, 2)} s each" if turning else "each position"
    angles = np.linspace(0.0, 360.0, _DRAWN)
    return Figure(
        name="drift_over_angle",
        title=f"Drift over the angle of the shaft, {found.mounted.words}",
        panels=(
            Panel(
                y_label=f"Drift / ({unit.name})",
                curves=(
                    Curve(
                        x=_drawn(angles), y=_drawn(_model(found, angles) * unit.factor), role=Role.MODEL
                    ),
                ),
                points=tuple(_points(found, drift, None)),
                height=1.4,
            ),
            Panel(
                y_label=f"Residual / ({unit.name})",
                x_label="Angle of the shaft / °",
                curves=(Curve(x=(0.0, 360.0), y=(0.0, 0.0), role=Role.GUIDE),),
                points=tuple(_points(found, left, covariance)),
            ),
        ),
        caption=f"Top: output less bias, Earth's rate and what follows the turning, means over {what}; line: the"
        " fitted drift by gravity. Bottom: what the fit leaves; bars: 95 % of the noise of each mean.",
        alt=f"Drift of {plain(float(np.ptp(drift)), 3)} {unit.name} from least to greatest over a turn of the"
        f" shaft, residuals of {plain(float(left.std()), 3)} {unit.name} (one standard deviation)",
    )


def _model(found: MountingRecord, angles: _Array) -> _Array:
    force = specific_force_g(found.mounted.pose, Circle.of(angles))
    coefficients = found.found.coefficients
    model: _Array = coefficients[Term.ALONG_X] * force[:, 0] + coefficients[Term.ALONG_Z] * force[:, 2]
    return model


def _points(found: MountingRecord, values: _Array, covariance: _Array | None) -> Iterator[Points]:
    """Give the means over all turns of a direction, span by span, and over all that was taken at rest."""
    step = found.record.step
    forward = np.array([-1 if one.forward is None else int(one.forward) for one in found.steps])[step]
    starts = np.flatnonzero(np.diff(step, prepend=-1))
    within = np.arange(step.size) - np.repeat(starts, np.diff(np.append(starts, step.size)))
    for series, (way, label) in enumerate(_WAYS):
        chosen = np.flatnonzero(forward == way)
        if chosen.size:
            at_rest = np.round(found.record.angle_deg[chosen]) % 360.0
            key = at_rest if way < 0 else within[chosen]
            yield _grouped(found, values, covariance, chosen, key, label=label, series=series)


def _grouped(
    found: MountingRecord,
    values: _Array,
    covariance: _Array | None,
    chosen: NDArray[np.intp],
    key: NDArray[np.float64] | NDArray[np.intp],
    *,
    label: str,
    series: int,
) -> Points:
    groups, inverse = np.unique(key, return_inverse=True)
    gather = np.zeros((groups.size, values.size))
    gather[inverse, chosen] = 1.0
    gather /= gather.sum(axis=1, keepdims=True)
    circle = found.record.arcs.circle
    angles = np.degrees(np.arctan2(gather @ circle.sine, gather @ circle.cosine))
    bars: tuple[float, ...] = ()
    if covariance is not None:
        # Less what all have in common, which the bias takes up.
        apart = gather - 1.0 / values.size
        bars = _drawn(NORMAL_95 * np.sqrt(np.maximum(np.sum(apart @ covariance * apart, axis=1), 0.0)))
    # An angle at rest at 0 may be read as a hair less.
    return Points(
        x=_drawn((angles + _HAIR_DEG) % 360.0 - _HAIR_DEG),
        y=_drawn(gather @ values),
        u=bars,
        label=label,
        series=series,
    )


def _time_figure(found: MountingRecord, results: MountingResults, unit: Unit) -> Figure:
    spans = found.record.arcs.spans
    middle = averages(spans.begins_s + spans.durations_s / 2.0, results.groups)
    before = averages(found.found.drift, results.groups) * unit.factor
    after = averages(found.found.fit.residuals, results.groups) * unit.factor
    time = time_unit(float(middle[-1] - middle[0]))
    at = _drawn((middle - spans.begins_s[0]) * time.factor)
    deviations = [one * unit.factor for one in (results.before.deviation, results.after.deviation)]
    return Figure(
        name="compensation",
        title="Drift before and after compensation",
        panels=(
            Panel(
                y_label=f"Drift / ({unit.name})",
                x_label=f"Time / {time.name}",
                curves=(
                    Curve(x=at, y=_drawn(before), label="before", series=0),
                    Curve(x=at, y=_drawn(after), label="after", series=1),
                ),
                legend=True,
            ),
        ),
        caption=f"Averages over {plain(averaged_s(found), 3)} s of the output less bias, Earth's rate and what"
        f" follows the turning, before and after the fitted drift by gravity is taken off: standard deviation"
        f" {plain(deviations[0], 3)} and {plain(deviations[1], 3)} {unit.name}.",
        alt=f"Drift over time with a standard deviation of {plain(deviations[0], 3)} {unit.name} before and"
        f" {plain(deviations[1], 3)} {unit.name} after compensation",
    )


def _drawn(values: _Array) -> tuple[float, ...]:
    if not math.isfinite(float(np.sum(values))):
        raise ValueError("a figure's values are finite")
    return tuple(values.tolist())
