"""The scale factor by which a reversal becomes a bias: nominal, or measured by an earlier case."""

from dataclasses import dataclass

import numpy as np

from gyrotest.errors import InsufficientDataError
from gyrotest.procedures.bias_reversal.parameters import BiasReversalParameters
from gyrotest.procedures.scaling import SCALE_FACTORS, Scaling
from gyrotest.records.plan import Context
from gyrotest.records.result import Result
from gyrotest.units import conversion_factor

_ROOT_3 = 3.0**0.5


@dataclass(frozen=True, slots=True, kw_only=True)
class KnownSlope:
    """A scale factor in the output's unit per °/s, and where it is from.

    `relative` is its standard uncertainty in proportion to it, `asymmetry` how far forward and backward
    ones may be apart, in proportion to them; None where not known.
    """

    value: float
    relative: float | None
    asymmetry: float | None
    source: str


def known_slope(scaling: Scaling, parameters: BiasReversalParameters, context: Context) -> KnownSlope:
    """Return the scale factor to use; raises `InsufficientDataError` where the earlier case has none."""
    if parameters.scale_factor_from is not None:
        return _measured(parameters.scale_factor_from, context)
    uncertainty, asymmetry = context.output.scale_factor_uncertainty, parameters.asymmetry
    return KnownSlope(
        value=scaling.scale_factor,
        relative=None if uncertainty is None else uncertainty.to("") / _ROOT_3,
        asymmetry=None if asymmetry is None else asymmetry.to(""),
        source="nominal scale factor",
    )


def _measured(case_name: str, context: Context) -> KnownSlope:
    """Take the mean over the earlier case's repeats, and the largest of their uncertainties."""
    results = context.earlier.get(case_name, ())
    slopes = [one for one in results if one.name == "scale_factor" and one.value]
    if not slopes:
        raise InsufficientDataError(
            f"{context.case_name}: case '{case_name}' has no scale factor (yet); put it before this case, and"
            " see that it is measured"
        )
    unit = SCALE_FACTORS[context.output.kind].value
    values = np.array([(one.value or 0.0) * conversion_factor(one.unit, unit) for one in slopes])
    relatives = [_relative(one) for one in slopes]
    asymmetries = [_at_most(one) for one in results if one.name == "asymmetry"]
    known = [one for one in relatives if one is not None]
    bounds = [one for one in asymmetries if one is not None]
    return KnownSlope(
        value=float(values.mean()),
        relative=max(known) if len(known) == len(relatives) else None,
        asymmetry=max(bounds) if bounds else None,
        source=f"scale factor from case '{case_name}'",
    )


def _relative(one: Result) -> float | None:
    if one.expanded_uncertainty is None or not one.coverage_factor or not one.value:
        return None
    return one.expanded_uncertainty / one.coverage_factor / abs(one.value)


def _at_most(one: Result) -> float | None:
    """Return the upper end of an asymmetry: the sign of what it leaves is not known."""
    end = one.value if one.upper_95 is None else one.upper_95
    return None if end is None else end * conversion_factor(one.unit, "")
