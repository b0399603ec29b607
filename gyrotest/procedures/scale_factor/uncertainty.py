"""Budgets of scale factor and bias: what differs from step to step through the fit, the rest after it."""

import math
from collections.abc import Iterator

from gyrotest.analysis.scale_factor import Linear
from gyrotest.procedures.earth import of_earth
from gyrotest.procedures.scale_factor.turns import Turns
from gyrotest.procedures.uncertainty import by_statistics, rectangular
from gyrotest.procedures.wording import engineering, plain, rate_text
from gyrotest.records.plan import Context
from gyrotest.records.result import Contribution
from gyrotest.records.spec import OutputKind
from gyrotest.units import conversion_factor, printed_unit

_ROOT_3 = math.sqrt(3.0)
_MATTERS = 1e-3


def slope_budget(
    turns: Turns, slope: Linear, context: Context, *, unit: str
) -> tuple[Contribution, ...]:
    """Return every contribution to the uncertainty of a slope, in a unit of scale factors.

    A constant error of the meter leaves a slope as it is.
    """
    factor = conversion_factor(slope_unit(turns), unit)
    reported = Linear(value=slope.value * factor, weights=slope.weights * factor)
    return (*_of_steps(turns, reported, context, unit), *_of_gains(reported.value, context, unit))


def bias_budget(turns: Turns, share_dps: float | None, context: Context) -> tuple[Contribution, ...]:
    """Return every contribution to the uncertainty of the bias, in °/s."""
    bias = turns.fit.bias
    return (
        *_of_steps(turns, bias, context, "deg/s"),
        *_of_table_gain(bias.value, context, "deg/s"),
        *_of_meter(turns, context),
        of_earth(share_dps),
    )


def slope_unit(turns: Turns) -> str:
    """Return the unit in which slopes are computed."""
    return "" if turns.scaling.unit == "deg/s" else f"{turns.scaling.unit}*s/deg"


def missing_of_steps(context: Context) -> tuple[str, ...]:
    """Give what could not be had of what differs from step to step."""
    if context.table is None:
        return ("accuracy of the rate table",)
    if context.table.of_setting is None:
        return ("own error of each setting of the rate table",)
    return ()


def missing_of_slope(context: Context) -> tuple[str, ...]:
    """Give what could not be had of a slope's uncertainty."""
    return (*missing_of_steps(context), *_missing_of_meter(context))


def missing_of_bias(turns: Turns, context: Context) -> tuple[str, ...]:
    """Give what could not be had of the bias's uncertainty."""
    accuracy, missing = context.accuracy, [*missing_of_slope(context)]
    unknown_range = turns.turning[0].sampling.range is None
    if accuracy is not None and unknown_range and accuracy.of_range.value != 0.0:
        missing.append("accuracy of the meter's range (range not known)")
    if context.since_power_on_s is None:
        missing.append("drift before the record (time of power-on not known)")
    return tuple(missing)


def _missing_of_meter(context: Context) -> tuple[str, ...]:
    unknown = context.output.kind is OutputKind.VOLTAGE and context.accuracy is None
    return ("accuracy of the meter",) if unknown else ()


def _of_steps(turns: Turns, one: Linear, context: Context, unit: str) -> Iterator[Contribution]:
    noise = turns.by_noise(one)
    standard = math.sqrt(noise.value)
    yield by_statistics("noise and drift of the step means", standard, noise.degrees_of_freedom)
    if turns.setting is not None and context.table is not None and context.table.of_setting is not None:
        half_dps = context.table.of_setting.to("deg/s")
        half = _ROOT_3 * math.sqrt(turns.by_setting(one))
        yield rectangular(
            "table, own error of each setting",
            rate_text(half_dps),
            _per_rate(half / half_dps if half_dps else 0.0, unit),
            half,
        )
    rounding = math.sqrt(one.variance(turns.rounding))
    if rounding > _MATTERS * standard:
        yield rectangular("resolution of the output", "", "1", _ROOT_3 * rounding)


def _per_rate(slope: float, unit: str) -> str:
    """Return a sensitivity to a rate in words."""
    if unit == "deg/s":
        return plain(slope, 2)
    return f"{plain(slope, 2)} {printed_unit(unit)}/(°/s)".replace(" /", " 1/")


def _of_gains(value: float, context: Context, unit: str) -> Iterator[Contribution]:
    yield from _of_table_gain(value, context, unit)
    if context.accuracy is not None:
        share = context.accuracy.of_reading
        yield _of_gain(f"meter, {share} of reading", share.to(""), value, unit)


def _of_table_gain(value: float, context: Context, unit: str) -> Iterator[Contribution]:
    if context.table is not None:
        share = context.table.of_reading
        yield _of_gain(f"table, {share} of the rate", share.to(""), value, unit)


def _of_gain(source: str, share: float, value: float, unit: str) -> Contribution:
    size = abs(value)
    of = rate_text(size, 3) if unit == "deg/s" else f"{plain(size, 4)} {printed_unit(unit)}".strip()
    return rectangular(source, f"{plain(share * 1e6, 3)} ppm", of, share * size)


def _of_meter(turns: Turns, context: Context) -> Iterator[Contribution]:
    """Give the meter's share in the bias: its gain acts on the nominal output at rest alone.

    Slope and output at rest are too large in the same proportion, so that their ratio is not.
    """
    accuracy, scaling = context.accuracy, turns.scaling
    if accuracy is None:
        return
    slope = abs(1.0 / turns.fit.scale_factor.value)
    indicated = {"reading": abs(scaling.zero)}
    reach = turns.turning[0].sampling.range
    if reach is not None:
        indicated["range"] = reach * scaling.to_canonical
    for what, of in indicated.items():
        share = accuracy.of_reading if what == "reading" else accuracy.of_range
        half = share.to("") * of
        if half > 0.0:
            unit = "" if scaling.unit == "deg/s" else f" (°/s)/{printed_unit(scaling.unit)}"
            spoken = rate_text(half) if scaling.unit == "deg/s" else engineering(half, scaling.unit)
            yield rectangular(
                f"meter, {share} of {what}", spoken, f"{plain(slope, 4)}{unit}", half * slope
            )
