"""What must hold of a case's limits: something to hold them against, of the same kind, in order."""

import re
from collections.abc import Iterator

from gyrotest.records.result import Measurand
from gyrotest.records.spec import Case, Limit
from gyrotest.specification.checked import Complaint
from gyrotest.specification.shapes import nearest
from gyrotest.specification.yaml_tree import KeyPath
from gyrotest.units import same_dimension

# Names in use for several quantities, or that need something beside → what the user may have meant.
_AMBIGUOUS = {
    "bias_instability": (
        "names two quantities; write 'allan_minimum' (the curve's lowest point, as in most datasheets) "
        "or 'bias_instability_coefficient' (B of the fitted curve, as in IEEE 952)"
    ),
    "bias_stability": (
        "needs its averaging time, one of 'parameters.smoothing'; write e.g. 'bias_stability_10s'"
    ),
    "bias_repeatability": (
        "is measured over power cycles; write 'between_repeats: power_cycle', "
        "or limit 'bias_run_to_run', which needs none"
    ),
    "bias_run_to_run": (
        "is measured without a power cycle between the repeats; "
        "with 'between_repeats: power_cycle' the name is 'bias_repeatability'"
    ),
}
# What tells results of one kind apart: `bias_stability_10s`, `sensitivity_20Hz`.
_SETTING = re.compile(r"_\d[^_]*$")
_OVER_REPEATS = {"bias_run_to_run", "bias_repeatability"}


def limit_complaints(case: Case, measurands: tuple[Measurand, ...], key: KeyPath) -> Iterator[Complaint]:
    """Give what is wrong with the limits of a case, which stand at `key`."""
    for name, limit in case.limits.items():
        named = [one for one in measurands if one.name == name]
        if not named:
            yield Complaint((*key, name), _unmeasured(name, case, [one.name for one in measurands]))
            continue
        yield from _over_complaints(limit, named, case, (*key, name))
        yield from _unit_complaints(limit, named[0], (*key, name))


def order_complaints(limit: Limit, key: KeyPath) -> Iterator[Complaint]:
    """Give what is wrong with a limit by itself."""
    low, high = limit.min, limit.max
    if low is None and high is None:
        yield Complaint(key, "has neither 'min' nor 'max'; give at least one of them")
    if low is None or high is None:
        return
    if not same_dimension(low.unit, high.unit):
        yield Complaint(key, f"min '{low}' and max '{high}' are of different kinds")
    elif low.to(high.unit) > high.value:
        yield Complaint(key, f"min '{low}' is greater than max '{high}'; no value can pass")


def unknown_measurand(name: str, known: list[str]) -> str:
    """Return the message for a name that nothing measures."""
    if name in _AMBIGUOUS:
        return _AMBIGUOUS[name]
    kind, settings = _SETTING.subn("", name)
    alike = [one for one in known if settings and _SETTING.sub("", one) == kind != one]
    if alike:
        return (
            f"is not measured by this case, which measures {', '.join(alike)}; add what you want to its"
            " parameters, or correct the name"
        )
    return f"is not measured by this case; {nearest(name, known)}"


def _unmeasured(name: str, case: Case, known: list[str]) -> str:
    if name in _OVER_REPEATS and case.repeats < 2:
        return _too_few(case)
    return unknown_measurand(name, known)


def _too_few(case: Case) -> str:
    return f"is computed over the repeats, and {case.repeats} is too few; write e.g. 'repeats: 3'"


def _over_complaints(
    limit: Limit, named: list[Measurand], case: Case, key: KeyPath
) -> Iterator[Complaint]:
    if any(one.over == limit.over for one in named):
        if limit.over is not None and case.repeats < 2:
            yield Complaint(key, _too_few(case))
    elif limit.over is None:
        yield Complaint(key, f"is computed over the repeats; add 'over: {named[0].over}' to the limit")
    else:
        yield Complaint((*key, "over"), "is measured in each repeat; remove 'over'")


def _unit_complaints(limit: Limit, measurand: Measurand, key: KeyPath) -> Iterator[Complaint]:
    dimension = measurand.dimension
    for end, value in (("min", limit.min), ("max", limit.max)):
        if value is not None and not same_dimension(value.unit, dimension.value):
            message = f"'{value}' is not {dimension.spoken()}; write e.g. '{dimension.example()}'"
            yield Complaint((*key, end), message)
