"""The values that an analysis gives, in the units in which they are customary."""

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace

from gyrotest.analysis.noise_model import TauRange
from gyrotest.offline.analysis import Analysis
from gyrotest.procedures.static.terms import ANGLE_WALK, TERMS, Term

_DPH = 3600.0
_ROOT_3 = math.sqrt(3.0)
_WHOLE = 1.0 - 1e-9  # of an interval: a larger duty is no dead time


@dataclass(frozen=True, slots=True, kw_only=True)
class Reading:
    """A value with its 95 % interval in `unit`; with `at_most` it is no more than an upper limit.

    None where there is no value, and then `note` says why. `carries` are the averaging times at
    which a term of the noise model makes itself felt, `tau_s` where a value was read off;
    `datasheet` and `ratio` compare it with the datasheet's figure.
    """

    name: str
    label: str
    unit: str
    value: float | None
    lower_95: float = 0.0
    upper_95: float = 0.0
    at_most: bool = False
    carries: TauRange | None = None
    tau_s: float | None = None
    note: str = ""
    datasheet: float | None = None

    @property
    def ratio(self) -> float | None:
        """Value over the datasheet's figure."""
        if self.value is None or not self.datasheet:
            return None
        return self.value / self.datasheet


def readings(analysis: Analysis) -> tuple[Reading, ...]:
    """Return the five terms, Q N B K R, and the Allan minimum."""
    return (*_terms(analysis), _minimum(analysis))


def _terms(analysis: Analysis) -> Iterator[Reading]:
    for term in TERMS:
        fitted = _fitted(analysis, term)
        if term is not ANGLE_WALK:
            yield fitted
            continue
        yield _true_walk(analysis, fitted)
        if analysis.duty < _WHOLE:
            yield replace(
                fitted, name=f"{term.name}_apparent", label=f"{fitted.label}, as read", datasheet=None
            )


def _fitted(analysis: Analysis, term: Term) -> Reading:
    found, factor = term.of(analysis.model), term.per_core
    return Reading(
        name=term.name,
        label=f"{term.label} {term.letter}",
        unit=term.unit,
        value=factor * (found.value if found.resolved else found.upper_95),
        lower_95=factor * found.lower_95,
        upper_95=factor * found.upper_95,
        at_most=not found.resolved,
        carries=found.carries if found.resolved else None,
        note="" if found.resolved else "not resolved",
        datasheet=_datasheet(analysis, term.name, term.unit),
    )


def _true_walk(analysis: Analysis, fitted: Reading) -> Reading:
    """Take the dead time out of an angle random walk, or the value where that cannot be done."""
    dead_time = analysis.dead_time
    if dead_time is None or fitted.value is None:
        return replace(fitted, value=None, carries=None, at_most=False, note="dead time")
    value = fitted.value * dead_time.factor
    extra = 2.0 * dead_time.half_width / _ROOT_3 * value
    below = math.hypot(value - fitted.lower_95 * dead_time.factor, extra)
    above = math.hypot(fitted.upper_95 * dead_time.factor - value, extra)
    return replace(fitted, value=value, lower_95=max(value - below, 0.0), upper_95=value + above)


def _minimum(analysis: Analysis) -> Reading:
    found = analysis.minimum
    absent = Reading(
        name="allan_minimum",
        label="Allan deviation, minimum",
        unit="deg/h",
        value=None,
        note="too short",
        datasheet=_datasheet(analysis, "allan_minimum", "deg/h"),
    )
    if found is None:
        return absent
    return replace(
        absent,
        value=found.deviation_dps * _DPH,
        lower_95=found.lower_95_dps * _DPH,
        upper_95=found.upper_95_dps * _DPH,
        at_most=not found.reached,
        tau_s=found.tau_s,
        note="" if found.reached else "floor not reached",
    )


def _datasheet(analysis: Analysis, name: str, unit: str) -> float | None:
    stated = analysis.datasheet.get(name)
    return None if stated is None else stated.to(unit)
