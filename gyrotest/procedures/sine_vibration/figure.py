"""The response over frequency: sensitivity in dB and phase with their uncertainties, limits, and a table."""

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass

from gyrotest.analysis.response_curve import HALF_POWER
from gyrotest.procedures.sine_vibration.measured import MeasuredSines
from gyrotest.procedures.sine_vibration.parameters import SineVibrationParameters
from gyrotest.procedures.vibration_names import (
    BANDWIDTH,
    PHASE_90,
    SENSITIVITY_UNITS,
    phase_name,
    sensitivity_name,
)
from gyrotest.procedures.wording import ending, places_of, plain
from gyrotest.records.figure import Curve, Figure, Mark, Panel, Points, Role, Scale
from gyrotest.records.plan import Context
from gyrotest.records.result import Result
from gyrotest.records.table import Cell, Column, Table
from gyrotest.units import printed_unit

_BESIDE = 1.06  # how far a limit at a frequency is drawn to either side of it
_DB = 20.0 / math.log(10.0)
_NEAR_QUARTER = -60.0
_PERCENT, _ROOT_2 = 100.0, math.sqrt(2.0)
_MINUS = "\N{MINUS SIGN}"


def bode_figure(measured: MeasuredSines, results: tuple[Result, ...], context: Context) -> Figure:
    """Draw what was measured with 95 % bars, limits, −3 dB and −90°."""
    parameters: SineVibrationParameters = context.parameters
    found = {one.name: one for one in results if one.value is not None}
    drawn = _Drawn(measured=measured, found=found, context=context)
    how = "one after another" if parameters.sweep is None else "read from one sweep"
    first, last = measured.points[0], measured.points[-1]
    return Figure(
        name="bode_sine",
        title="Frequency response by sines",
        panels=(drawn.gain_panel(), drawn.phase_panel()),
        note=f"0 dB: {plain(drawn.zero_db, 5)} {printed_unit(drawn.unit)}".strip()
        + f" at {plain(parameters.reference_hz, 6)} Hz",
        caption=f"Sensitivity and phase at {len(measured.points)} frequencies, {how}; bars: expanded uncertainty;"
        " dashed: limits.",
        alt=f"Bode plot from {plain(first.asked_hz, 6)} to {plain(last.asked_hz, 6)} Hz",
        table=_table(drawn),
    )


class _Drawn:
    """What is drawn, and in what."""

    def __init__(self, *, measured: MeasuredSines, found: dict[str, Result], context: Context) -> None:
        self.measured, self.found, self.context = measured, found, context
        self.parameters: SineVibrationParameters = context.parameters
        self.unit = SENSITIVITY_UNITS[context.output.kind]
        reference = found.get(sensitivity_name(measured.at(self.parameters.reference_hz).asked_hz))
        known = next((one for name, one in found.items() if name.startswith("sensitivity_")), None)
        zero = reference or known
        self.zero_db = abs(zero.value or 1.0) if zero is not None else 1.0

    def gain_panel(self) -> Panel:
        """Draw the sensitivities in dB of that at the reference frequency."""
        there = tuple(self._results(sensitivity_name))
        x = tuple(one.frequency_hz for one in there)
        y = tuple(self._decibels(one.value) for one in there)
        u = tuple(_DB * one.half / abs(one.value) for one in there)
        marks = tuple(self._three_db_mark())
        return Panel(
            y_label="Sensitivity / dB",
            x_scale=Scale.LOG,
            height=1.25,
            curves=(
                Curve(x=x, y=y, role=Role.COMPONENT),
                self._level(_DB * HALF_POWER, "" if marks else f"{_MINUS}3 dB"),
                *self._limits(sensitivity_name, self.unit, self._decibels),
            ),
            points=(Points(x=x, y=y, u=u),),
            marks=marks,
        )

    def phase_panel(self) -> Panel:
        """Draw the phases."""
        there = tuple(self._results(phase_name))
        x = tuple(one.frequency_hz for one in there)
        y = tuple(one.value for one in there)
        u = tuple(one.half for one in there)
        near = min(y, default=0.0) < _NEAR_QUARTER
        return Panel(
            y_label="Phase / °",
            x_label="Frequency / Hz",
            x_scale=Scale.LOG,
            height=1.25,
            curves=(
                Curve(x=x, y=y, role=Role.COMPONENT),
                *((self._level(-90.0, ""),) if near else ()),
                *self._limits(phase_name, "deg", float),
            ),
            points=(Points(x=x, y=y, u=u),),
            marks=tuple(self._quarter_mark()),
        )

    def rows(self) -> Iterator[tuple[Cell, ...]]:
        """Give a row a frequency, in rising order."""
        for point in self.measured.points:
            sensitivity = self.found.get(sensitivity_name(point.asked_hz))
            phase = self.found.get(phase_name(point.asked_hz))
            left = point.response.output_residual * _ROOT_2 / point.response.output
            yield (
                Cell(text=plain(point.asked_hz, 6)),
                Cell(text=plain(point.response.rate_dps / _ROOT_2, 4)),
                *_pair(sensitivity),
                *_pair(phase),
                Cell(text=plain(_PERCENT * left, 2)),
            )

    def _results(self, named: Callable[[float], str]) -> Iterator["_At"]:
        for point in self.measured.points:
            result = self.found.get(named(point.asked_hz))
            if result is not None and result.value is not None:
                half = result.expanded_uncertainty or 0.0
                yield _At(frequency_hz=point.asked_hz, value=result.value, half=half)

    def _level(self, value: float, label: str) -> Curve:
        ends = (self.measured.points[0].asked_hz, self.measured.points[-1].asked_hz)
        return Curve(x=ends, y=(value, value), role=Role.GUIDE, label=label)

    def _decibels(self, value: float) -> float:
        """Return a sensitivity's limit in dB; its sign is judged, not drawn."""
        return _DB * math.log(abs(value) / self.zero_db) if value else math.nan

    def _limits(
        self, named: Callable[[float], str], unit: str, drawn: Callable[[float], float]
    ) -> Iterator[Curve]:
        for frequency_hz in self.parameters.frequencies_hz:
            limit = self.context.case.limits.get(named(frequency_hz))
            for end in () if limit is None else (limit.min, limit.max):
                y = math.nan if end is None else drawn(end.to(unit))
                if math.isfinite(y):
                    ends = (frequency_hz / _BESIDE, frequency_hz * _BESIDE)
                    yield Curve(x=ends, y=(y, y), role=Role.LIMIT)

    def _three_db_mark(self) -> Iterator[Mark]:
        reference_hz = self.parameters.reference_hz
        result = self.found.get(BANDWIDTH)
        reference = self.found.get(sensitivity_name(self.measured.at(reference_hz).asked_hz))
        if result is None or result.value is None or result.at_least or reference is None:
            return
        label = f"{_MINUS}3 dB: {plain(result.value, 4)} Hz"
        yield Mark(x=result.value, y=_DB * HALF_POWER, label=label)

    def _quarter_mark(self) -> Iterator[Mark]:
        result = self.found.get(PHASE_90)
        if result is not None and result.value is not None and not result.at_least:
            yield Mark(x=result.value, y=-90.0, label=f"{_MINUS}90°: {plain(result.value, 4)} Hz")


@dataclass(frozen=True, slots=True, kw_only=True)
class _At:
    """A result at a frequency, and half its interval."""

    frequency_hz: float
    value: float
    half: float


def _pair(result: Result | None) -> tuple[Cell, ...]:
    """Return a value and its uncertainty as cells; dashes where there is none."""
    if result is None or result.value is None:
        return Cell(text="–"), Cell(text="–")
    half = result.expanded_uncertainty or 0.0
    places = places_of(half)
    return Cell(text=ending(result.value, places)), Cell(text=ending(half, places))


def _table(drawn: _Drawn) -> Table:
    printed = printed_unit(drawn.unit)
    return Table(
        title="Response at single frequencies",
        note="U: expanded uncertainty; beside: rms of what the sine leaves of the output, of the sine's",
        columns=(
            Column(heading="Frequency / Hz", share=14, numbers=True),
            Column(heading="Rate / (°/s rms)", share=14, numbers=True),
            Column(
                heading=f"Sensitivity / ({printed})" if printed else "Sensitivity",
                share=22,
                numbers=True,
            ),
            Column(heading="U", share=10, numbers=True),
            Column(heading="Phase / °", share=14, numbers=True),
            Column(heading="U", share=10, numbers=True),
            Column(heading="Beside / %", share=12, numbers=True),
        ),
        rows=tuple(drawn.rows()),
    )
