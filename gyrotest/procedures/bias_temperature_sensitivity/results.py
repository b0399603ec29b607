"""Sensitivity and slope as results, with their budgets."""

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from gyrotest.analysis.extremes import largest_magnitude
from gyrotest.analysis.temperature import (
    TemperatureLine,
    TemperatureSensitivity,
    temperature_line,
    temperature_sensitivity,
)
from gyrotest.procedures.bias_temperature_sensitivity.set_points import SetPoints
from gyrotest.procedures.uncertainty import budgeted_result, by_statistics, expanded, rectangular
from gyrotest.procedures.wording import plain
from gyrotest.records.plan import Context
from gyrotest.records.result import Contribution, Result
from gyrotest.records.spec import OutputKind
from gyrotest.records.station import Accuracy
from gyrotest.units import Quantity

DPH = 3600.0
UNIT = "deg/h/degC"

_MINUS = "\N{MINUS SIGN}"
_ROOT_3 = math.sqrt(3.0)


@dataclass(frozen=True, slots=True, kw_only=True)
class _Error:
    """A size, °/s a °C, and its standard uncertainties by noise and by the temperatures' own errors."""

    size: float
    by_bias: float
    by_setting: float


def sensitivity_of(points: SetPoints, context: Context) -> TemperatureSensitivity:
    """Find the set point of the greatest change for its distance, °/s a °C."""
    return temperature_sensitivity(
        points.temperature_degc,
        points.bias_dps,
        room=points.room,
        bias_covariance=points.covariance,
        setting_uncertainty_c=_setting_c(points, context) / _ROOT_3,
    )


def line_of(points: SetPoints, context: Context) -> TemperatureLine:
    """Fit a line to the biases, °/s a °C."""
    return temperature_line(
        points.temperature_degc,
        points.bias_dps,
        room=points.room,
        bias_covariance=points.covariance,
        setting_uncertainty_c=_setting_c(points, context) / _ROOT_3,
    )


def sensitivity_result(found: TemperatureSensitivity, points: SetPoints, context: Context) -> Result:
    """Return max|B_i − B_room|/|T_i − T_room| with its interval, and the budget of the ratio that it is."""
    at, room = (float(points.temperature_degc[place]) for place in (found.worst, points.room))
    condition = (
        f"at {plain(at, 3)} °C the bias is {_signed(found.change * DPH)} °/h from that at {plain(room, 3)} °C;"
        f" temperatures: {points.reader.name}"
    )
    errors = [
        _Error(size=abs(float(size)), by_bias=float(noise), by_setting=float(setting))
        for size, noise, setting in zip(found.ratios, found.by_bias, found.by_setting, strict=True)
    ]
    totals = [expanded(tuple(_budget(one, points, context))) for one in errors]
    span = largest_magnitude(
        found.ratios * DPH,
        standard=np.array([one.standard for one in totals]),
        freedom=np.array([one.freedom for one in totals]),
    )
    worst = max(errors, key=lambda one: one.size)
    return Result(
        name="bias_temperature_sensitivity",
        label="Bias, temperature sensitivity",
        value=span.value,
        unit=UNIT,
        lower_95=span.lower_95,
        upper_95=span.upper_95,
        condition=condition.replace("-", _MINUS),
        budget=tuple(_budget(worst, points, context)),
        not_included=tuple(_missing(points, context)),
    )


def slope_result(found: TemperatureLine, points: SetPoints, context: Context) -> Result:
    """Return the slope of the line of least squares with its budget."""
    low, high = (plain(float(one), 3) for one in _ends(points))
    condition = (
        f"least squares over {points.temperature_degc.size} set points from {low} to {high} °C,"
        f" which lie up to {plain(found.departure * DPH, 2)} °/h from the line"
    )
    error = _Error(size=abs(found.slope), by_bias=found.by_bias, by_setting=found.by_setting)
    budget = tuple(_budget(error, points, context))
    return budgeted_result(
        budget,
        name="bias_temperature_slope",
        label="Bias, slope over temperature",
        value=found.slope * DPH,
        unit=UNIT,
        condition=condition.replace("-", _MINUS),
        not_included=tuple(_missing(points, context)),
    )


def _ends(points: SetPoints) -> tuple[float, float]:
    return float(points.temperature_degc.min()), float(points.temperature_degc.max())


def _budget(error: "_Error", points: SetPoints, context: Context) -> Iterator[Contribution]:
    """Give what contributes to a bias a °C, in the result's unit.

    What all set points share, as the Earth's rate and the meter's offset, is not in a difference.
    """
    yield by_statistics("noise and wander of the biases", error.by_bias * DPH, points.freedom)
    half_c = _setting_c(points, context)
    if half_c > 0.0:
        yield rectangular(
            "chamber, error of each setting",
            f"{plain(half_c, 2)} °C",
            f"{plain(error.by_setting * DPH / (half_c / _ROOT_3), 3)} °/h/°C²",
            error.by_setting * DPH * _ROOT_3,
        )
    for source, share in _in_proportion(points, context):
        size = error.size * DPH
        yield rectangular(source, f"{share}", f"{plain(size, 3)} °/h/°C", share.to("") * size)


def _in_proportion(points: SetPoints, context: Context) -> Iterator[tuple[str, Quantity]]:
    chamber, meter = _chamber(points, context), context.accuracy
    if chamber is not None and chamber.of_reading.value > 0.0:
        yield "chamber, in proportion", chamber.of_reading
    if context.output.scale_factor_uncertainty is not None:
        yield "scale factor", context.output.scale_factor_uncertainty
    if meter is not None:
        yield "meter, of reading", meter.of_reading


def _chamber(points: SetPoints, context: Context) -> Accuracy | None:
    """Return the accuracy of the chamber, where it is the chamber that tells the temperatures."""
    return context.chamber if points.reader.chamber else None


def _setting_c(points: SetPoints, context: Context) -> float:
    chamber = _chamber(points, context)
    if chamber is None or chamber.of_setting is None:
        return 0.0
    return chamber.of_setting.to("degC")


def _missing(points: SetPoints, context: Context) -> Iterator[str]:
    if not points.reader.chamber:
        yield "accuracy of the temperature sensor"
    elif context.chamber is None or context.chamber.of_setting is None:
        yield "accuracy of the chamber"
    if context.output.kind is OutputKind.VOLTAGE and context.accuracy is None:
        yield "accuracy of the meter"
    if context.output.scale_factor_uncertainty is None:
        yield "uncertainty of the scale factor"


def _signed(value: float) -> str:
    return f"{'+' if value > 0 else ''}{plain(value, 3)}"
