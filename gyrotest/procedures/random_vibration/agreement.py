"""How far the response by random vibration agrees with that by sines: frequency by frequency, and at most."""

import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace

import numpy as np

from gyrotest.analysis.extremes import largest_magnitude
from gyrotest.procedures.random_vibration.measurands import AMPLITUDE_AGREEMENT, LABELS, PHASE_AGREEMENT
from gyrotest.procedures.random_vibration.measured import MeasuredResponse
from gyrotest.procedures.random_vibration.parameters import RandomVibrationParameters
from gyrotest.procedures.random_vibration.pointwise import phase_result, sensitivity_result
from gyrotest.procedures.uncertainty import expanded
from gyrotest.procedures.vibration_names import phase_name, sensitivity_name
from gyrotest.procedures.wording import plain
from gyrotest.records.plan import Context
from gyrotest.records.result import Contribution, Result
from gyrotest.units import conversion_factor

_SENSITIVITY = re.compile(r"sensitivity_(?P<hz>[0-9.]+)Hz")
_PERCENT, _HALF_TURN, _TURN = 100.0, 180.0, 360.0


@dataclass(frozen=True, slots=True, kw_only=True)
class Difference:
    """Random less sine at a frequency, with its standard uncertainty; what errs alike in both is left out."""

    frequency_hz: float
    random: float
    sine: float
    value: float
    standard: float
    freedom: float
    unit: str


@dataclass(frozen=True, slots=True, kw_only=True)
class Agreement:
    """Differences of the sensitivity in %, of the phase in °; `reason` says why there are none."""

    case: str | None
    amplitude: tuple[Difference, ...] = ()
    phase: tuple[Difference, ...] = ()
    reason: str = ""


def agreement_with(measured: MeasuredResponse, context: Context) -> Agreement:
    """Compare with the earlier case that the parameters name, at its frequencies within the band."""
    parameters: RandomVibrationParameters = context.parameters
    case = parameters.compare_with
    if case is None:
        return Agreement(case=None, reason="nothing to compare with; see 'parameters.compare_with'")
    earlier = _by_name(context.earlier.get(case, ()))
    there = [float(match["hz"]) for name in earlier if (match := _SENSITIVITY.fullmatch(name))]
    if not there:
        reason = (
            f"case '{case}' has no sensitivities (yet); put it before this case, and see that it is measured; once"
            " it is, 'gyrotest judge' compares them"
        )
        return Agreement(case=case, reason=reason)
    common = sorted(one for one in there if measured.curve.low_hz <= one <= measured.curve.high_hz)
    if not common:
        reason = f"case '{case}' has no frequency within {measured.curve.low_hz:g} … {measured.curve.high_hz:g} Hz"
        return Agreement(case=case, reason=reason)
    return Agreement(
        case=case,
        amplitude=tuple(_amplitudes(measured, earlier, common, context)),
        phase=tuple(_phases(measured, earlier, common)),
    )


def agreement_results(agreement: Agreement) -> Iterator[Result]:
    """Give the largest differences, with intervals that noise has not made larger."""
    if agreement.case is None:
        return
    yield _largest(agreement, agreement.amplitude, AMPLITUDE_AGREEMENT, "%")
    yield _largest(agreement, agreement.phase, PHASE_AGREEMENT, "deg")


def _largest(agreement: Agreement, all_of_it: tuple[Difference, ...], name: str, unit: str) -> Result:
    label = LABELS[name]
    if not all_of_it:
        return Result(name=name, label=label, value=None, unit=unit, condition=agreement.reason)
    found = largest_magnitude(
        np.array([one.value for one in all_of_it]),
        standard=np.array([one.standard for one in all_of_it]),
        freedom=np.array([one.freedom for one in all_of_it]),
    )
    worst = max(all_of_it, key=lambda one: abs(one.value))
    count = len(all_of_it)
    return Result(
        name=name,
        label=label,
        value=found.value,
        unit=unit,
        lower_95=found.lower_95,
        upper_95=found.upper_95,
        condition=f"with case '{agreement.case}', {count} frequenc{'ies' if count > 1 else 'y'}; largest at"
        f" {plain(worst.frequency_hz, 5)} Hz",
    )


def _by_name(results: tuple[Result, ...]) -> dict[str, Result]:
    """Return results by their names, of several repeats the last; without those that have no value."""
    return {one.name: one for one in results if one.value is not None}


def _amplitudes(
    measured: MeasuredResponse, earlier: Mapping[str, Result], common: list[float], context: Context
) -> Iterator[Difference]:
    for frequency_hz in common:
        own = sensitivity_result(measured, frequency_hz, context)
        other = earlier[sensitivity_name(frequency_hz)]
        if not own.value or not other.value:
            continue
        sine = other.value * conversion_factor(other.unit, own.unit)
        budgets = _apart(own, other)
        combined = expanded(
            (
                *(_times(one, _PERCENT / abs(own.value)) for one in budgets.own),
                *(_times(one, _PERCENT / abs(other.value)) for one in budgets.other),
            )
        )
        yield Difference(
            frequency_hz=frequency_hz,
            random=own.value,
            sine=sine,
            value=_PERCENT * (own.value / sine - 1.0),
            standard=combined.standard,
            freedom=combined.freedom,
            unit=own.unit,
        )


def _phases(
    measured: MeasuredResponse, earlier: Mapping[str, Result], common: list[float]
) -> Iterator[Difference]:
    for frequency_hz in common:
        own = phase_result(measured, frequency_hz)
        other = earlier.get(phase_name(frequency_hz))
        if own.value is None or other is None or other.value is None:
            continue
        factor = conversion_factor(other.unit, own.unit)
        budgets = _apart(own, other)
        combined = expanded((*budgets.own, *(_times(one, factor) for one in budgets.other)))
        yield Difference(
            frequency_hz=frequency_hz,
            random=own.value,
            sine=other.value * factor,
            value=_wrapped(own.value - other.value * factor),
            standard=combined.standard,
            freedom=combined.freedom,
            unit=own.unit,
        )


@dataclass(frozen=True, slots=True, kw_only=True)
class _Budgets:
    own: tuple[Contribution, ...]
    other: tuple[Contribution, ...]


def _apart(own: Result, other: Result) -> _Budgets:
    """Leave out what both have in common: the same error of the source, of the encoder, of the skew."""
    systematic = {one.source for one in own.budget if one.kind == "B"}
    same = systematic & {one.source for one in other.budget}
    return _Budgets(
        own=tuple(one for one in own.budget if one.source not in same),
        other=tuple(one for one in other.budget if one.source not in same),
    )


def _times(one: Contribution, factor: float) -> Contribution:
    return replace(one, standard_uncertainty=one.standard_uncertainty * factor)


def _wrapped(phase_deg: float) -> float:
    return (phase_deg + _HALF_TURN) % _TURN - _HALF_TURN
