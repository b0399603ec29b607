"""What is read off the curve over the whole band: flatness, bandwidth, the −90° frequency, the delay."""

import math
from collections.abc import Iterator
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from gyrotest.analysis.interval import NORMAL_95
from gyrotest.analysis.response_curve import (
    HALF_POWER,
    Reading,
    bandwidth,
    flatness,
    group_delay,
    quarter_turn,
)
from gyrotest.procedures.random_vibration.measurands import GROUP_DELAY, LABELS
from gyrotest.procedures.random_vibration.measured import MeasuredResponse
from gyrotest.procedures.random_vibration.parameters import RandomVibrationParameters
from gyrotest.procedures.random_vibration.pointwise import evaluated, refuse_left_out
from gyrotest.procedures.random_vibration.uncertainty import (
    delay_budget,
    gain_reading_budget,
    phase_reading_budget,
)
from gyrotest.procedures.uncertainty import budgeted_result, rectangular
from gyrotest.procedures.vibration_budget import missing_of_phase
from gyrotest.procedures.vibration_names import BAND_LABELS, BANDWIDTH, FLATNESS, PHASE_90
from gyrotest.procedures.wording import engineering, plain
from gyrotest.records.result import Contribution, Result

_GRID = 1001
_TURN_DEG = 360.0
_MINUS = "\N{MINUS SIGN}"


def band_results(measured: MeasuredResponse, parameters: RandomVibrationParameters) -> Iterator[Result]:
    """Give what the whole band tells."""
    yield _flatness_result(measured, parameters)
    yield _bandwidth_result(measured, parameters)
    yield _phase_90_result(measured)
    yield _delay_result(measured, parameters)


def _flatness_result(measured: MeasuredResponse, parameters: RandomVibrationParameters) -> Result:
    label = BAND_LABELS[FLATNESS]
    to_hz, reference_hz = parameters.flat_to_hz, parameters.reference_hz

    def found() -> Result:
        read = flatness(measured.curve, reference_hz=reference_hz, to_hz=to_hz)
        refuse_left_out(measured, *read.at_hz)
        return budgeted_result(
            gain_reading_budget(measured, read, "%"),
            name=FLATNESS,
            label=label,
            value=read.value,
            unit="%",
            condition=f"highest less lowest, {plain(measured.curve.low_hz, 6)} … {plain(to_hz, 6)} Hz, of that at"
            f" {plain(reference_hz, 6)} Hz",
            not_included=(),
        )

    return evaluated(found, FLATNESS, label, "%")


def _bandwidth_result(measured: MeasuredResponse, parameters: RandomVibrationParameters) -> Result:
    label, reference_hz = BAND_LABELS[BANDWIDTH], parameters.reference_hz
    condition = f"{_MINUS}3 dB of the sensitivity at {plain(reference_hz, 6)} Hz"

    def found() -> Result:
        read = bandwidth(measured.curve, reference_hz=reference_hz)
        if read is None:
            lowest = _certainly_above(measured, reference_hz)
            return _not_reached(measured, BANDWIDTH, label, condition, lowest)
        refuse_left_out(measured, *read.at_hz)
        return budgeted_result(
            gain_reading_budget(measured, read, "Hz"),
            name=BANDWIDTH,
            label=label,
            value=read.value,
            unit="Hz",
            condition=condition,
            not_included=(),
        )

    return evaluated(found, BANDWIDTH, label, "Hz")


def _certainly_above(measured: MeasuredResponse, reference_hz: float) -> float:
    """Return up to where the gain is certainly (97.5 %) above its −3 dB."""
    grid, curve = np.linspace(reference_hz, measured.curve.high_hz, _GRID), measured.curve.log_gain
    reference = np.array([reference_hz])
    change = curve.value(grid) - curve.value(reference)
    uncertainty = curve.uncertainty(curve.rows(grid) - curve.rows(reference))
    return _before(grid, change - NORMAL_95 * uncertainty <= HALF_POWER)


def _before(grid: NDArray[np.float64], beyond: NDArray[np.bool_]) -> float:
    first = np.flatnonzero(beyond)
    return float(grid[max(int(first[0]) - 1, 0)] if first.size else grid[-1])


def _phase_90_result(measured: MeasuredResponse) -> Result:
    label = BAND_LABELS[PHASE_90]

    def found() -> Result:
        read = quarter_turn(measured.curve)
        if read is None:
            return _not_reached(measured, PHASE_90, label, "", _certainly_less(measured))
        refuse_left_out(measured, *read.at_hz)
        return budgeted_result(
            (*phase_reading_budget(measured, read), *_of_skew(measured, read)),
            name=PHASE_90,
            label=label,
            value=read.value,
            unit="Hz",
            condition="",
            not_included=missing_of_phase(measured.sampling),
        )

    return evaluated(found, PHASE_90, label, "Hz")


def _of_skew(measured: MeasuredResponse, read: Reading) -> Iterator[Contribution]:
    skew_s = measured.sampling.skew_uncertainty_s
    if skew_s:
        slope = abs(float(measured.curve.phase.value(np.array([read.value]), derivative=1)[0]))
        per_s = _TURN_DEG * read.value / slope
        sensitivity = f"{plain(per_s * 1e-6, 3)} Hz/µs"
        yield rectangular("skew of the channels", engineering(skew_s, "s"), sensitivity, per_s * skew_s)


def _certainly_less(measured: MeasuredResponse) -> float:
    """Return up to where the phase certainly (97.5 %) lags by less than 90°."""
    curve = measured.curve.phase
    grid = np.linspace(measured.curve.low_hz, measured.curve.high_hz, _GRID)
    skew_s = (measured.sampling.skew_uncertainty_s or 0.0) / math.sqrt(3.0)
    uncertainty = np.hypot(curve.uncertainty(curve.rows(grid)), _TURN_DEG * grid * skew_s)
    return _before(grid, curve.value(grid) - NORMAL_95 * uncertainty <= -90.0)


def _not_reached(
    measured: MeasuredResponse, name: str, label: str, condition: str, lowest_hz: float
) -> Result:
    """Return the end of the band as a lower bound: nothing is extrapolated (S4.6)."""
    told = "not reached within the band"
    return Result(
        name=name,
        label=label,
        value=measured.curve.high_hz,
        unit="Hz",
        lower_95=lowest_hz,
        at_least=True,
        condition=f"{condition}; {told}" if condition else told,
        not_included=missing_of_phase(measured.sampling) if name == PHASE_90 else (),
    )


def _delay_result(measured: MeasuredResponse, parameters: RandomVibrationParameters) -> Result:
    label, reference_hz = LABELS[GROUP_DELAY], parameters.reference_hz

    def found() -> Result:
        read = group_delay(measured.curve, frequency_hz=reference_hz)
        skew_s = measured.sampling.skew_uncertainty_s
        by_skew = (
            (rectangular("skew of the channels", engineering(skew_s, "s"), "1", skew_s * 1e3),)
            if skew_s
            else ()
        )
        return budgeted_result(
            (*_in_ms(delay_budget(measured, read, reference_hz)), *by_skew),
            name=GROUP_DELAY,
            label=label,
            value=read.value * 1e3,
            unit="ms",
            condition=f"at {plain(reference_hz, 6)} Hz",
            not_included=missing_of_phase(measured.sampling),
        )

    return evaluated(found, GROUP_DELAY, label, "ms")


def _in_ms(budget: tuple[Contribution, ...]) -> Iterator[Contribution]:
    for one in budget:
        yield replace(one, standard_uncertainty=one.standard_uncertainty * 1e3)
