"""Bias stability, Allan minimum and the coefficients of the fitted noise model as results."""

import math
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from gyrotest.analysis.allan import (
    AllanDeviation,
    allan_deviation,
    default_factors,
    overlapping_allan_deviation,
)
from gyrotest.analysis.dead_time import dead_time_correction
from gyrotest.analysis.minimum import FEWEST_FREEDOM, AllanMinimum, allan_minimum
from gyrotest.analysis.noise import NoiseModel, fitted_factors, identify_noise
from gyrotest.analysis.smoothing import smoothed_deviation
from gyrotest.procedures.rest.record import RestRecord
from gyrotest.procedures.rest.spread import Spread, spread_result
from gyrotest.procedures.static.parameters import StaticParameters, stability_name
from gyrotest.procedures.static.terms import (
    ANGLE_WALK,
    BIAS_INSTABILITY,
    QUANTIZATION,
    RAMP,
    RATE_WALK,
    Term,
)
from gyrotest.procedures.wording import engineering, freedom, plain
from gyrotest.records.plan import Context
from gyrotest.records.result import Result
from gyrotest.units import Quantity

DPH = 3600.0
_WHOLE = 1e-6
_ROOT_3 = math.sqrt(3.0)


@dataclass(frozen=True, slots=True, kw_only=True)
class NoiseAnalysis:
    """A record's Allan deviations, its noise model, and the curve's lowest point (None: too short for one)."""

    overlapping: AllanDeviation
    classic: AllanDeviation
    model: NoiseModel
    minimum: AllanMinimum | None


def analyse_noise(record: RestRecord) -> NoiseAnalysis:
    """Compute both Allan deviations and fit the noise model."""
    rate_hz = 1.0 / record.interval_s
    shown = _shown_factors(record)
    wanted = np.union1d(shown, fitted_factors(record.rate_dps.size))
    curve = overlapping_allan_deviation(
        record.rate_dps, sample_rate_hz=rate_hz, averaging_factors=[int(m) for m in wanted]
    )
    model = identify_noise(
        record.rate_dps, sample_rate_hz=rate_hz, duty=record.sampling.duty, deviation=curve
    )
    classic = allan_deviation(record.rate_dps, sample_rate_hz=rate_hz)
    drawn = curve.at(shown)
    return NoiseAnalysis(
        overlapping=drawn,
        classic=classic,
        model=model,
        minimum=allan_minimum(drawn, first_tau_s=model.first_tau_s),
    )


def _shown_factors(record: RestRecord) -> NDArray[np.int64]:
    """Return the averaging factors that are drawn: log-spaced, and those of 1 s, 10 s, … where there are such."""
    factors = default_factors(record.rate_dps.size)
    first, last = np.log10(factors[[0, -1]] * record.interval_s)
    decades = 10.0 ** np.arange(math.ceil(first - _WHOLE), math.floor(last + _WHOLE) + 1)
    intervals = decades / record.interval_s
    whole = np.abs(intervals - np.rint(intervals)) <= _WHOLE * intervals
    named: NDArray[np.int64] = np.rint(intervals[whole]).astype(np.int64)
    return np.union1d(factors, named)


def stability_result(
    record: RestRecord,
    model: NoiseModel,
    smoothing: Quantity,
    parameters: StaticParameters,
    context: Context,
) -> Result:
    """Return the standard deviation of the averages over one smoothing time."""
    name, label = stability_name(smoothing), f"Bias stability, {smoothing} averages"
    rate = record.rate_dps if parameters.start is None else record.since(parameters.start.to("s"))
    size = round(smoothing.to("s") / record.interval_s)
    if rate.size < 2 * size:
        counted = plain(rate.size * record.interval_s, 6)
        reason = f"the {counted} s that count hold no two averages of {smoothing}"
        return not_evaluated(name, label, "deg/h", reason)
    found = smoothed_deviation(rate, samples_per_average=size, model=model)
    spread = Spread(value=found.deviation_dps, lower=found.lower_95_dps, upper=found.upper_95_dps)
    return spread_result(
        spread.times(DPH),
        name=name,
        label=label,
        unit="deg/h",
        condition=_joined(
            f"{found.averages} averages",
            freedom(found.edf),
            "" if parameters.start is None else f"from {parameters.start} on",
            record.condition,
            duty_note(record),
        ),
        context=context,
    )


def minimum_result(record: RestRecord, noise: NoiseAnalysis, context: Context) -> Result:
    """Return the Allan minimum: the lowest point of the curve where it is certain enough."""
    name, label, unit = "allan_minimum", "Allan deviation, minimum", "deg/h"
    lowest = noise.minimum
    if lowest is None:
        reason = f"nowhere {FEWEST_FREEDOM:g} degrees of freedom: the record is too short"
        return not_evaluated(name, label, unit, reason)
    spread = Spread(
        value=lowest.deviation_dps,
        lower=lowest.lower_95_dps,
        upper=lowest.upper_95_dps,
        at_most=not lowest.reached,
    )
    floor = "" if lowest.reached else "floor not reached"
    at = f"at τ = {plain(lowest.tau_s, 3)} s"
    return spread_result(
        spread.times(DPH),
        name=name,
        label=label,
        unit=unit,
        condition=_joined(at, floor, record.condition, duty_note(record)),
        context=context,
    )


def coefficient_results(record: RestRecord, model: NoiseModel, context: Context) -> tuple[Result, ...]:
    """Return the model's five coefficients, the angle random walk corrected for dead time and as read."""
    return (
        _fitted_result(BIAS_INSTABILITY, record, model, context),
        *_walk_results(record, model, context),
        *(_fitted_result(one, record, model, context) for one in (RATE_WALK, RAMP, QUANTIZATION)),
    )


def _fitted_result(term: Term, record: RestRecord, model: NoiseModel, context: Context) -> Result:
    """Return a coefficient as fitted, or as an upper limit where the record does not resolve it."""
    return spread_result(
        term.spread(model),
        name=term.name,
        label=term.label,
        unit=term.unit,
        condition=_joined(_fit_note(term, model), record.condition, duty_note(record)),
        context=context,
    )


def _fit_note(term: Term, model: NoiseModel) -> str:
    """Say which averaging times were fitted, and that they do not resolve the term where they do not."""
    fitted = f"fit over τ = {plain(model.first_tau_s, 3)} s … {plain(model.last_tau_s, 3)} s"
    return fitted if term.of(model).resolved else f"not resolved; {fitted}"


def _walk_results(record: RestRecord, model: NoiseModel, context: Context) -> tuple[Result, ...]:
    """Return the angle random walk, corrected for dead time, and as read."""
    apparent = _apparent(record, model)
    fitted = _fit_note(ANGLE_WALK, model)
    as_read = spread_result(
        apparent,
        name="angle_random_walk_apparent",
        label="Angle random walk, as read",
        unit=ANGLE_WALK.unit,
        condition=_joined(fitted, record.condition, duty_note(record)),
        context=context,
        missing=_unknown_noise(record, context),
    )
    return (_corrected(record, apparent, fitted, context), as_read)


def _apparent(record: RestRecord, model: NoiseModel) -> Spread:
    """Return N; the lower end allows for the share that the meter's own noise may have."""
    spread = ANGLE_WALK.spread(model)
    if spread.at_most or record.floor_dps is None:
        return spread
    meter = record.floor_dps * math.sqrt(record.interval_s) * ANGLE_WALK.per_core
    share = spread.value - math.sqrt(max(spread.value**2 - meter**2, 0.0))
    lower = spread.value - math.hypot(spread.value - spread.lower, share)
    return replace(spread, lower=max(lower, 0.0))


def _corrected(record: RestRecord, apparent: Spread, fitted: str, context: Context) -> Result:
    sampling, bandwidth = record.sampling, context.output.bandwidth
    correction = dead_time_correction(
        reading_s=sampling.effective_aperture_s / sampling.readings,
        spacing_s=sampling.interval_s / sampling.readings,
        bandwidth_hz=None if bandwidth is None else bandwidth.to("Hz"),
    )
    name, label, unit = ANGLE_WALK.name, ANGLE_WALK.label, ANGLE_WALK.unit
    if correction is None:
        needed = engineering(1.0 / (2.0 * sampling.aperture_s), "Hz", 3)
        found = "not known" if bandwidth is None else f"{bandwidth}"
        reason = (
            f"dead time (duty {plain(sampling.duty, 3)}) cannot be corrected:"
            f" the bandwidth must exceed {needed} and is {found}"
        )
        return not_evaluated(name, label, unit, reason)
    corrected = apparent.times(correction.factor).widened(correction.half_width / _ROOT_3)
    note = "" if correction.factor == 1.0 else f"dead time corrected, duty {plain(sampling.duty, 3)}"
    return spread_result(
        corrected,
        name=name,
        label=label,
        unit=unit,
        condition=_joined(fitted, note, record.condition),
        context=context,
        missing=_unknown_noise(record, context),
    )


def _unknown_noise(record: RestRecord, context: Context) -> tuple[str, ...]:
    """Name the meter's share of the noise, where there is a meter and its noise is not known."""
    unknown = record.floor_dps is None and context.accuracy is not None
    return ("noise of the meter",) if unknown else ()


def not_evaluated(name: str, label: str, unit: str, reason: str) -> Result:
    """Return a result without a value, and why: no limit on it can pass."""
    return Result(name=name, label=label, value=None, unit=unit, condition=reason)


def duty_note(record: RestRecord) -> str:
    """Say that a record has dead time, where it has."""
    duty = record.sampling.duty
    return "" if duty >= 1.0 - 1e-9 else f"dead time, duty {plain(duty, 3)}"


def _joined(*parts: str) -> str:
    return "; ".join(part for part in parts if part)
