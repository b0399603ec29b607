"""The same coefficients by two methods: what an earlier case measured beside what this one did."""

import math
from collections.abc import Iterator

from gyrotest.analysis.mounting import AXES
from gyrotest.errors import InsufficientDataError
from gyrotest.procedures.g_sensitivity.combined import agreement_of
from gyrotest.procedures.g_sensitivity.influences import PLACEMENT
from gyrotest.procedures.g_sensitivity.measurands import (
    METHOD_AGREEMENT,
    PER_G,
    coefficient_name,
    method_difference_name,
)
from gyrotest.procedures.g_sensitivity.mounting_results import mattering
from gyrotest.procedures.uncertainty import budgeted_result
from gyrotest.records.plan import Context
from gyrotest.records.result import Contribution, Result
from gyrotest.units import conversion_factor

_SAME = 1e-12


def other_coefficients(case_name: str, context: Context) -> dict[str, Result]:
    """Return an earlier case's coefficients by their axes; raises `InsufficientDataError` where it has none."""
    by_name = {one.name: one for one in context.earlier.get(case_name, ())}
    found = {axis: by_name.get(coefficient_name(axis)) for axis in AXES}
    there = {axis: one for axis, one in found.items() if one is not None and one.value is not None}
    if len(there) < len(AXES):
        known = ", ".join(f"'{one}'" for one in context.earlier) or "none"
        raise InsufficientDataError(
            f"{context.case_name}: parameters.compare_with is '{case_name}', which has no coefficients of all"
            f" three axes (judged before this case: {known}); put a case of that name, of procedure"
            " 'g_sensitivity' and with both placements, before this one, and run both"
        )
    return there


def comparison_results(own: tuple[Result, ...], case_name: str, context: Context) -> Iterator[Result]:
    """Give the differences to an earlier case, and how they compare with their uncertainty."""
    others = other_coefficients(case_name, context)
    by_name = {one.name: one for one in own}
    differences = [
        _difference(axis, by_name[coefficient_name(axis)], others[axis], case_name) for axis in AXES
    ]
    yield from differences
    worst = max(differences, key=agreement_of)
    yield Result(
        name=METHOD_AGREEMENT,
        label="Difference of the methods over its U",
        value=100.0 * agreement_of(worst),
        unit="%",
        condition=f"largest of all axes, to case '{case_name}'; up to 100 % they agree within the expanded"
        " uncertainty of the difference",
        not_included=worst.not_included,
    )


def _difference(axis: str, own: Result, other: Result, case_name: str) -> Result:
    lines = tuple(_joined(_lines(own), _lines(other), case_name))
    return budgeted_result(
        mattering(list(lines)),
        name=method_difference_name(axis),
        label=f"g-sensitivity {axis}, less the other method's",
        value=_value(own) - _value(other),
        unit=PER_G,
        condition=f"less that of case '{case_name}'; what both have in common cancels",
        not_included=tuple(dict.fromkeys((*own.not_included, *other.not_included))),
    )


def _joined(
    own: dict[str, Contribution], other: dict[str, Contribution], case_name: str
) -> Iterator[Contribution]:
    """Give the lines of the difference: of what is the same in both cases, only what does not cancel."""
    for source, line in own.items():
        theirs = other.get(source)
        if theirs is None or _single(line):
            yield line
        elif abs(left := line.standard_uncertainty - theirs.standard_uncertainty) > _SAME:
            yield _as_wide(line, abs(left), f"{source}, apart")
    for source, line in other.items():
        if source not in own or _single(line):
            yield _as_wide(line, line.standard_uncertainty, f"{source} (case '{case_name}')")


def _single(line: Contribution) -> bool:
    """Whether it is another error in each acquisition."""
    return line.kind == "A" or line.source == PLACEMENT


def _as_wide(line: Contribution, standard: float, source: str) -> Contribution:
    return Contribution(
        source=source,
        kind=line.kind,
        distribution=line.distribution,
        half_width=line.half_width,
        sensitivity="" if line.kind == "A" else line.sensitivity,
        standard_uncertainty=standard,
        degrees_of_freedom=line.degrees_of_freedom,
    )


def _lines(one: Result) -> dict[str, Contribution]:
    factor = conversion_factor(one.unit, PER_G)
    return {
        line.source: _as_wide(line, line.standard_uncertainty * factor, line.source)
        for line in one.budget
    }


def _value(one: Result) -> float:
    value = one.value if one.value is not None else math.nan
    return value * conversion_factor(one.unit, PER_G)
