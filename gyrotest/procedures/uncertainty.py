"""Uncertainty budgets (GUM, JCGM 100): lines of them, and what they come to."""

import math
from dataclasses import dataclass

from gyrotest.analysis.interval import coverage_factor
from gyrotest.records.result import Contribution, Result

_ROOT_3 = math.sqrt(3.0)


@dataclass(frozen=True, slots=True, kw_only=True)
class Expanded:
    """Combined standard uncertainty, its effective degrees of freedom, coverage factor for 95.45 %."""

    standard: float
    freedom: float
    factor: float

    @property
    def uncertainty(self) -> float:
        """The expanded uncertainty, the product of standard uncertainty and coverage factor."""
        return self.factor * self.standard


def expanded(budget: tuple[Contribution, ...]) -> Expanded:
    """Return the root sum of squares of a budget with Student's factor at its effective degrees of freedom."""
    combined = math.sqrt(sum(one.standard_uncertainty**2 for one in budget))
    freedom = _effective_freedom(budget, combined)
    return Expanded(standard=combined, freedom=freedom, factor=coverage_factor(freedom))


def budgeted_result(
    budget: tuple[Contribution, ...],
    *,
    name: str,
    label: str,
    value: float,
    unit: str,
    condition: str,
    not_included: tuple[str, ...],
) -> Result:
    """Return a result with the expanded uncertainty that its budget comes to, all in `unit`."""
    found = expanded(budget)
    return Result(
        name=name,
        label=label,
        value=value,
        unit=unit,
        expanded_uncertainty=found.uncertainty,
        coverage_factor=found.factor,
        condition=condition,
        budget=budget,
        not_included=not_included,
    )


def by_statistics(source: str, standard: float, freedom: float | None = None) -> Contribution:
    """Return a contribution of type A, in the result's unit; `freedom` None: infinite."""
    return Contribution(
        source=source,
        kind="A",
        distribution="normal",
        half_width="",
        sensitivity="1",
        standard_uncertainty=standard,
        degrees_of_freedom=None if freedom is None or math.isinf(freedom) else freedom,
    )


def rectangular(source: str, half_width: str, sensitivity: str, half: float) -> Contribution:
    """Return a contribution of type B that lies evenly within `half`, in the result's unit.

    `half_width` and `sensitivity` are how that comes about, in words.
    """
    return Contribution(
        source=source,
        kind="B",
        distribution="rectangular",
        half_width=half_width,
        sensitivity=sensitivity,
        standard_uncertainty=half / _ROOT_3,
    )


def _effective_freedom(budget: tuple[Contribution, ...], combined: float) -> float:
    """Welch–Satterthwaite, JCGM 100 eq. G.2b."""
    shares = sum(
        one.standard_uncertainty**4 / one.degrees_of_freedom
        for one in budget
        if one.degrees_of_freedom is not None
    )
    return combined**4 / shares if shares > 0.0 else math.inf
