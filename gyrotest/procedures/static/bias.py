"""The bias with its uncertainty budget, and its spread over repeats."""

import math
from collections.abc import Iterator

import numpy as np

from gyrotest.analysis.earth import EARTH_RATE_DPS, earth_share_dps
from gyrotest.analysis.interval import coverage_factor, deviation_bounds
from gyrotest.analysis.mean import mean_uncertainty
from gyrotest.analysis.noise import NoiseModel
from gyrotest.errors import InsufficientDataError
from gyrotest.procedures.static.parameters import run_to_run_name
from gyrotest.procedures.static.record import StaticRecord
from gyrotest.procedures.static.spread import Spread, spread_result
from gyrotest.records.plan import Context
from gyrotest.records.result import Contribution, Result
from gyrotest.records.spec import OutputKind
from gyrotest.units import conversion_factor

_ROOT_3 = math.sqrt(3.0)


def bias_result(record: StaticRecord, model: NoiseModel, context: Context) -> Result:
    """Return the mean rate less the Earth's share, with its budget (GUM, JCGM 100)."""
    mean_dps = float(record.rate_dps.mean())
    share_dps = _earth_share_dps(context)
    budget = (
        _statistical(record, model, context),
        *_of_scale(mean_dps, record, context),
        *_of_earth(share_dps),
    )
    combined = math.sqrt(sum(one.standard_uncertainty**2 for one in budget))
    factor = coverage_factor(_effective_freedom(budget, combined))
    return Result(
        name="bias",
        label="Bias",
        value=mean_dps - (share_dps or 0.0),
        unit="deg/s",
        expanded_uncertainty=factor * combined,
        coverage_factor=factor,
        condition=_condition(record, share_dps),
        budget=budget,
        not_included=tuple(_missing_contributions(record, context)),
    )


def _earth_share_dps(context: Context) -> float | None:
    site = context.site
    return earth_share_dps(
        context.case.mounting,
        latitude_deg=None if site is None else site.latitude.to("deg"),
        heading_deg=None if site is None or site.heading is None else site.heading.to("deg"),
    )


def _condition(record: StaticRecord, share_dps: float | None) -> str:
    parts = [f"mean over {record.duration_s:g} s", record.condition]
    if share_dps is None:
        parts.append("Earth's rate not subtracted: mounting, latitude or heading not known")
    else:
        parts.append(f"Earth's share {share_dps * 3600.0:.3g} °/h subtracted")
    return "; ".join(part for part in parts if part)


def _statistical(record: StaticRecord, model: NoiseModel, context: Context) -> Contribution:
    since_s = context.since_power_on_s
    if since_s is None:
        since_s = 0.0 if context.case.warm_up is None else context.case.warm_up.to("s")
    found = mean_uncertainty(
        model, duration_s=record.duration_s, since_power_on_s=since_s + record.begin_s
    )
    return Contribution(
        source=f"noise of the record, its Allan deviation carried to {record.duration_s:g} s",
        kind="A",
        distribution="normal",
        half_width="",
        sensitivity="1",
        standard_uncertainty=found.standard_uncertainty_dps,
        degrees_of_freedom=found.degrees_of_freedom,
    )


def _of_scale(mean_dps: float, record: StaticRecord, context: Context) -> Iterator[Contribution]:
    """Give the meter's accuracy, at the indication, and the scale factor's, at the rate."""
    scaling, accuracy = record.scaling, context.accuracy
    sensitivity = f"1/({abs(scaling.scale_factor):.4g} {scaling.unit}/(°/s))"
    if accuracy is not None:
        indication = abs(mean_dps * scaling.scale_factor + scaling.zero)
        half = accuracy.of_reading.to("") * indication
        yield _rectangular(
            f"meter, {accuracy.of_reading} of reading",
            half,
            scaling.unit,
            sensitivity,
            scaling.scale_factor,
        )
        if record.sampling.range is not None:
            half = accuracy.of_range.to("") * record.sampling.range * scaling.to_canonical
            yield _rectangular(
                f"meter, {accuracy.of_range} of range",
                half,
                scaling.unit,
                sensitivity,
                scaling.scale_factor,
            )
    if context.output.scale_factor_uncertainty is not None:
        relative = context.output.scale_factor_uncertainty.to("")
        yield Contribution(
            source="scale factor",
            kind="B",
            distribution="rectangular",
            half_width=f"{relative * 100.0:.3g} %",
            sensitivity=f"{abs(mean_dps):.4g} °/s",
            standard_uncertainty=abs(mean_dps) * relative / _ROOT_3,
        )


def _rectangular(
    source: str, half_width: float, unit: str, sensitivity: str, scale_factor: float
) -> Contribution:
    return Contribution(
        source=source,
        kind="B",
        distribution="rectangular",
        half_width=f"{half_width:.3g} {unit}",
        sensitivity=sensitivity,
        standard_uncertainty=half_width / abs(scale_factor) / _ROOT_3,
    )


def _of_earth(share_dps: float | None) -> Iterator[Contribution]:
    if share_dps is None:
        yield Contribution(
            source="Earth's rate, not subtracted",
            kind="B",
            distribution="rectangular",
            half_width=f"{EARTH_RATE_DPS * 3600.0:.3f} °/h",
            sensitivity="1",
            standard_uncertainty=EARTH_RATE_DPS / _ROOT_3,
        )


def _missing_contributions(record: StaticRecord, context: Context) -> Iterator[str]:
    if context.output.kind is OutputKind.VOLTAGE and context.accuracy is None:
        yield "accuracy of the meter"
    elif context.accuracy is not None and record.sampling.range is None:
        yield "accuracy of the meter's range (range not known)"
    if context.output.scale_factor_uncertainty is None:
        yield "uncertainty of the scale factor"


def _effective_freedom(budget: tuple[Contribution, ...], combined: float) -> float:
    """Welch–Satterthwaite, JCGM 100 eq. G.2b."""
    shares = sum(
        one.standard_uncertainty**4 / one.degrees_of_freedom
        for one in budget
        if one.degrees_of_freedom is not None
    )
    return combined**4 / shares if shares > 0.0 else math.inf


def bias_over_repeats(repeats: tuple[tuple[Result, ...], ...], context: Context) -> Result:
    """Return the sample standard deviation of the bias over repeats; raises `InsufficientDataError`."""
    biases_dph = [
        one.value * conversion_factor(one.unit, "deg/h")
        for results in repeats
        for one in results
        if one.name == "bias" and one.value is not None and math.isfinite(one.value)
    ]
    if len(biases_dph) < max(len(repeats), 2):
        raise InsufficientDataError(
            f"{context.case_name}: {len(biases_dph)} of {len(repeats)} repeats have a bias;"
            " its spread needs at least 2, and all of them"
        )
    deviation = float(np.std(biases_dph, ddof=1))
    bounds = deviation_bounds(deviation, len(biases_dph) - 1, confidence=0.95)
    name = run_to_run_name(context.case)
    cycled = name == "bias_repeatability"
    return spread_result(
        Spread(value=deviation, lower=float(bounds.lower), upper=float(bounds.upper)),
        name=name,
        label="Bias repeatability" if cycled else "Bias, run to run",
        unit="deg/h",
        condition=f"{len(biases_dph)} repeats, {'with' if cycled else 'without'} a power cycle between",
        context=context,
    )
