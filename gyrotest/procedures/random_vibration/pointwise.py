"""Sensitivity and phase at a frequency: what the curve through all runs has there, with its budget."""

from collections.abc import Callable

import numpy as np

from gyrotest.errors import InsufficientDataError
from gyrotest.procedures.random_vibration.measured import MeasuredResponse
from gyrotest.procedures.random_vibration.uncertainty import gain_budget, phase_budget
from gyrotest.procedures.uncertainty import budgeted_result
from gyrotest.procedures.vibration_budget import missing_of_gain, missing_of_phase
from gyrotest.procedures.vibration_names import (
    SENSITIVITY_UNITS,
    phase_label,
    phase_name,
    sensitivity_label,
    sensitivity_name,
)
from gyrotest.procedures.wording import plain
from gyrotest.records.plan import Context
from gyrotest.records.result import Result
from gyrotest.units import conversion_factor

_ROUNDING = 1e-6


def sensitivity_result(measured: MeasuredResponse, frequency_hz: float, context: Context) -> Result:
    """Return the sensitivity that the curve through all runs has at a frequency."""
    name, label = sensitivity_name(frequency_hz), sensitivity_label(frequency_hz)
    unit = SENSITIVITY_UNITS[context.output.kind]

    def found() -> Result:
        gain = float(measured.curve.at(np.array([frequency_hz])).gain[0])
        refuse_left_out(measured, frequency_hz)
        value = gain * scale_in(measured, unit)
        return budgeted_result(
            gain_budget(measured, frequency_hz, context, value=value, unit=unit),
            name=name,
            label=label,
            value=value,
            unit=unit,
            condition=_curve_words(measured),
            not_included=missing_of_gain(context),
        )

    return evaluated(found, name, label, unit)


def phase_result(measured: MeasuredResponse, frequency_hz: float) -> Result:
    """Return the phase that the curve through all runs has at a frequency, a lag negative."""
    name, label = phase_name(frequency_hz), phase_label(frequency_hz)

    def found() -> Result:
        value = float(measured.curve.at(np.array([frequency_hz])).phase_deg[0])
        refuse_left_out(measured, frequency_hz)
        return budgeted_result(
            phase_budget(measured, frequency_hz),
            name=name,
            label=label,
            value=value,
            unit="deg",
            condition=_curve_words(measured),
            not_included=missing_of_phase(measured.sampling),
        )

    return evaluated(found, name, label, "deg")


def refuse_left_out(measured: MeasuredResponse, *frequencies_hz: float) -> None:
    """Refuse frequencies among lines that are left out, of which the curve knows nothing but what is beside.

    A single line is none; raises `InsufficientDataError` with what is left out.
    """
    lines_hz, apart_hz = measured.curve.lines.frequency_hz, 1.0 / measured.response.segment_s
    for frequency_hz in frequencies_hz:
        if float(np.abs(lines_hz - frequency_hz).min()) <= (1.0 + _ROUNDING) * apart_hz:
            continue
        above = int(np.searchsorted(lines_hz, frequency_hz))
        begin_hz, end_hz = lines_hz[above - 1] + apart_hz, lines_hz[above] - apart_hz
        raise InsufficientDataError(
            f"{plain(frequency_hz, 5)} Hz is among the frequencies that are left out for want of coherence,"
            f" {plain(float(begin_hz), 5)} … {plain(float(end_hz), 5)} Hz; vibrate harder or longer, or find what"
            " disturbs there"
        )


def scale_in(measured: MeasuredResponse, unit: str) -> float:
    """Return what a gain of 1 is as a sensitivity in a unit."""
    return measured.scale * conversion_factor(measured.scaling.slope_unit, unit)


def _curve_words(measured: MeasuredResponse) -> str:
    runs = len(measured.runs)
    return "by the curve through the run" if runs == 1 else f"by the curve through {runs} runs"


def evaluated(found: Callable[[], Result], name: str, label: str, unit: str) -> Result:
    """Return a result; where it cannot be had, one without a value that says why."""
    try:
        return found()
    except InsufficientDataError as error:
        return Result(name=name, label=label, value=None, unit=unit, condition=str(error))
