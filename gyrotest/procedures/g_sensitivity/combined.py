"""Results over the mountings: the coefficients, whether both agree, the drift before and after compensation."""

import math
from collections.abc import Iterator, Mapping

import numpy as np

from gyrotest.analysis.mounting import AXES
from gyrotest.procedures.g_sensitivity.influences import combined_lines
from gyrotest.procedures.g_sensitivity.measurands import (
    AFTER,
    AGREEMENT,
    BEFORE,
    DIFFERENCE,
    MAGNITUDE,
    MOUNTED_AFTER,
    MOUNTED_BEFORE,
    MOUNTED_CROSS_AXIS,
    PER_G,
    coefficient_name,
    cross_axis_name,
)
from gyrotest.procedures.g_sensitivity.mounting_results import NOISE, mattering
from gyrotest.procedures.g_sensitivity.repeats import Mounting, Mountings
from gyrotest.procedures.uncertainty import budgeted_result, by_statistics
from gyrotest.records.result import Contribution, Result
from gyrotest.units import conversion_factor

Weights = Mapping[int, Mapping[int, float]]
"""Factors of own coefficients by their places, for each mounting by its number."""

_MINUS = "\N{MINUS SIGN}"


def combined_results(found: Mountings) -> Iterator[Result]:
    """Give the results over all mountings."""
    yield from _coefficients(found)
    yield magnitude_result(found)
    yield from _cross_axes(found)
    yield from _agreement(found)
    yield from _drifts(found)


def estimate_weights(found: Mountings, factors: Mapping[int, float]) -> dict[int, dict[int, float]]:
    """Return what a sum over the combined coefficients, by their places, is of those of the mountings."""
    weights: dict[int, dict[int, float]] = {one.number: {} for one in found.mountings}
    for place, factor in factors.items():
        for number, weight in found.estimates[place].weights.items():
            weights[number][place] = factor * weight
    return weights


def budget_of(found: Mountings, weights: Weights) -> tuple[Contribution, ...]:
    """Return the budget of a sum over the mountings' coefficients: noise of each, and what they have in common."""
    noise = [
        (found.mountings[number].noise[place], factor)
        for number, factors in weights.items()
        for place, factor in factors.items()
        if factor
    ]
    variances = [(factor * one.standard) ** 2 for one, factor in noise]
    shares = sum(variance**2 / one.freedom for variance, (one, _) in zip(variances, noise, strict=True))
    freedom = sum(variances) ** 2 / shares if shares > 0.0 else math.inf
    parts = [
        (found.influences[number], _padded(found, number, dict(factors)))
        for number, factors in weights.items()
    ]
    lines = [by_statistics(NOISE, math.sqrt(sum(variances)), freedom)]
    return mattering([*lines, *combined_lines(parts, "°/s/g")])


def _padded(
    found: Mountings, number: int, factors: dict[int, float]
) -> "np.ndarray[tuple[int], np.dtype[np.float64]]":
    """Return the factors of the fit's coefficients, none of what follows the turning."""
    own = found.factors(number, factors)
    size = found.influences[number][0].patterns[0].shape[1]
    return np.append(own, np.zeros(size - own.size))


def _coefficients(found: Mountings) -> Iterator[Result]:
    for one in found.estimates:
        count = len(one.weights)
        yield budgeted_result(
            budget_of(found, estimate_weights(found, {one.place: 1.0})),
            name=coefficient_name(one.axis),
            label=f"g-sensitivity {one.axis}",
            value=one.value,
            unit=PER_G,
            condition=f"from {'one mounting' if count == 1 else f'{count} mountings'}",
            not_included=found.not_included,
        )


def magnitude_result(found: Mountings) -> Result:
    """Return the magnitude √(ζx² + ζy² + ζz²); noise makes it larger where it is not far above its uncertainty."""
    own = found.own
    size = float(np.linalg.norm(own))
    direction = own / size if size > 0.0 else np.full(len(AXES), 1.0 / math.sqrt(len(AXES)))
    weights = estimate_weights(found, {place: float(one) for place, one in enumerate(direction)})
    return budgeted_result(
        budget_of(found, weights),
        name=MAGNITUDE,
        label="g-sensitivity, magnitude",
        value=size,
        unit=PER_G,
        condition="root of the sum of the squares of all three",
        not_included=found.not_included,
    )


def _cross_axes(found: Mountings) -> Iterator[Result]:
    """Give each mounting's own axis along the shaft; of several of the same axis, the first."""
    seen: set[int] = set()
    for one in found.mountings:
        measured = one.result(MOUNTED_CROSS_AXIS)
        if measured is None or one.unit.along in seen:
            continue
        seen.add(one.unit.along)
        axis = AXES[one.unit.along]
        yield Result(
            name=cross_axis_name(axis),
            label=f"Cross-axis sensitivity {axis}",
            value=measured.value,
            unit=measured.unit,
            expanded_uncertainty=measured.expanded_uncertainty,
            coverage_factor=measured.coverage_factor,
            condition=f"mounting {one.number + 1}",
            not_included=measured.not_included,
        )


def _agreement(found: Mountings) -> Iterator[Result]:
    """Give the difference of a coefficient that two mountings show; of several pairs that which agrees least."""
    pairs = [
        _difference(found, first, second, place)
        for number, first in enumerate(found.mountings)
        for second in found.mountings[number + 1 :]
        for place in first.values
        if place in second.values and first.unit.along != second.unit.along
    ]
    if not pairs:
        return
    worst = max(pairs, key=agreement_of)
    yield worst
    yield Result(
        name=AGREEMENT,
        label="Difference of the mountings over its U",
        value=100.0 * agreement_of(worst),
        unit="%",
        condition=f"{worst.condition}; up to 100 % they agree within the expanded uncertainty of the difference",
        not_included=found.not_included,
    )


def _difference(found: Mountings, first: Mounting, second: Mounting, place: int) -> Result:
    return budgeted_result(
        budget_of(found, {first.number: {place: 1.0}, second.number: {place: -1.0}}),
        name=DIFFERENCE,
        label="Doubly measured coefficient, difference",
        value=first.values[place] - second.values[place],
        unit=PER_G,
        condition=f"g-sensitivity {AXES[place]}, mounting {first.number + 1} less {second.number + 1}",
        not_included=found.not_included,
    )


def agreement_of(difference: Result) -> float:
    """Return |difference| over its expanded uncertainty."""
    return abs(difference.value or 0.0) / (difference.expanded_uncertainty or math.inf)


def _drifts(found: Mountings) -> Iterator[Result]:
    """Give the drift of all mountings, compensated with the combined coefficients.

    A coefficient that differs from the mounting's own by Δ adds Δ²/2 to the variance after compensation.
    """
    for name, of, label in (
        (BEFORE, MOUNTED_BEFORE, "Drift before compensation"),
        (AFTER, MOUNTED_AFTER, "Drift after compensation"),
    ):
        spreads = [one.result(of) for one in found.mountings]
        if any(one is None for one in spreads):
            continue
        yield _pooled(found, [one for one in spreads if one is not None], name, label)


def _pooled(found: Mountings, spreads: list[Result], name: str, label: str) -> Result:
    extra = [_changed(found, one) if name == AFTER else 0.0 for one in found.mountings]
    squares = [
        ((one.value or 0.0) * conversion_factor(one.unit, "deg/h")) ** 2 + more
        for one, more in zip(spreads, extra, strict=True)
    ]
    value = math.sqrt(sum(squares) / len(squares))
    ratios = [
        ((one.lower_95 or 0.0) / (one.value or 1.0), (one.upper_95 or 0.0) / (one.value or 1.0))
        for one in spreads
    ]
    narrower = 1.0 / math.sqrt(len(spreads))
    return Result(
        name=name,
        label=label,
        value=value,
        unit="deg/h",
        lower_95=value * (1.0 - narrower * (1.0 - min(low for low, _ in ratios))),
        upper_95=value * (1.0 + narrower * (max(high for _, high in ratios) - 1.0)),
        condition=f"root mean square over {len(spreads)} mountings"
        + ("; compensated with the coefficients from all of them" if name == AFTER else ""),
    )


def _changed(found: Mountings, one: Mounting) -> float:
    """Return what compensation with the combined coefficients adds to the variance, (°/h)²."""
    apart = [found.estimates[place].value - value for place, value in one.values.items()]
    return 0.5 * sum((3600.0 * each * one.unit.pose.gravity_g) ** 2 for each in apart)
