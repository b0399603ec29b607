"""The mean bias over the power cycles with its uncertainty budget."""

import math
from dataclasses import replace

from gyrotest.analysis.repeatability import Repeatability
from gyrotest.procedures.uncertainty import budgeted_result, by_statistics
from gyrotest.records.result import Contribution, Result
from gyrotest.units import conversion_factor

_UNIT = "deg/s"


def mean_result(found: tuple[Result, ...], spread: Repeatability) -> Result:
    """Return the mean bias: its scatter, and once what is common to all cycles (GUM, JCGM 100)."""
    scatter = by_statistics(
        f"scatter over {spread.count} power cycles", spread.mean_uncertainty, spread.count - 1
    )
    worst = max(found, key=_common)
    budget = (scatter, *_common_contributions(worst))
    return budgeted_result(
        budget,
        name="bias_mean",
        label="Bias, mean over power cycles",
        value=spread.mean,
        unit=_UNIT,
        condition="; ".join((f"{spread.count} power cycles", *_same_condition(found))),
        not_included=tuple(dict.fromkeys(name for one in found for name in one.not_included)),
    )


def _common(bias: Result) -> float:
    """Return the standard uncertainty that a bias shares with those of the other cycles."""
    return math.sqrt(sum(one.standard_uncertainty**2 for one in _common_contributions(bias)))


def _common_contributions(bias: Result) -> tuple[Contribution, ...]:
    factor = conversion_factor(bias.unit, _UNIT)
    return tuple(
        replace(one, standard_uncertainty=one.standard_uncertainty * factor)
        for one in bias.budget
        if one.kind != "A"
    )


def _same_condition(found: tuple[Result, ...]) -> tuple[str, ...]:
    """Return what the conditions of all cycles say alike, as how the Earth's rate was treated."""
    first, *others = (one.condition.split("; ") for one in found)
    return tuple(part for part in first if part and all(part in other for other in others))
