"""The coefficients that are applied: scale factor and bias, as an earlier case of the run fitted them."""

import math
from dataclasses import dataclass

from gyrotest.errors import InsufficientDataError
from gyrotest.procedures.earth import earth_words
from gyrotest.procedures.scaling import OUTPUT_UNITS
from gyrotest.records.plan import Context
from gyrotest.records.result import Result
from gyrotest.records.spec import Output, OutputKind
from gyrotest.units import conversion_factor


@dataclass(frozen=True, slots=True, kw_only=True)
class Coefficient:
    """A fitted value in a unit; its expanded uncertainty and coverage factor where they are known."""

    value: float
    unit: str
    expanded_uncertainty: float | None
    coverage_factor: float | None


@dataclass(frozen=True, slots=True, kw_only=True)
class Coefficients:
    """Scale factor in the output's unit per °/s, bias in °/s, and the nominal output at rest.

    `from_case` names the case, `fits` says over how many repeats of it they are means. `holds_earth`:
    the Earth's rate, which was not subtracted there, is in the bias.
    """

    scale_factor: Coefficient
    bias: Coefficient
    zero: float
    zero_unit: str
    from_case: str
    fits: int
    holds_earth: bool


def fitted_coefficients(context: Context, from_case: str) -> Coefficients:
    """Return what an earlier case fitted for this axis; raises `InsufficientDataError` where it has not."""
    earlier = context.earlier.get(from_case)
    if earlier is None:
        known = ", ".join(f"'{one}'" for one in context.earlier) or "none"
        raise InsufficientDataError(
            f"{context.case_name}: parameters.scale_factor_from is '{from_case}', of which there are no results"
            f" (judged before this case: {known}); put a case of that name, of procedure 'scale_factor',"
            " before this one, and run both"
        )
    factor = _mean(earlier, "scale_factor", _scale_factor_unit(context.output), from_case, context)
    bias = _mean(earlier, "bias", "deg/s", from_case, context)
    zero_unit, zero = OUTPUT_UNITS[context.output.kind], context.output.zero_rate
    biases = [one for one in earlier if one.name == "bias"]
    return Coefficients(
        scale_factor=factor,
        bias=bias,
        zero=0.0 if zero is None else zero.to(zero_unit),
        zero_unit=zero_unit,
        from_case=from_case,
        fits=len(biases),
        holds_earth=any(earth_words(None) in one.condition for one in biases),
    )


def _scale_factor_unit(output: Output) -> str:
    own = OUTPUT_UNITS[output.kind]
    return "" if output.kind is OutputKind.RATE else f"{own}/(deg/s)"


def _mean(
    earlier: tuple[Result, ...], name: str, unit: str, from_case: str, context: Context
) -> Coefficient:
    """Return the mean over the repeats, as uncertain as the most uncertain of them: most of it is common."""
    found = [one for one in earlier if one.name == name]
    values = [
        one.value * conversion_factor(one.unit, unit)
        for one in found
        if one.value is not None and math.isfinite(one.value)
    ]
    if not values or len(values) < len(found):
        raise InsufficientDataError(
            f"{context.case_name}: case '{from_case}' has no {name.replace('_', ' ')}; it must be of procedure"
            " 'scale_factor', and have been evaluated in each of its repeats"
        )
    widest = max(found, key=lambda one: one.expanded_uncertainty or 0.0)
    uncertainty = widest.expanded_uncertainty
    return Coefficient(
        value=sum(values) / len(values),
        unit=unit,
        expanded_uncertainty=(
            None if uncertainty is None else uncertainty * conversion_factor(widest.unit, unit)
        ),
        coverage_factor=widest.coverage_factor,
    )
