"""Budgets of sensitivity and phase at a frequency: noise beside it, source, encoder, skew, the drive."""

import math
from collections.abc import Iterator

import numpy as np

from gyrotest.procedures.sine_vibration.measured import MeasuredSines, SinePoint
from gyrotest.procedures.uncertainty import by_statistics, rectangular
from gyrotest.procedures.vibration_budget import (
    gain_contributions,
    missing_of_gain,
    missing_of_phase,
    phase_contributions,
)
from gyrotest.procedures.wording import plain
from gyrotest.records.plan import Context
from gyrotest.records.result import Contribution

_WAVES = 2.0 * math.pi
_PPM = 1e6
_MATTERS_OFF = 1e-5
_NOISE = "noise beside the frequency"
_SWEEP = "speed of the sweep"


def sensitivity_budget(
    measured: MeasuredSines, point: SinePoint, context: Context, *, value: float, unit: str
) -> tuple[Contribution, ...]:
    """Return every contribution to the uncertainty of a sensitivity, which is `value` in `unit`."""
    size = abs(value)
    return (
        _of_noise(point, size),
        *gain_contributions(context, value=value, unit=unit),
        *_of_distortion(measured, point, factor=size),
        *_of_drive(measured, point, slope=size * _log_gain_slope(measured, point)),
        *_of_sweep(measured, point, factor=size),
    )


def phase_budget(measured: MeasuredSines, point: SinePoint) -> tuple[Contribution, ...]:
    """Return every contribution to the uncertainty of a phase, °."""
    degrees = math.degrees(1.0)
    sampling, frequency_hz = measured.channels.sampling, point.response.frequency_hz
    return (
        _of_noise(point, degrees),
        *phase_contributions(sampling, frequency_hz=frequency_hz),
        *_of_distortion(measured, point, factor=degrees),
        *_of_drive(measured, point, slope=_phase_slope(measured, point)),
        *_of_sweep(measured, point, factor=degrees),
    )


def missing_of_sensitivity(measured: MeasuredSines, context: Context) -> tuple[str, ...]:
    """Give what could not be had of a sensitivity's uncertainty."""
    return (*missing_of_gain(context), *_unseen_distortion(measured), *_unseen_slopes(measured))


def missing_of_angle(measured: MeasuredSines) -> tuple[str, ...]:
    """Give what could not be had of a phase's uncertainty."""
    sampling = measured.channels.sampling
    return (*missing_of_phase(sampling), *_unseen_distortion(measured), *_unseen_slopes(measured))


def distortion_share(measured: MeasuredSines, point: SinePoint) -> float:
    """Return by how much of itself (one sigma) the table's amplitude may be wrong within the grating's lines.

    What remains of the signals' distortion makes an error of angle that comes again with every line. Of a
    motion over many lines most of it does not have the motion's frequency: by Bessel's J₁ 2/√(πm) at most,
    m the amplitude as a phase of the line.
    """
    ellipse, line_deg = measured.channels.ellipse, measured.channels.line_deg
    if ellipse is None or ellipse.line_error is None or line_deg is None:
        return 0.0
    phase = _WAVES * _amplitude_deg(point) / line_deg
    return min(1.0, 2.0 / math.sqrt(math.pi * phase)) * ellipse.line_error.uncertainty / phase


def _amplitude_deg(point: SinePoint) -> float:
    return point.response.rate_dps / (_WAVES * point.response.frequency_hz)


def _of_noise(point: SinePoint, factor: float) -> Contribution:
    response = point.response
    return by_statistics(_NOISE, factor * response.relative_uncertainty, response.degrees_of_freedom)


def _of_distortion(
    measured: MeasuredSines, point: SinePoint, *, factor: float
) -> Iterator[Contribution]:
    share = distortion_share(measured, point)
    if share > 0.0:
        yield by_statistics("encoder, distortion of its signals", share * factor)


def _unseen_distortion(measured: MeasuredSines) -> tuple[str, ...]:
    """Of an angle whose signals are not seen, errors within short ways are only known by its accuracy."""
    ellipse = measured.channels.ellipse
    if ellipse is None:
        return ("errors of the encoder within small angles",)
    return () if ellipse.line_error is not None else ("encoder, distortion of its signals",)


def _of_drive(measured: MeasuredSines, point: SinePoint, *, slope: float) -> Iterator[Contribution]:
    """Give what the response changes between the frequency that was asked for and the one that was driven."""
    off = point.response.frequency_hz / point.asked_hz - 1.0
    if abs(off) > _MATTERS_OFF and len(measured.points) > 1:
        yield rectangular(
            "frequency of the drive",
            f"{plain(abs(off) * _PPM, 2)} ppm",
            plain(abs(slope), 3),
            abs(slope * off),
        )


def _of_sweep(measured: MeasuredSines, point: SinePoint, *, factor: float) -> Iterator[Contribution]:
    """Give by how much a response that is swept through differs from the steady one.

    To a phase with the second derivative α the response H answers with H − (j/2)·α·H″. H″/H is of the size of
    (H′/H)², which the points on either side tell.
    """
    growth_per_s = _growth_per_s(measured)
    if not growth_per_s or len(measured.points) < 2:
        return
    steep = abs(_log_gain_slope(measured, point)) + abs(math.radians(_phase_slope(measured, point)))
    share = growth_per_s * steep**2 / (2.0 * _WAVES * point.response.frequency_hz)
    yield rectangular(_SWEEP, f"{plain(share * _PPM, 2)} ppm", plain(factor, 4), share * factor)


def _growth_per_s(measured: MeasuredSines) -> float:
    """Return by how much of itself the frequency grows in a second; 0 where it stays."""
    context = measured.channels.context
    sweep = context.parameters.sweep
    if sweep is None:
        return 0.0
    return float(sweep.growth_per_s(context.dwells[0].samples * measured.channels.interval_s))


def _unseen_slopes(measured: MeasuredSines) -> tuple[str, ...]:
    """A single frequency does not tell how the response changes while it is swept through."""
    return (_SWEEP,) if _growth_per_s(measured) and len(measured.points) < 2 else ()


def _log_gain_slope(measured: MeasuredSines, point: SinePoint) -> float:
    """Return d ln gain/d ln f at a point; 0 where there is only one."""
    return _slope(measured, point, [math.log(one.response.gain) for one in measured.points])


def _phase_slope(measured: MeasuredSines, point: SinePoint) -> float:
    """Return d phase/d ln f at a point, °."""
    return _slope(measured, point, [one.phase_deg for one in measured.points])


def _slope(measured: MeasuredSines, point: SinePoint, values: list[float]) -> float:
    if len(values) < 2:
        return 0.0
    log_hz = np.log([one.response.frequency_hz for one in measured.points])
    return float(np.gradient(np.array(values), log_hz)[measured.points.index(point)])
