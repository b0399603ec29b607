"""Results of a scale-factor test: slope, bias, how straight and how even the line is."""

import math
from collections.abc import Iterator

import numpy as np

from gyrotest.analysis.extremes import Magnitude, largest_magnitude, magnitude
from gyrotest.analysis.scale_factor import Linear
from gyrotest.procedures.earth import earth_share, earth_words
from gyrotest.procedures.scale_factor.parameters import REPORTED
from gyrotest.procedures.scale_factor.uncertainty import (
    bias_budget,
    missing_of_bias,
    missing_of_slope,
    slope_budget,
)
from gyrotest.procedures.table_steps import missing_of_table
from gyrotest.procedures.turns import Turns
from gyrotest.procedures.uncertainty import budgeted_result, by_statistics, expanded
from gyrotest.procedures.wording import plain
from gyrotest.records.plan import Context
from gyrotest.records.result import Result
from gyrotest.units import conversion_factor, printed_unit

PPM = 1e6
_DPH = 3600.0
_MINUS = "\N{MINUS SIGN}"


def turn_results(turns: Turns, context: Context) -> Iterator[Result]:
    """Give the results of one acquisition."""
    fit = turns.fit
    slope = slope_result(turns, fit.scale_factor, "scale_factor", "Scale factor", context)
    yield slope
    yield _error_result(slope, context)
    yield bias_result(turns, context)
    yield _full_scale_result(turns, context)
    yield nonlinearity_result(
        turns,
        context,
        name="nonlinearity_of_tested",
        label="Nonlinearity, of the largest rate tested",
        of_dps=turns.largest_dps,
        of=f"of {_rate(turns.largest_dps)}",
    )
    yield _asymmetry_result(turns, context)
    yield from _one_sided_results(turns, context)
    if fit.rest_difference is not None:
        yield _rest_result(turns, fit.rest_difference)


def slope_result(turns: Turns, slope: Linear, name: str, label: str, context: Context) -> Result:
    """Return a slope with its budget, in the unit of the output's scale factors."""
    unit = REPORTED[context.output.kind]
    budget = slope_budget(turns, slope, context, unit=unit)
    return budgeted_result(
        budget,
        name=name,
        label=label,
        value=slope.value * conversion_factor(turns.scaling.slope_unit, unit),
        unit=unit,
        condition=_span(turns, slope),
        not_included=missing_of_slope(context),
    )


def _error_result(slope: Result, context: Context) -> Result:
    """Return the scale factor's deviation from the nominal one; of a rate without one, from 1."""
    given = context.output.scale_factor
    nominal = 1.0 if given is None else given.to(slope.unit)
    share = 100.0 / nominal
    return Result(
        name="scale_factor_error",
        label="Scale factor, error to nominal",
        value=((slope.value or 0.0) - nominal) * share,
        unit="%",
        expanded_uncertainty=(slope.expanded_uncertainty or 0.0) * abs(share),
        coverage_factor=slope.coverage_factor,
        condition=f"nominal {'1' if given is None else printed_unit(str(given))}".replace("-", _MINUS),
        not_included=slope.not_included,
    )


def bias_result(turns: Turns, context: Context) -> Result:
    """Return the output at rate 0 as a rate, less the Earth's share."""
    share_dps = earth_share(context)
    budget = bias_budget(turns, share_dps, context)
    return budgeted_result(
        budget,
        name="bias",
        label="Bias",
        value=turns.fit.bias.value - (share_dps or 0.0),
        unit="deg/s",
        condition=f"from the line at rate 0; {earth_words(share_dps)}",
        not_included=missing_of_bias(turns, context),
    )


def _full_scale_result(turns: Turns, context: Context) -> Result:
    full_scale, label = context.output.full_scale, "Nonlinearity, of full scale"
    if full_scale is None:
        reason = "'output.full_scale' is not given"
        return _not_evaluated("nonlinearity", label, "ppm", reason)
    return nonlinearity_result(
        turns,
        context,
        name="nonlinearity",
        label=label,
        of_dps=full_scale.to("deg/s"),
        of=f"of full scale {_rate(full_scale.to('deg/s'))}, tested to {_rate(turns.largest_dps)}",
    )


def nonlinearity_result(
    turns: Turns, context: Context, *, name: str, label: str, of_dps: float, of: str
) -> Result:
    """Return the largest residual in proportion to a rate, with an interval that noise has not made larger."""
    per = PPM / (abs(turns.fit.scale_factor.value) * of_dps)
    variances = [turns.total(one) for one in turns.fit.residuals]
    found = largest_magnitude(
        turns.fit.residual * per,
        standard=np.array([math.sqrt(one.value) * per for one in variances]),
        freedom=np.array([one.degrees_of_freedom for one in variances]),
    )
    worst = turns.rates_dps[int(np.argmax(np.abs(turns.fit.residual)))]
    condition = f"{of}; largest at {_rate(float(worst))}"
    return _magnitude_result(found, name, label, condition, context)


def _asymmetry_result(turns: Turns, context: Context) -> Result:
    name, label, signed = "asymmetry", "Scale-factor asymmetry", turns.fit.asymmetry
    if signed is None:
        reason = "needs two rates of each sign; see 'parameters.rates'"
        return _not_evaluated(name, label, "ppm", reason)
    variance = turns.total(signed)
    found = magnitude(
        signed.value * PPM, standard=math.sqrt(variance.value) * PPM, freedom=variance.degrees_of_freedom
    )
    larger = "forward" if signed.value * turns.fit.scale_factor.value > 0.0 else "backward"
    return _magnitude_result(found, name, label, f"the {larger} one is larger", context)


def _magnitude_result(
    found: Magnitude, name: str, label: str, condition: str, context: Context
) -> Result:
    return Result(
        name=name,
        label=label,
        value=found.value,
        unit="ppm",
        lower_95=found.lower_95,
        upper_95=found.upper_95,
        condition=condition,
        not_included=missing_of_table(context),
    )


def _one_sided_results(turns: Turns, context: Context) -> Iterator[Result]:
    for way, slope in (("forward", turns.fit.forward), ("backward", turns.fit.backward)):
        name, label = f"scale_factor_{way}", f"Scale factor, {way}"
        if slope is None:
            reason = f"needs two rates {way}; see 'parameters.rates'"
            yield _not_evaluated(name, label, REPORTED[context.output.kind], reason)
        else:
            yield slope_result(turns, slope, name, label, context)


def _rest_result(turns: Turns, difference: Linear) -> Result:
    """Return how far the output at rest went from before to after; the fit takes it out, linear in time."""
    per = _DPH / abs(turns.fit.scale_factor.value)
    variance = turns.total(difference)
    line = by_statistics("noise", math.sqrt(variance.value) * per, variance.degrees_of_freedom)
    whole = expanded((line,))
    return Result(
        name="rest_difference",
        label="Output at rest, after less before",
        value=difference.value * _DPH / turns.fit.scale_factor.value,
        unit="deg/h",
        expanded_uncertainty=whole.uncertainty,
        coverage_factor=whole.factor,
        condition=f"{plain(turns.rest[-1].middle_s - turns.rest[0].middle_s, 4)} s apart",
    )


def _not_evaluated(name: str, label: str, unit: str, reason: str) -> Result:
    return Result(name=name, label=label, value=None, unit=unit, condition=reason)


def _span(turns: Turns, slope: Linear) -> str:
    """Say which steps a slope is through."""
    fit = turns.fit
    rates = turns.rates_dps
    if slope is fit.forward:
        rates = rates[rates > 0.0]
    elif slope is fit.backward:
        rates = rates[rates < 0.0]
    return f"{rates.size} steps, {_rate(float(rates.min()))} … {_rate(float(rates.max()))}"


def _rate(rate_dps: float) -> str:
    return f"{plain(rate_dps, 6)} °/s".replace("-", _MINUS)
