"""Budgets of sensitivity and phase: the scatter of the estimates, the curve's lack of fit, what is systematic."""

import math
from collections.abc import Iterator

import numpy as np

from gyrotest.analysis.band_polynomial import BandPolynomial
from gyrotest.procedures.random_vibration.measured import MeasuredResponse
from gyrotest.procedures.uncertainty import by_statistics, rectangular
from gyrotest.procedures.vibration_budget import gain_contributions, phase_contributions
from gyrotest.procedures.wording import plain
from gyrotest.records.plan import Context
from gyrotest.records.result import Contribution
from gyrotest.units import printed_unit

_PERCENT, _SIGMAS, _PPM = 100.0, 3.0, 1e6


def gain_budget(
    measured: MeasuredResponse, frequency_hz: float, context: Context, *, value: float, unit: str
) -> tuple[Contribution, ...]:
    """Return every contribution to the uncertainty of a sensitivity, which is `value` in `unit`."""
    return (
        *_of_curve(measured.curve.log_gain, frequency_hz, abs(value)),
        *_of_amplitude_spread(measured, frequency_hz, abs(value)),
        *_of_noise_in_motion(measured, frequency_hz, value, unit),
        *gain_contributions(context, value=value, unit=unit),
    )


def phase_budget(measured: MeasuredResponse, frequency_hz: float) -> tuple[Contribution, ...]:
    """Return every contribution to the uncertainty of a phase, °."""
    return (
        *_of_curve(measured.curve.phase, frequency_hz, 1.0),
        *_of_phase_spread(measured, frequency_hz),
        *phase_contributions(measured.sampling, frequency_hz=frequency_hz),
    )


def _of_curve(curve: BandPolynomial, frequency_hz: float, factor: float) -> Iterator[Contribution]:
    rows = curve.rows(np.array([frequency_hz]))
    yield by_statistics("random error, by the curve", factor * float(curve.random(rows)[0]))
    if curve.lacking:
        yield by_statistics("lack of fit of the curve", factor * abs(float((rows @ curve.lack)[0])))


def _of_amplitude_spread(
    measured: MeasuredResponse, frequency_hz: float, value: float
) -> Iterator[Contribution]:
    found = measured.repeatability
    if found is not None and found.amplitude.lower_95 > 0.0:
        relative = float(np.interp(frequency_hz, found.frequency_hz, found.amplitude_percent)) / _PERCENT
        yield _of_spread(value * relative, found.runs)


def _of_noise_in_motion(
    measured: MeasuredResponse, frequency_hz: float, value: float, unit: str
) -> Iterator[Contribution]:
    lines = measured.response.frequency_hz
    share = float(np.interp(frequency_hz, lines, measured.noise_beyond_rest))
    if share > 0.0:
        of = f"{plain(abs(value), 4)} {printed_unit(unit)}".strip()
        half_width = f"{plain(share * _PPM, 2)} ppm"
        yield rectangular("noise in motion that is not at rest", half_width, of, share * abs(value))


def _of_phase_spread(measured: MeasuredResponse, frequency_hz: float) -> Iterator[Contribution]:
    found = measured.repeatability
    if found is not None and found.phase.lower_95 > 0.0:
        yield _of_spread(float(np.interp(frequency_hz, found.frequency_hz, found.phase_deg)), found.runs)


def _of_spread(three_sigma: float, runs: int) -> Contribution:
    """Give the mean's share of a spread of the runs that their random error does not explain."""
    standard = three_sigma / _SIGMAS / math.sqrt(runs)
    return by_statistics("spread of the runs", standard, freedom=runs - 1)
