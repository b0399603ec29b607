"""Uncertainty budgets: of each result the first one in full, of its other settings, axes and repeats the sum."""

import math
import re
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import groupby

from gyrotest.certificate.numbers import plain, significant
from gyrotest.certificate.order import in_order
from gyrotest.certificate.printing import numbers_in_words
from gyrotest.records.result import Contribution, JudgedResult
from gyrotest.records.run import RunRecord
from gyrotest.units import printed_unit

# What tells results of one kind apart: `sensitivity_20Hz`, `g_sensitivity_x`.
_SETTING = re.compile(r"_(\d[^_]*|[xyz])$")


@dataclass(frozen=True, slots=True, kw_only=True)
class BudgetLine:
    """A contribution, its number rounded like the others of its budget."""

    source: str
    kind: str
    distribution: str
    half_width: str
    sensitivity: str
    degrees_of_freedom: str
    standard_uncertainty: str


@dataclass(frozen=True, slots=True, kw_only=True)
class Budget:
    """The uncertainty budget of a result; `others` tells what other settings, axes and repeats gave."""

    label: str
    unit: str
    lines: tuple[BudgetLine, ...]
    combined: str
    expanded: str
    factor: str
    others: str
    not_included: str


def budgets(record: RunRecord) -> tuple[Budget, ...]:
    """Give the budget of the first setting, axis and repeat of each kind of result that has one."""
    chosen: dict[tuple[str, str, tuple[str, ...]], list[JudgedResult]] = {}
    for result in in_order(record):
        if result.budget:
            chosen.setdefault((result.case, *_kind(result)), []).append(result)
    several = len({case for case, *_ in chosen}) > 1
    return tuple(_budget(results, named=several) for results in chosen.values())


def _kind(result: JudgedResult) -> tuple[str, tuple[str, ...]]:
    """What results have in common whose budgets differ in numbers alone; a single setting is its own kind."""
    kind, settings = _SETTING.subn("", result.name)
    return kind, tuple(one.source for one in result.budget) if settings else ()


def _budget(results: list[JudgedResult], *, named: bool) -> Budget:
    first = results[0]
    combined = _combined(first.budget)
    label = f"{first.label} ({first.case})" if named else first.label
    axis = f", axis {first.axis}" if first.axis else ""
    repeated = any(one.repeat != first.repeat for one in results)
    repeat = f", repeat {first.repeat}" if repeated and first.repeat is not None else ""
    return Budget(
        label=f"{label[:1].lower()}{label[1:]}{axis}{repeat}",
        unit=printed_unit(first.unit),
        lines=tuple(_line(one) for one in first.budget),
        combined=significant(combined, digits=2),
        expanded=""
        if first.expanded_uncertainty is None
        else significant(first.expanded_uncertainty, digits=2),
        factor="" if first.coverage_factor is None else f"{first.coverage_factor:.2f}",
        others=_others(results),
        not_included=", ".join(first.not_included),
    )


def _line(one: Contribution) -> BudgetLine:
    freedom = one.degrees_of_freedom
    return BudgetLine(
        source=one.source,
        kind=one.kind,
        distribution=one.distribution,
        half_width=one.half_width or "–",
        sensitivity=one.sensitivity or "–",
        degrees_of_freedom="∞" if freedom is None else plain(freedom, digits=3),
        standard_uncertainty=significant(one.standard_uncertainty, digits=2),
    )


def _others(results: list[JudgedResult]) -> str:
    """The combined uncertainties of all but the first."""
    if len(results) < 2:
        return ""
    if any(one.name != results[0].name for one in results):
        told = "; ".join(_of_settings(results))
    else:
        told = "; ".join(_of_axes(results[1:]))
    return f"Combined standard uncertainty of the others: {told} {printed_unit(results[0].unit)}."


def _of_settings(results: list[JudgedResult]) -> Iterator[str]:
    """Of each setting its axes and repeats; the first one of all is printed in full."""
    settings = {one.name: one.label.rpartition(", ")[2] for one in results}
    alike = len(set(settings.values())) < len(settings)
    for name, same in groupby(results, key=lambda one: one.name):
        of_setting = list(same)
        setting = of_setting[0].label if alike else settings[name]
        rest = [one for one in of_setting if one is not results[0]]
        if len(of_setting) == 1:
            yield from (f"{setting}: {significant(_combined(one.budget), digits=2)}" for one in rest)
        elif rest:
            yield f"{setting}, {', '.join(_of_axes(rest))}"


def _of_axes(results: list[JudgedResult]) -> Iterator[str]:
    """Of each axis the repeats with their combined uncertainties."""
    for axis, same in groupby(results, key=lambda one: one.axis):
        of_axis = list(same)
        numbers = ", ".join(significant(_combined(one.budget), digits=2) for one in of_axis)
        repeats = numbers_in_words([one.repeat for one in of_axis if one.repeat is not None])
        several = len({one.repeat for one in results}) > 1 or not axis
        name = [f"axis {axis}"] if axis else []
        name += [f"repeat{'s' * (len(of_axis) > 1)} {repeats}"] if several and repeats else []
        yield f"{' '.join(name)}: {numbers}" if name else numbers


def _combined(budget: tuple[Contribution, ...]) -> float:
    """The root sum of squares (JCGM 100 eq. 10)."""
    return math.sqrt(math.fsum(one.standard_uncertainty**2 for one in budget))
