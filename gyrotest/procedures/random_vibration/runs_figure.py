"""How the runs scatter: each run's estimates about the common curve, and 3σ of their curves."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gyrotest.analysis.frequency_response import Response
from gyrotest.analysis.interval import NORMAL_95
from gyrotest.analysis.response_curve import CurvePoints
from gyrotest.analysis.response_repeatability import ResponseRepeatability
from gyrotest.procedures.random_vibration.measurands import AMPLITUDE_REPEATABILITY, PHASE_REPEATABILITY
from gyrotest.procedures.random_vibration.measured import MeasuredResponse
from gyrotest.procedures.random_vibration.stretches import Bins, log_bins
from gyrotest.procedures.wording import plain
from gyrotest.records.figure import Band, Curve, Figure, Panel, Role, Scale, Width
from gyrotest.records.plan import Context

_LINES = 60
_HALF_TURN, _TURN = 180.0, 360.0
_Array = NDArray[np.float64]


def runs_figure(measured: MeasuredResponse) -> Figure:
    """Draw each run's estimates less the curve through all of them."""
    points = measured.curve.at(measured.curve.lines.frequency_hz)
    bins = log_bins(points.frequency_hz, _LINES)
    runs = [_deviation(run, points, bins) for run in measured.runs]
    most = max(float(np.abs(one.gain).max()) for one in runs)
    return Figure(
        name="runs",
        title="Runs about the curve",
        panels=(
            _deviation_panel("Sensitivity / %", [one.gain for one in runs], _gain_half(points), bins),
            _deviation_panel(
                "Phase / °", [one.phase for one in runs], NORMAL_95 * points.phase_uncertainty_deg, bins
            ),
        ),
        caption="Estimates of each run, means of neighbouring frequencies, less the curve through all of them;"
        " shaded: 95 % band of the curve by random error and fit.",
        alt=f"Deviations of {len(runs)} runs from the curve, {plain(most, 2)} % at most",
    )


@dataclass(frozen=True, slots=True, kw_only=True)
class _Deviation:
    """A run's estimates less the curve, of groups of lines: gain in %, phase in °."""

    gain: _Array
    phase: _Array


def _deviation(run: Response, points: CurvePoints, bins: Bins) -> _Deviation:
    """Compare a run where the curve has lines."""
    used = np.isin(run.frequency_hz, points.frequency_hz)
    turned = (run.phase_deg[used] - points.phase_deg + _HALF_TURN) % _TURN - _HALF_TURN
    gain = 100.0 * (run.gain[used] / points.gain - 1.0)
    return _Deviation(gain=bins.means(gain), phase=bins.means(turned))


def _gain_half(points: CurvePoints) -> _Array:
    half: _Array = 100.0 * NORMAL_95 * points.gain_uncertainty / points.gain
    return half


def _deviation_panel(y_label: str, runs: list[_Array], half: _Array, bins: Bins) -> Panel:
    x, shown = _drawn(bins.frequency_hz), bins.means(half)
    return Panel(
        y_label=y_label,
        x_label="Frequency / Hz",
        x_scale=Scale.LOG,
        bands=(Band(x=x, lower=_drawn(-shown), upper=_drawn(shown)),),
        curves=tuple(
            Curve(x=x, y=_drawn(y), label=f"run {number + 1}", series=number)
            for number, y in enumerate(runs)
        ),
        legend=True,
    )


def spread_figure(measured: MeasuredResponse, context: Context) -> tuple[Figure, ...]:
    """Draw three standard deviations of the runs' curves, with limits; nothing of a single run."""
    found = measured.repeatability
    if found is None:
        return ()
    return (
        Figure(
            name="repeatability",
            title="Repeatability",
            width=Width.HALF,
            panels=(
                _spread_panel(
                    "3σ / %",
                    "",
                    found,
                    found.amplitude_percent,
                    _limit(context, AMPLITUDE_REPEATABILITY, "%"),
                ),
                _spread_panel(
                    "3σ / °",
                    "Frequency / Hz",
                    found,
                    found.phase_deg,
                    _limit(context, PHASE_REPEATABILITY, "deg"),
                ),
            ),
            note=f"{found.runs} runs",
            caption="Three standard deviations of the runs' curves, of sensitivity (top) and phase (bottom);"
            " dashed: limits.",
            alt=f"3σ over frequency, at most {plain(found.amplitude.value, 2)} % and"
            f" {plain(found.phase.value, 2)}°",
        ),
    )


def _limit(context: Context, name: str, unit: str) -> float | None:
    limit = context.case.limits.get(name)
    return None if limit is None or limit.max is None else limit.max.to(unit)


def _spread_panel(
    y_label: str, x_label: str, found: ResponseRepeatability, values: _Array, limit: float | None
) -> Panel:
    x = found.frequency_hz
    ends = (float(x[0]), float(x[-1]))
    limits = () if limit is None else (Curve(x=ends, y=(limit, limit), role=Role.LIMIT, label="limit"),)
    return Panel(
        y_label=y_label,
        x_label=x_label,
        x_scale=Scale.LOG,
        curves=(
            Curve(x=_drawn(x), y=_drawn(values)),
            Curve(x=ends, y=(0.0, 0.0), role=Role.GUIDE),
            *limits,
        ),
    )


def _drawn(values: _Array) -> tuple[float, ...]:
    return tuple(values.tolist())
