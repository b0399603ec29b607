"""Results of a sine-vibration case: sensitivity and phase at each frequency, and what the band gives."""

from collections.abc import Iterator

from gyrotest.procedures.sine_vibration.band import LOST_IN_NOISE, band_results
from gyrotest.procedures.sine_vibration.measured import MeasuredSines, SinePoint
from gyrotest.procedures.sine_vibration.parameters import SineVibrationParameters
from gyrotest.procedures.sine_vibration.uncertainty import (
    missing_of_angle,
    missing_of_sensitivity,
    phase_budget,
    sensitivity_budget,
)
from gyrotest.procedures.uncertainty import budgeted_result
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

_ROOT_2 = 2.0**0.5


def sine_results(measured: MeasuredSines, context: Context) -> Iterator[Result]:
    """Give the results of one acquisition, frequencies in the order in which they were asked for."""
    parameters: SineVibrationParameters = context.parameters
    for frequency_hz in parameters.frequencies_hz:
        yield sensitivity_result(measured, measured.at(frequency_hz), context)
    for frequency_hz in parameters.frequencies_hz:
        yield phase_result(measured, measured.at(frequency_hz))
    yield from band_results(measured, parameters)


def sensitivity_result(measured: MeasuredSines, point: SinePoint, context: Context) -> Result:
    """Return the amplitude of the output over that of the rate, with the sign of the scale factor."""
    name, label = sensitivity_name(point.asked_hz), sensitivity_label(point.asked_hz)
    unit = SENSITIVITY_UNITS[context.output.kind]
    if not point.told:
        return _lost_in_noise(name, label, unit)
    factor = conversion_factor(measured.channels.scaling.slope_unit, unit)
    value = measured.scale * point.response.gain * factor
    return budgeted_result(
        sensitivity_budget(measured, point, context, value=value, unit=unit),
        name=name,
        label=label,
        value=value,
        unit=unit,
        condition=_words(point),
        not_included=missing_of_sensitivity(measured, context),
    )


def phase_result(measured: MeasuredSines, point: SinePoint) -> Result:
    """Return the phase of the output less that of the rate, a lag negative."""
    name, label = phase_name(point.asked_hz), phase_label(point.asked_hz)
    if not point.told:
        return _lost_in_noise(name, label, "deg")
    return budgeted_result(
        phase_budget(measured, point),
        name=name,
        label=label,
        value=point.phase_deg,
        unit="deg",
        condition=_words(point),
        not_included=missing_of_angle(measured),
    )


def _lost_in_noise(name: str, label: str, unit: str) -> Result:
    return Result(name=name, label=label, value=None, unit=unit, condition=LOST_IN_NOISE)


def _words(point: SinePoint) -> str:
    response = point.response
    return f"{plain(response.rate_dps / _ROOT_2, 4)} °/s rms, {response.periods} periods"
