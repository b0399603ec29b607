"""Budgets of sensitivity and phase: the scatter of the estimates, the curve's lack of fit, what is systematic."""

import math
from collections.abc import Iterator, Sequence

import numpy as np

from gyrotest.analysis.band_polynomial import BandPolynomial
from gyrotest.analysis.response_curve import Reading
from gyrotest.procedures.random_vibration.measured import MeasuredResponse
from gyrotest.procedures.uncertainty import by_statistics, rectangular
from gyrotest.procedures.vibration_budget import gain_contributions, phase_contributions
from gyrotest.procedures.wording import plain
from gyrotest.records.plan import Context
from gyrotest.records.result import Contribution
from gyrotest.units import printed_unit

_PERCENT, _SIGMAS, _PPM = 100.0, 3.0, 1e6
_TURN_DEG = 360.0
_READ = "random error and fit of the curve"
_IN_MOTION = "noise in motion that is not at rest"


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


def gain_reading_budget(
    measured: MeasuredResponse, read: Reading, unit: str
) -> tuple[Contribution, ...]:
    """Return every contribution to what is read off the gain's curve and depends on ratios of gains alone."""
    read_of_runs = [_moved(one.log_gain, measured.curve.log_gain, read) for one in measured.run_curves]
    return (
        by_statistics(_READ, read.uncertainty),
        *_of_readings(measured, read_of_runs, differ=_amplitude_differs(measured)),
        *_of_noise_between(measured, read, unit),
    )


def phase_reading_budget(measured: MeasuredResponse, read: Reading) -> tuple[Contribution, ...]:
    """Return every contribution to what is read off the phase's curve, but for the skew's."""
    read_of_runs = [_moved(one.phase, measured.curve.phase, read) for one in measured.run_curves]
    return (
        by_statistics(_READ, read.uncertainty),
        *_of_readings(measured, read_of_runs, differ=_phase_differs(measured)),
    )


def delay_budget(
    measured: MeasuredResponse, read: Reading, frequency_hz: float
) -> tuple[Contribution, ...]:
    """Return every contribution to a group delay, s, but for the skew's."""
    where = np.array([frequency_hz])
    read_of_runs = [
        -float(one.phase.value(where, derivative=1)[0]) / _TURN_DEG for one in measured.run_curves
    ]
    return (
        by_statistics(_READ, read.uncertainty),
        *_of_readings(measured, read_of_runs, differ=_phase_differs(measured)),
    )


def _amplitude_differs(measured: MeasuredResponse) -> bool:
    """Whether the runs' gains differ by more than their random error explains."""
    return measured.repeatability is not None and measured.repeatability.amplitude.lower_95 > 0.0


def _phase_differs(measured: MeasuredResponse) -> bool:
    return measured.repeatability is not None and measured.repeatability.phase.lower_95 > 0.0


def _moved(run: BandPolynomial, together: BandPolynomial, read: Reading) -> float:
    """Return by how much a run's curve moves a reading of the curve through all runs."""
    at_hz = np.array(read.at_hz)
    apart = run.value(at_hz) - together.value(at_hz)
    # of phases, which may be whole turns apart; logarithms of gains are never
    apart -= _TURN_DEG * np.rint(apart / _TURN_DEG)
    return float(np.array(read.factors) @ apart)


def _of_readings(
    measured: MeasuredResponse, read_of_runs: Sequence[float], *, differ: bool
) -> Iterator[Contribution]:
    if differ:
        yield _of_spread(_SIGMAS * float(np.std(read_of_runs, ddof=1)), len(measured.runs))


def _of_noise_between(measured: MeasuredResponse, read: Reading, unit: str) -> Iterator[Contribution]:
    """Give what noise in motion does to the ratio of gains, each of which it may move by itself."""
    shares = np.interp(read.at_hz, measured.response.frequency_hz, measured.noise_beyond_rest)
    largest = float(shares.max())
    if largest > 0.0:
        half = float(np.linalg.norm(np.array(read.factors) * shares))
        of = f"{plain(half / largest, 3)} {unit}"
        yield rectangular(_IN_MOTION, f"{plain(largest * _PPM, 2)} ppm", of, half)


def _of_curve(curve: BandPolynomial, frequency_hz: float, factor: float) -> Iterator[Contribution]:
    rows = curve.rows(np.array([frequency_hz]))
    yield by_statistics("random error, by the curve", factor * float(curve.random(rows)[0]))
    if curve.lacking:
        yield by_statistics("lack of fit of the curve", factor * abs(float((rows @ curve.lack)[0])))


def _of_amplitude_spread(
    measured: MeasuredResponse, frequency_hz: float, value: float
) -> Iterator[Contribution]:
    found = measured.repeatability
    if found is not None and _amplitude_differs(measured):
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
        yield rectangular(_IN_MOTION, half_width, of, share * abs(value))


def _of_phase_spread(measured: MeasuredResponse, frequency_hz: float) -> Iterator[Contribution]:
    found = measured.repeatability
    if found is not None and _phase_differs(measured):
        yield _of_spread(float(np.interp(frequency_hz, found.frequency_hz, found.phase_deg)), found.runs)


def _of_spread(three_sigma: float, runs: int) -> Contribution:
    """Give the mean's share of a spread of the runs that their random error does not explain."""
    standard = three_sigma / _SIGMAS / math.sqrt(runs)
    return by_statistics("spread of the runs", standard, freedom=runs - 1)
