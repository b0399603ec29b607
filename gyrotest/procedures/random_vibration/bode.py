"""The response over frequency: sensitivity in dB and phase, with limits, and a table of what is reported."""

import math
from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from gyrotest.analysis.interval import NORMAL_95
from gyrotest.analysis.response_curve import CurvePoints, bandwidth, quarter_turn
from gyrotest.errors import InsufficientDataError
from gyrotest.procedures.random_vibration.least_coherence import coherence_text
from gyrotest.procedures.random_vibration.measured import MeasuredResponse
from gyrotest.procedures.random_vibration.parameters import RandomVibrationParameters
from gyrotest.procedures.random_vibration.pointwise import phase_result, scale_in, sensitivity_result
from gyrotest.procedures.random_vibration.stretches import log_bins, stretches_of
from gyrotest.procedures.vibration_names import SENSITIVITY_UNITS, phase_name, sensitivity_name
from gyrotest.procedures.wording import plain
from gyrotest.records.figure import Band, Curve, Figure, Mark, Panel, Role, Scale
from gyrotest.records.plan import Context
from gyrotest.records.result import Result
from gyrotest.records.table import Cell, Column, Table
from gyrotest.units import printed_unit

_POINTS, _LINES = 161, 240
_BESIDE = 1.06  # how far a limit at a frequency is drawn to either side of it
_BEYOND = 0.2
_DB = 20.0 / math.log(10.0)
_THREE_DB = -3.0103
_NEAR_QUARTER = -60.0
_MINUS = "\N{MINUS SIGN}"

_Array = NDArray[np.float64]


def bode_figure(measured: MeasuredResponse, context: Context) -> Figure:
    """Draw estimates, the curve through them with its 95 % band, limits, −3 dB and −90°."""
    parameters: RandomVibrationParameters = context.parameters
    grid = np.geomspace(measured.curve.low_hz, measured.curve.high_hz, _POINTS)
    points, reference = measured.curve.at(grid), _reference(measured, parameters)
    unit = SENSITIVITY_UNITS[context.output.kind]
    zero_db = abs(reference * scale_in(measured, unit))
    runs = len(measured.runs)
    return Figure(
        name="bode",
        title="Frequency response",
        panels=(
            _gain_panel(measured, points, reference, zero_db, context),
            _phase_panel(measured, points, context),
        ),
        note=f"0 dB: {plain(zero_db, 5)} {printed_unit(unit)}".strip()
        + f" at {plain(parameters.reference_hz, 6)} Hz",
        caption=f"Sensitivity and phase by random vibration, {runs} run{'s' * (runs > 1)} together,"
        f" {measured.segments} segments of {plain(measured.response.segment_s, 4)} s that overlap by half. Line:"
        f" estimate at each frequency (Hv); over it the polynomial of degree {parameters.degree} with its 95 %"
        " band by random error and fit; dashed: limits."
        + (" Grey: coherence too low, left out." if measured.curve.excluded_hz.size else ""),
        alt=f"Bode plot from {plain(measured.curve.low_hz, 6)} to {plain(measured.curve.high_hz, 6)} Hz",
        table=_table(measured, context, unit) if parameters.frequencies else None,
    )


def _reference(measured: MeasuredResponse, parameters: RandomVibrationParameters) -> float:
    """Return the gain at the reference frequency, or where the curve is nearest to it."""
    nearest = np.clip(parameters.reference_hz, measured.curve.low_hz, measured.curve.high_hz)
    return float(measured.curve.at(np.array([nearest])).gain[0])


def _gain_panel(
    measured: MeasuredResponse,
    points: CurvePoints,
    reference: float,
    zero_db: float,
    context: Context,
) -> Panel:
    level = _DB * np.log(points.gain / reference)
    half = _DB * NORMAL_95 * points.gain_uncertainty / points.gain
    lines = _DB * np.log(measured.response.gain / reference)
    marks = tuple(_three_db_mark(measured, context))
    return Panel(
        y_label="Sensitivity / dB",
        x_scale=Scale.LOG,
        height=1.25,
        bands=(_band(points, level, half),),
        curves=(
            *_estimates(measured, lines),
            Curve(x=_drawn(points.frequency_hz), y=_drawn(level), role=Role.MODEL),
            _level(measured, _THREE_DB, label="" if marks else f"{_MINUS}3 dB"),
            *_gain_limits(zero_db, context),
        ),
        marks=marks,
    )


def _phase_panel(measured: MeasuredResponse, points: CurvePoints, context: Context) -> Panel:
    phase = points.phase_deg
    near = bool(phase.min() < _NEAR_QUARTER)
    return Panel(
        y_label="Phase / °",
        x_label="Frequency / Hz",
        x_scale=Scale.LOG,
        height=1.25,
        bands=(_band(points, phase, NORMAL_95 * points.phase_uncertainty_deg),),
        curves=(
            *_estimates(measured, np.degrees(np.unwrap(np.radians(measured.response.phase_deg)))),
            Curve(x=_drawn(points.frequency_hz), y=_drawn(phase), role=Role.MODEL),
            *((_level(measured, -90.0),) if near else ()),
            *_phase_limits(context),
        ),
        marks=tuple(_quarter_mark(measured)),
    )


def _band(points: CurvePoints, middle: _Array, half: _Array) -> Band:
    return Band(x=_drawn(points.frequency_hz), lower=_drawn(middle - half), upper=_drawn(middle + half))


def _estimates(measured: MeasuredResponse, values: _Array) -> Iterator[Curve]:
    """Draw the lines that count, in stretches, and those that are left out in grey."""
    frequency_hz, spacing_hz = measured.response.frequency_hz, 1.0 / measured.response.segment_s
    out = np.isin(frequency_hz, measured.curve.excluded_hz)
    for chosen, role in ((~out, Role.DATA), (out, Role.FLOOR)):
        for stretch in stretches_of(frequency_hz[chosen], spacing_hz):
            there = np.isin(frequency_hz, stretch)
            if role is Role.FLOOR:
                there = _widened(there)
            bins = log_bins(frequency_hz[there], _LINES)
            y = np.clip(bins.means(values[there]), *_frame(values[~out]))
            yield Curve(x=_drawn(bins.frequency_hz), y=_drawn(y), role=role)


def _frame(values: _Array) -> tuple[float, float]:
    """Return how far a panel reaches: what is left out must not press the rest together."""
    low, high = float(values.min()), float(values.max())
    margin = _BEYOND * (high - low)
    return low - margin, high + margin


def _widened(there: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Take a neighbour to either side along, so that a single line is seen."""
    wide = there.copy()
    wide[:-1] |= there[1:]
    wide[1:] |= there[:-1]
    return wide


def _level(measured: MeasuredResponse, value: float, *, label: str = "") -> Curve:
    ends = (measured.curve.low_hz, measured.curve.high_hz)
    return Curve(x=ends, y=(value, value), role=Role.GUIDE, label=label)


def _gain_limits(zero_db: float, context: Context) -> Iterator[Curve]:
    """Draw limits of single sensitivities, in dB; their sign is judged, not drawn."""
    parameters: RandomVibrationParameters = context.parameters
    unit = SENSITIVITY_UNITS[context.output.kind]
    for frequency_hz in parameters.reported_hz:
        limit = context.case.limits.get(sensitivity_name(frequency_hz))
        for end in () if limit is None else (limit.min, limit.max):
            size = 0.0 if end is None else abs(end.to(unit))
            if size > 0.0:
                yield _short(frequency_hz, 20.0 * math.log10(size / zero_db))


def _phase_limits(context: Context) -> Iterator[Curve]:
    parameters: RandomVibrationParameters = context.parameters
    for frequency_hz in parameters.reported_hz:
        limit = context.case.limits.get(phase_name(frequency_hz))
        for end in () if limit is None else (limit.min, limit.max):
            if end is not None:
                yield _short(frequency_hz, end.to("deg"))


def _short(frequency_hz: float, value: float) -> Curve:
    ends = (frequency_hz / _BESIDE, frequency_hz * _BESIDE)
    return Curve(x=ends, y=(value, value), role=Role.LIMIT)


def _three_db_mark(measured: MeasuredResponse, context: Context) -> Iterator[Mark]:
    parameters: RandomVibrationParameters = context.parameters
    try:
        found = bandwidth(measured.curve, reference_hz=parameters.reference_hz)
    except InsufficientDataError:
        return
    if found is not None:
        yield Mark(x=found.value, y=_THREE_DB, label=f"{_MINUS}3 dB: {plain(found.value, 4)} Hz")


def _quarter_mark(measured: MeasuredResponse) -> Iterator[Mark]:
    try:
        found = quarter_turn(measured.curve)
    except InsufficientDataError:
        return
    if found is not None:
        yield Mark(x=found.value, y=-90.0, label=f"{_MINUS}90°: {plain(found.value, 4)} Hz")


def _table(measured: MeasuredResponse, context: Context, unit: str) -> Table:
    parameters: RandomVibrationParameters = context.parameters
    printed = printed_unit(unit)
    heading = f"Sensitivity / ({printed})" if printed else "Sensitivity"
    return Table(
        title="Response at single frequencies",
        note="from the curve; U: expanded uncertainty; 3σ: of the runs",
        columns=(
            Column(heading="Frequency", share=12),
            Column(heading=heading, share=22, numbers=True),
            Column(heading="U", share=10, numbers=True),
            Column(heading="3σ / %", share=10, numbers=True),
            Column(heading="Phase / °", share=14, numbers=True),
            Column(heading="U", share=10, numbers=True),
            Column(heading="3σ / °", share=10, numbers=True),
            Column(heading="Coherence", share=12, numbers=True),
        ),
        rows=tuple(_row(measured, one, context) for one in parameters.reported_hz),
    )


def _row(measured: MeasuredResponse, frequency_hz: float, context: Context) -> tuple[Cell, ...]:
    spread = measured.repeatability
    amplitude, phase = Cell(text="–"), Cell(text="–")
    if spread is not None:
        amplitude = Cell(
            value=_at(frequency_hz, spread.frequency_hz, spread.amplitude_percent), digits=2
        )
        phase = Cell(value=_at(frequency_hz, spread.frequency_hz, spread.phase_deg), digits=2)
    coherence = _at(frequency_hz, measured.response.frequency_hz, measured.response.coherence)
    return (
        Cell(text=f"{plain(frequency_hz, 6)} Hz"),
        *_cells(sensitivity_result(measured, frequency_hz, context)),
        amplitude,
        *_cells(phase_result(measured, frequency_hz)),
        phase,
        Cell(text=coherence_text(coherence)),
    )


def _cells(found: Result) -> tuple[Cell, Cell]:
    if found.value is None or found.expanded_uncertainty is None:
        return Cell(text="–"), Cell(text="–")
    half = found.expanded_uncertainty
    return (
        Cell(value=found.value, lower_95=found.value - half, upper_95=found.value + half),
        Cell(value=half, digits=2),
    )


def _at(frequency_hz: float, x: _Array, y: _Array) -> float:
    return float(np.interp(frequency_hz, x, y))


def _drawn(values: _Array) -> tuple[float, ...]:
    return tuple(values.tolist())
