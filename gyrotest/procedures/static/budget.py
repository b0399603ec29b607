"""The uncertainty budget of the bias (GUM, JCGM 100): what contributes, and what could not be had."""

import math
from collections.abc import Iterator

from gyrotest.analysis.earth import EARTH_RATE_DPS
from gyrotest.analysis.mean import mean_uncertainty
from gyrotest.analysis.noise import NoiseModel
from gyrotest.analysis.resolution import mean_half_width
from gyrotest.procedures.static.record import StaticRecord
from gyrotest.procedures.wording import engineering, plain
from gyrotest.records.plan import Context
from gyrotest.records.result import Contribution
from gyrotest.records.spec import OutputKind
from gyrotest.units import Quantity, printed_unit

POINTING_DEG = 1.0
"""How far the sensitive axis is assumed to point from where mounting and site say."""

_ROOT_3 = math.sqrt(3.0)
_DPH = 3600.0
_MATTERS = 1e-3
_SMALL_DPS = 0.01


def bias_budget(
    record: StaticRecord, model: NoiseModel, mean_dps: float, share_dps: float | None, context: Context
) -> tuple[Contribution, ...]:
    """Return every contribution to the uncertainty of a bias, in °/s."""
    first = _statistical(record, model, context)
    return (
        first,
        *_of_meter(mean_dps, record, context),
        *_of_steps(record, first.standard_uncertainty),
        *_of_scale_factor(mean_dps, context),
        _of_earth(share_dps),
    )


def missing_contributions(record: StaticRecord, context: Context) -> Iterator[str]:
    """Give what could not be had of the budget of a bias."""
    accuracy = context.accuracy
    if context.output.kind is OutputKind.VOLTAGE and accuracy is None:
        yield "accuracy of the meter"
    elif accuracy is not None and record.sampling.range is None and accuracy.of_range.value != 0.0:
        yield "accuracy of the meter's range (range not known)"
    if context.output.scale_factor_uncertainty is None:
        yield "uncertainty of the scale factor"
    if context.since_power_on_s is None:
        yield "drift before the record (time of power-on not known)"


def _statistical(record: StaticRecord, model: NoiseModel, context: Context) -> Contribution:
    since_s = context.since_power_on_s
    if since_s is None:
        since_s = 0.0 if context.case.warm_up is None else context.case.warm_up.to("s")
    found = mean_uncertainty(
        model, duration_s=record.duration_s, since_power_on_s=since_s + record.begin_s
    )
    return Contribution(
        source=f"noise and drift over {plain(record.duration_s, 6)} s",
        kind="A",
        distribution="normal",
        half_width="",
        sensitivity="1",
        standard_uncertainty=found.standard_uncertainty_dps,
        degrees_of_freedom=found.degrees_of_freedom,
    )


def _of_meter(mean_dps: float, record: StaticRecord, context: Context) -> Iterator[Contribution]:
    """Give the meter's accuracy at the indication that was there."""
    scaling, accuracy = record.scaling, context.accuracy
    if accuracy is None:
        return
    indication = abs(mean_dps * scaling.scale_factor + scaling.zero)
    yield _of_indication("reading", accuracy.of_reading, indication, record)
    if record.sampling.range is not None:
        yield _of_indication(
            "range", accuracy.of_range, record.sampling.range * scaling.to_canonical, record
        )


def _of_indication(what: str, share: Quantity, of: float, record: StaticRecord) -> Contribution:
    scaling = record.scaling
    half_width = share.to("") * abs(of)
    slope = abs(1.0 / scaling.scale_factor)
    unit = "" if scaling.unit == "deg/s" else f" (°/s)/{printed_unit(scaling.unit)}"
    return _rectangular(
        f"meter, {share} of {what}",
        _rate_text(half_width) if scaling.unit == "deg/s" else engineering(half_width, scaling.unit),
        f"{plain(slope, 4)}{unit}",
        half_width * slope,
    )


def _of_steps(record: StaticRecord, noise_dps: float) -> Iterator[Contribution]:
    """Give the steps in which the samples are digitised, where they matter beside the noise."""
    if record.step_dps is None:
        return
    half_dps = mean_half_width(record.step_dps, float(record.rate_dps.std(ddof=1)))
    if half_dps / _ROOT_3 >= _MATTERS * noise_dps:
        source = f"resolution, steps of {_rate_text(record.step_dps)}"
        yield _rectangular(source, _rate_text(half_dps), "1", half_dps)


def _of_scale_factor(mean_dps: float, context: Context) -> Iterator[Contribution]:
    if context.output.scale_factor_uncertainty is not None:
        relative = context.output.scale_factor_uncertainty.to("")
        yield _rectangular(
            "scale factor",
            f"{plain(relative * 100.0, 3)} %",
            _rate_text(abs(mean_dps), 3),
            abs(mean_dps) * relative,
        )


def _of_earth(share_dps: float | None) -> Contribution:
    """Give what is left of the Earth's rate: all of it, or what a small error of pointing leaves."""
    if share_dps is None:
        source, half_dps = "Earth's rate, not subtracted", EARTH_RATE_DPS
    else:
        source, half_dps = f"Earth's share, axis within {POINTING_DEG:g}°", _pointing_half_dps(share_dps)
    return _rectangular(source, _rate_text(half_dps), "1", half_dps)


def _pointing_half_dps(share_dps: float) -> float:
    """Return the most by which Ω_E·cos(angle) changes when the angle does."""
    angle = math.radians(POINTING_DEG)
    across = math.sqrt(max(EARTH_RATE_DPS**2 - share_dps**2, 0.0))
    return across * math.sin(angle) + abs(share_dps) * (1.0 - math.cos(angle))


def _rectangular(source: str, half_width: str, sensitivity: str, half_dps: float) -> Contribution:
    return Contribution(
        source=source,
        kind="B",
        distribution="rectangular",
        half_width=half_width,
        sensitivity=sensitivity,
        standard_uncertainty=half_dps / _ROOT_3,
    )


def _rate_text(rate_dps: float, digits: int = 2) -> str:
    """Return a rate in °/h where that is the handier unit."""
    if rate_dps < _SMALL_DPS:
        return f"{plain(rate_dps * _DPH, digits)} °/h"
    return f"{plain(rate_dps, digits)} °/s"
