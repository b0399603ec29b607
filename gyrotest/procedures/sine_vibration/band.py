"""What the frequencies give together: flatness, the −3 dB bandwidth, the frequency of −90° phase."""

import math
from collections.abc import Iterator, Sequence

import numpy as np

from gyrotest.analysis.crossing import Crossing, first_fall
from gyrotest.analysis.interval import NORMAL_95
from gyrotest.analysis.response_curve import HALF_POWER
from gyrotest.procedures.sine_vibration.measured import MeasuredSines, SinePoint
from gyrotest.procedures.sine_vibration.parameters import SineVibrationParameters
from gyrotest.procedures.sine_vibration.uncertainty import (
    distortion_share,
    missing_of_angle,
    phase_budget,
)
from gyrotest.procedures.uncertainty import budgeted_result, by_statistics, expanded, rectangular
from gyrotest.procedures.vibration_names import BAND_LABELS, BANDWIDTH, FLATNESS, PHASE_90
from gyrotest.procedures.wording import plain
from gyrotest.records.result import Contribution, Result

LOST_IN_NOISE = "the output's sine is not told from its noise: raise the level, or sample longer"
"""Why a point has no value."""

_QUARTER_DEG = -90.0
_PERCENT = 100.0
_ROOT_3 = math.sqrt(3.0)
_MINUS = "\N{MINUS SIGN}"


def band_results(measured: MeasuredSines, parameters: SineVibrationParameters) -> Iterator[Result]:
    """Give what the whole band tells; nothing is extrapolated (S4.6)."""
    if len(measured.points) < 2:
        reason = "a single frequency does not tell; see 'parameters.frequencies'"
        for name, unit in ((FLATNESS, "%"), (BANDWIDTH, "Hz"), (PHASE_90, "Hz")):
            yield _without(name, unit, reason)
        return
    yield _flatness_result(measured, parameters)
    yield _bandwidth_result(measured, parameters)
    yield _phase_90_result(measured)


def bandwidth_crossing(measured: MeasuredSines, reference_hz: float) -> Crossing | None:
    """Find where the gain falls through 1/√2 of that at the reference, Hz."""
    above = _from(measured, reference_hz)
    log_gain = np.log([one.response.gain for one in above])
    return first_fall(_driven_hz(above), log_gain, level=float(log_gain[0]) + HALF_POWER)


def quarter_crossing(measured: MeasuredSines) -> Crossing | None:
    """Find where the phase falls through −90°, Hz."""
    phases = np.array([one.phase_deg for one in measured.points])
    return first_fall(_driven_hz(measured.points), phases, level=_QUARTER_DEG)


def _from(measured: MeasuredSines, reference_hz: float) -> tuple[SinePoint, ...]:
    reference = measured.at(reference_hz)
    return measured.points[measured.points.index(reference) :]


def _driven_hz(points: Sequence[SinePoint]) -> np.ndarray:
    return np.array([one.response.frequency_hz for one in points])


def _flatness_result(measured: MeasuredSines, parameters: SineVibrationParameters) -> Result:
    to_hz, reference_hz = parameters.flat_to_hz, parameters.reference_hz
    within = [one for one in measured.points if one.asked_hz <= to_hz]
    if len(within) < 2:
        reason = f"only one frequency up to {plain(to_hz, 6)} Hz; see 'parameters.flat_to'"
        return _without(FLATNESS, "%", reason)
    if lost := _lost(within):
        return _without(FLATNESS, "%", lost)
    highest = max(within, key=lambda one: one.response.gain)
    lowest = min(within, key=lambda one: one.response.gain)
    reference = measured.at(reference_hz).response.gain
    budget = tuple(
        line
        for which, one in (("highest", highest), ("lowest", lowest))
        for line in _of_point(measured, one, which, _PERCENT * one.response.gain / reference)
    )
    return budgeted_result(
        budget,
        name=FLATNESS,
        label=BAND_LABELS[FLATNESS],
        value=_PERCENT * (highest.response.gain - lowest.response.gain) / reference,
        unit="%",
        condition=f"highest ({plain(highest.asked_hz, 6)} Hz) less lowest ({plain(lowest.asked_hz, 6)} Hz) of"
        f" {len(within)} frequencies up to {plain(to_hz, 6)} Hz, of that at {plain(reference_hz, 6)} Hz",
        not_included=(),
    )


def _of_point(
    measured: MeasuredSines, point: SinePoint, which: str, factor: float
) -> Iterator[Contribution]:
    """Give what a single gain errs by, apart from what all err by alike."""
    response = point.response
    standard = factor * response.relative_uncertainty
    yield by_statistics(f"noise, {which} sensitivity", standard, response.degrees_of_freedom)
    share = distortion_share(measured, point)
    if share > 0.0:
        yield by_statistics(f"encoder, distortion of its signals, {which} sensitivity", share * factor)


def _bandwidth_result(measured: MeasuredSines, parameters: SineVibrationParameters) -> Result:
    reference_hz = parameters.reference_hz
    condition = f"{_MINUS}3 dB of the sensitivity at {plain(reference_hz, 6)} Hz"
    above = _from(measured, reference_hz)
    found = bandwidth_crossing(measured, reference_hz)
    if lost := _lost(_to_the_crossing(above, found)):
        return _without(BANDWIDTH, "Hz", lost)
    if found is None:
        return _not_reached(measured, BANDWIDTH, condition, _certainly_above(above), ())
    value, per = found.x, 1.0 / abs(found.slope)
    nearer = _noisier(above, found)
    budget = (
        *_of_point(measured, above[0], "reference", per),
        *_of_point(measured, nearer, "falling", per),
        _of_interpolation(found),
    )
    return budgeted_result(
        budget,
        name=BANDWIDTH,
        label=BAND_LABELS[BANDWIDTH],
        value=value,
        unit="Hz",
        condition=f"{condition}; {_between(above, found)}",
        not_included=(),
    )


def _phase_90_result(measured: MeasuredSines) -> Result:
    first, found = measured.points[0], quarter_crossing(measured)
    missing = missing_of_angle(measured)
    if lost := _lost(_to_the_crossing(measured.points, found)):
        return _without(PHASE_90, "Hz", lost)
    if first.phase_deg < _QUARTER_DEG:
        reason = f"below {plain(first.asked_hz, 6)} Hz, where the phase is beyond {_MINUS}90° already"
        return _without(PHASE_90, "Hz", reason)
    if found is None:
        return _not_reached(measured, PHASE_90, "", _certainly_less(measured), missing)
    value, per = found.x, 1.0 / abs(found.slope)
    nearer = _noisier(measured.points, found)
    budget = (
        *(_scaled(one, per) for one in phase_budget(measured, nearer)),
        _of_interpolation(found),
    )
    return budgeted_result(
        budget,
        name=PHASE_90,
        label=BAND_LABELS[PHASE_90],
        value=value,
        unit="Hz",
        condition=_between(measured.points, found),
        not_included=missing,
    )


def _scaled(line: Contribution, per: float) -> Contribution:
    """Return a line of a phase's budget as one of a frequency's."""
    standard = line.standard_uncertainty * per
    if line.kind == "A":
        return by_statistics(line.source, standard, line.degrees_of_freedom)
    half_width = f"{plain(line.standard_uncertainty * _ROOT_3, 2)}°"
    return rectangular(line.source, half_width, f"{plain(per, 3)} Hz/°", standard * _ROOT_3)


def _to_the_crossing(points: Sequence[SinePoint], found: Crossing | None) -> Sequence[SinePoint]:
    """Return what a crossing rests on: every point up to the second beyond it."""
    return points if found is None else points[: found.place + 3]


def _lost(points: Sequence[SinePoint]) -> str:
    """Say at which frequencies there is nothing but noise; empty where there are none."""
    lost = [plain(one.asked_hz, 6) for one in points if not one.told]
    return f"at {', '.join(lost)} Hz {LOST_IN_NOISE}" if lost else ""


def _noisier(points: Sequence[SinePoint], found: Crossing) -> SinePoint:
    beside = points[found.place : found.place + 2]
    return max(beside, key=lambda one: one.response.relative_uncertainty)


def _of_interpolation(found: Crossing) -> Contribution:
    half_width = f"{plain(found.half_width, 2)} Hz"
    return rectangular("interpolation between the frequencies", half_width, "1", found.half_width)


def _between(points: Sequence[SinePoint], found: Crossing) -> str:
    below, above = points[found.place], points[found.place + 1]
    return f"between {plain(below.asked_hz, 6)} and {plain(above.asked_hz, 6)} Hz"


def _certainly_above(points: Sequence[SinePoint]) -> float:
    """Return the highest frequency up to which every gain is certainly (97.5 %) above its −3 dB."""
    reference, certain_hz = points[0], points[0].asked_hz
    for one in points[1:]:
        change = math.log(one.response.gain / reference.response.gain)
        noise = math.hypot(one.response.relative_uncertainty, reference.response.relative_uncertainty)
        if change - NORMAL_95 * noise <= HALF_POWER:
            break
        certain_hz = one.asked_hz
    return certain_hz


def _certainly_less(measured: MeasuredSines) -> float:
    """Return the highest frequency up to which every phase certainly lags by less than 90°."""
    certain_hz = measured.points[0].asked_hz
    for one in measured.points[1:]:
        if one.phase_deg - expanded(phase_budget(measured, one)).uncertainty <= _QUARTER_DEG:
            break
        certain_hz = one.asked_hz
    return certain_hz


def _not_reached(
    measured: MeasuredSines,
    name: str,
    condition: str,
    certain_hz: float,
    missing: tuple[str, ...],
) -> Result:
    """Return the highest frequency as a lower bound."""
    told = "not reached by the highest frequency"
    return Result(
        name=name,
        label=BAND_LABELS[name],
        value=measured.points[-1].response.frequency_hz,
        unit="Hz",
        lower_95=certain_hz,
        at_least=True,
        condition=f"{condition}; {told}" if condition else told,
        not_included=missing,
    )


def _without(name: str, unit: str, reason: str) -> Result:
    return Result(name=name, label=BAND_LABELS[name], value=None, unit=unit, condition=reason)
