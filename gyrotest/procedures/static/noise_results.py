"""Bias stability, Allan minimum, bias instability coefficient and angle random walk as results."""

import math
from dataclasses import dataclass

import numpy as np

from gyrotest.analysis.allan import (
    FLAT,
    AllanDeviation,
    allan_deviation,
    default_factors,
    overlapping_allan_deviation,
)
from gyrotest.analysis.dead_time import dead_time_correction
from gyrotest.analysis.noise import NoiseModel, fitted_factors, identify_noise
from gyrotest.analysis.smoothing import smoothed_deviation
from gyrotest.procedures.static.parameters import StaticParameters, stability_name
from gyrotest.procedures.static.record import StaticRecord
from gyrotest.procedures.static.spread import Spread, spread_result
from gyrotest.procedures.static.wording import engineering, freedom, plain
from gyrotest.records.plan import Context
from gyrotest.records.result import Result
from gyrotest.units import Quantity

DPH = 3600.0
PER_ROOT_HOUR = 60.0
FEWEST_FREEDOM = 10.0
_ROOT_3 = math.sqrt(3.0)


@dataclass(frozen=True, slots=True, kw_only=True)
class NoiseAnalysis:
    """A record's Allan deviations and noise model."""

    overlapping: AllanDeviation
    classic: AllanDeviation
    model: NoiseModel


@dataclass(frozen=True, slots=True, kw_only=True)
class Minimum:
    """The lowest point of an Allan deviation; `reached` where the curve rises on both sides of it."""

    place: int
    tau_s: float
    spread_dps: Spread

    @property
    def reached(self) -> bool:
        """Whether the floor was reached."""
        return not self.spread_dps.at_most


def analyse_noise(record: StaticRecord) -> NoiseAnalysis:
    """Compute both Allan deviations and fit the noise model."""
    rate_hz = 1.0 / record.interval_s
    shown = default_factors(record.rate_dps.size)
    wanted = np.union1d(shown, fitted_factors(record.rate_dps.size))
    curve = overlapping_allan_deviation(
        record.rate_dps, sample_rate_hz=rate_hz, averaging_factors=[int(m) for m in wanted]
    )
    model = identify_noise(
        record.rate_dps, sample_rate_hz=rate_hz, duty=record.sampling.duty, deviation=curve
    )
    classic = allan_deviation(record.rate_dps, sample_rate_hz=rate_hz)
    return NoiseAnalysis(overlapping=curve.at(shown), classic=classic, model=model)


def stability_result(
    record: StaticRecord,
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


def find_minimum(noise: NoiseAnalysis) -> Minimum | None:
    """Find the lowest point where the degrees of freedom are at least 10; None where they never are.

    Averaging times that the noise model leaves out do not count: a low-pass filter makes the curve
    fall towards them, without the bias being any stabler.
    """
    curve = noise.overlapping
    described = curve.tau_s >= noise.model.first_tau_s * (1.0 - 1e-9)
    admissible = np.flatnonzero((curve.edf >= FEWEST_FREEDOM) & described)
    if not admissible.size:
        return None
    place = int(admissible[np.argmin(curve.deviation_dps[admissible])])
    bounds = curve.bounds_dps(0.95)
    return Minimum(
        place=place,
        tau_s=float(curve.tau_s[place]),
        spread_dps=Spread(
            value=float(curve.deviation_dps[place]),
            lower=float(bounds.lower[place]),
            upper=float(bounds.upper[place]),
            at_most=place in (int(admissible[0]), int(admissible[-1])),
        ),
    )


def minimum_results(record: StaticRecord, noise: NoiseAnalysis, context: Context) -> tuple[Result, ...]:
    """Return the Allan minimum and the coefficient B = minimum/0.6643 (IEEE 952)."""
    names = (
        ("allan_minimum", "Allan deviation, minimum", 1.0, ""),
        ("bias_instability_coefficient", "Bias instability coefficient", 1.0 / FLAT, "minimum/0.6643"),
    )
    minimum = find_minimum(noise)
    if minimum is None:
        reason = f"nowhere {FEWEST_FREEDOM:g} degrees of freedom: the record is too short"
        return tuple(not_evaluated(name, label, "deg/h", reason) for name, label, _, _ in names)
    floor = "" if minimum.reached else "floor not reached"
    return tuple(
        spread_result(
            minimum.spread_dps.times(DPH * factor),
            name=name,
            label=label,
            unit="deg/h",
            condition=_joined(
                note, f"at τ = {plain(minimum.tau_s, 3)} s", floor, record.condition, duty_note(record)
            ),
            context=context,
        )
        for name, label, factor, note in names
    )


def walk_results(record: StaticRecord, model: NoiseModel, context: Context) -> tuple[Result, ...]:
    """Return the angle random walk, corrected for dead time, and as read."""
    apparent = _apparent(record, model)
    fitted = f"fit over τ = {plain(model.first_tau_s, 3)} s … {plain(model.last_tau_s, 3)} s"
    if apparent.at_most:
        fitted = f"not resolved; {fitted}"
    as_read = spread_result(
        apparent,
        name="angle_random_walk_apparent",
        label="Angle random walk, as read",
        unit="deg/sqrt(h)",
        condition=_joined(fitted, record.condition, duty_note(record)),
        context=context,
        missing=_unknown_noise(record, context),
    )
    return (_corrected(record, apparent, fitted, context), as_read)


def _apparent(record: StaticRecord, model: NoiseModel) -> Spread:
    """Return N in °/√h; the lower end allows for the share that the meter's own noise may have."""
    term = model.angle_random_walk
    if not term.resolved:
        return Spread(value=term.upper_95, lower=0.0, upper=term.upper_95, at_most=True).times(
            PER_ROOT_HOUR
        )
    meter = 0.0 if record.floor_dps is None else record.floor_dps * math.sqrt(record.interval_s)
    share = term.value - math.sqrt(max(term.value**2 - meter**2, 0.0))
    lower = term.value - math.hypot(term.value - term.lower_95, share)
    return Spread(value=term.value, lower=max(lower, 0.0), upper=term.upper_95).times(PER_ROOT_HOUR)


def _corrected(record: StaticRecord, apparent: Spread, fitted: str, context: Context) -> Result:
    sampling, bandwidth = record.sampling, context.output.bandwidth
    correction = dead_time_correction(
        reading_s=sampling.effective_aperture_s / sampling.readings,
        spacing_s=sampling.interval_s / sampling.readings,
        bandwidth_hz=None if bandwidth is None else bandwidth.to("Hz"),
    )
    name, label, unit = "angle_random_walk", "Angle random walk", "deg/sqrt(h)"
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


def _unknown_noise(record: StaticRecord, context: Context) -> tuple[str, ...]:
    """Name the meter's share of the noise, where there is a meter and its noise is not known."""
    unknown = record.floor_dps is None and context.accuracy is not None
    return ("noise of the meter",) if unknown else ()


def not_evaluated(name: str, label: str, unit: str, reason: str) -> Result:
    """Return a result without a value, and why: no limit on it can pass."""
    return Result(name=name, label=label, value=None, unit=unit, condition=reason)


def duty_note(record: StaticRecord) -> str:
    """Say that a record has dead time, where it has."""
    duty = record.sampling.duty
    return "" if duty >= 1.0 - 1e-9 else f"dead time, duty {plain(duty, 3)}"


def _joined(*parts: str) -> str:
    return "; ".join(part for part in parts if part)
