"""The scale factor by which a reversal becomes a bias: nominal, or measured by an earlier case."""

import math
from dataclasses import dataclass

import numpy as np

from gyrotest.errors import InsufficientDataError
from gyrotest.procedures.bias_reversal.parameters import BiasReversalParameters
from gyrotest.procedures.scaling import SCALE_FACTORS, Scaling
from gyrotest.procedures.wording import plain
from gyrotest.records.plan import Context
from gyrotest.records.result import Result
from gyrotest.units import conversion_factor

_ROOT_3 = 3.0**0.5
_NORMAL_95 = 1.96


@dataclass(frozen=True, slots=True, kw_only=True)
class Asymmetry:
    """How far forward and backward scale factors are apart, in proportion to them: its standard deviation.

    Its sign is not used, so that all of it counts: of a measured one √(α² + u²(α)).
    """

    standard: float
    distribution: str
    stated: str


@dataclass(frozen=True, slots=True, kw_only=True)
class KnownSlope:
    """A scale factor in the output's unit per °/s, and where it is from.

    `relative` is its standard uncertainty in proportion to it; None where not known.
    """

    value: float
    relative: float | None
    asymmetry: Asymmetry | None
    source: str


def known_slope(scaling: Scaling, parameters: BiasReversalParameters, context: Context) -> KnownSlope:
    """Return the scale factor to use; raises `InsufficientDataError` where the earlier case has none."""
    if parameters.scale_factor_from is not None:
        return _measured(parameters.scale_factor_from, context)
    uncertainty, asymmetry = context.output.scale_factor_uncertainty, parameters.asymmetry
    return KnownSlope(
        value=scaling.scale_factor,
        relative=None if uncertainty is None else uncertainty.to("") / _ROOT_3,
        asymmetry=None if asymmetry is None else _stated(asymmetry.to("")),
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
    asymmetries = [_of_measured(one) for one in results if one.name == "asymmetry"]
    known = [one for one in relatives if one is not None]
    given = [one for one in asymmetries if one is not None]
    return KnownSlope(
        value=float(values.mean()),
        relative=max(known) if len(known) == len(relatives) else None,
        asymmetry=max(given, key=lambda one: one.standard, default=None),
        source=f"scale factor from case '{case_name}'",
    )


def _relative(one: Result) -> float | None:
    if one.expanded_uncertainty is None or not one.coverage_factor or not one.value:
        return None
    return one.expanded_uncertainty / one.coverage_factor / abs(one.value)


def _stated(half_width: float) -> Asymmetry:
    return Asymmetry(
        standard=half_width / _ROOT_3,
        distribution="rectangular",
        stated=f"{plain(half_width * 1e6, 3)} ppm",
    )


def _of_measured(one: Result) -> Asymmetry | None:
    """Return a measured asymmetry; the upper end of its interval lies 1.96 standard uncertainties above it."""
    if one.value is None or one.upper_95 is None:
        return None
    ratio = conversion_factor(one.unit, "")
    value, above = one.value * ratio, (one.upper_95 - one.value) * ratio
    return Asymmetry(
        standard=math.hypot(value, above / _NORMAL_95),
        distribution="normal",
        stated=f"{plain(value * 1e6, 3)} (+{plain(above * 1e6, 3)}) ppm",
    )
