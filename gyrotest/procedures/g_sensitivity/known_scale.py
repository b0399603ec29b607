"""The scale factor that turns the output into a rate: nominal, or as an earlier case measured it."""

import math
from dataclasses import dataclass

from gyrotest.errors import InsufficientDataError
from gyrotest.procedures.scaling import SCALE_FACTORS, Scaling
from gyrotest.records.plan import Context
from gyrotest.records.result import Result
from gyrotest.units import conversion_factor

_ROOT_3 = math.sqrt(3.0)


@dataclass(frozen=True, slots=True, kw_only=True)
class KnownScale:
    """A scale factor over the nominal one, and its relative standard uncertainty (None: not known).

    `measured` tells one that an earlier case measured, `source` where it is from.
    """

    of_nominal: float
    relative: float | None
    measured: bool
    source: str

    @property
    def distribution(self) -> str:
        """How it is spread."""
        return "normal" if self.measured else "rectangular"


def nominal_scale(context: Context) -> KnownScale:
    """Return the spec's own."""
    stated = context.output.scale_factor_uncertainty
    return KnownScale(
        of_nominal=1.0,
        relative=None if stated is None else stated.to("") / _ROOT_3,
        measured=False,
        source="nominal scale factor",
    )


def known_scale(scaling: Scaling, case_name: str | None, context: Context) -> KnownScale:
    """Return the scale factor to use; raises `InsufficientDataError` where the earlier case has none."""
    if case_name is None:
        return nominal_scale(context)
    found = [
        one for one in context.earlier.get(case_name, ()) if one.name == "scale_factor" and one.value
    ]
    if not found:
        raise InsufficientDataError(
            f"{context.case_name}: case '{case_name}' has no scale factor (yet); put it before this case, and"
            " see that it is measured"
        )
    unit = SCALE_FACTORS[context.output.kind].value
    values = [(one.value or 0.0) * conversion_factor(one.unit, unit) for one in found]
    relatives = [_relative(one) for one in found]
    known = [one for one in relatives if one is not None]
    return KnownScale(
        of_nominal=sum(values) / len(values) / scaling.scale_factor,
        relative=max(known) if len(known) == len(relatives) else None,
        measured=True,
        source=f"scale factor from case '{case_name}'",
    )


def _relative(one: Result) -> float | None:
    if one.expanded_uncertainty is None or not one.coverage_factor or not one.value:
        return None
    return one.expanded_uncertainty / one.coverage_factor / abs(one.value)
