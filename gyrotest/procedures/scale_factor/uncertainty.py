"""Budgets of scale factor and bias: what differs from step to step through the fit, the rest after it."""

import math
from collections.abc import Iterator

from gyrotest.analysis.scale_factor import Linear
from gyrotest.procedures.earth import of_earth
from gyrotest.procedures.meter import meter_contributions, missing_of_meter
from gyrotest.procedures.table_steps import missing_of_table
from gyrotest.procedures.turns import Turns
from gyrotest.procedures.uncertainty import by_statistics, rectangular
from gyrotest.procedures.wording import plain, rate_text
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
    factor = conversion_factor(turns.scaling.slope_unit, unit)
    reported = Linear(value=slope.value * factor, weights=slope.weights * factor)
    return (*_of_steps(turns, reported, context, unit), *_of_gains(reported.value, context, unit))


def bias_budget(turns: Turns, share_dps: float | None, context: Context) -> tuple[Contribution, ...]:
    """Return every contribution to the uncertainty of the bias, in °/s.

    The meter's gain acts on the nominal output at rest alone: it makes slope and output at rest too large
    in the same proportion, and their ratio not at all.
    """
    bias = turns.fit.bias
    return (
        *_of_steps(turns, bias, context, "deg/s"),
        *_of_table_gain(bias.value, context, "deg/s"),
        *meter_contributions(
            context,
            turns.turning[0].sampling,
            turns.scaling,
            slope=turns.fit.scale_factor.value,
            indication=turns.scaling.zero,
        ),
        of_earth(share_dps),
    )


def missing_of_slope(context: Context) -> tuple[str, ...]:
    """Give what could not be had of a slope's uncertainty."""
    return (*missing_of_table(context), *_unknown_meter(context))


def missing_of_bias(turns: Turns, context: Context) -> tuple[str, ...]:
    """Give what could not be had of the bias's uncertainty."""
    missing = [*missing_of_table(context), *missing_of_meter(context, turns.turning[0].sampling)]
    if context.since_power_on_s is None:
        missing.append("drift before the record (time of power-on not known)")
    return tuple(missing)


def _unknown_meter(context: Context) -> tuple[str, ...]:
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
