"""Results: measured values with their uncertainty, the limits and the verdicts on them."""

from dataclasses import dataclass
from enum import StrEnum

from gyrotest.records.spec import DecisionRule, Over
from gyrotest.units import Dimension


class Verdict(StrEnum):
    """The outcome of a limit, a case or a run, from best to worst."""

    PASS = "PASS"
    CONDITIONAL_PASS = "CONDITIONAL_PASS"
    CONDITIONAL_FAIL = "CONDITIONAL_FAIL"
    FAIL = "FAIL"
    INCOMPLETE = "INCOMPLETE"


@dataclass(frozen=True, slots=True, kw_only=True)
class Measurand:
    """What a procedure can measure in a case, declared before anything is measured.

    `unit` is the unit of report where no limit asks for another.
    """

    name: str
    label: str
    dimension: Dimension
    unit: str
    over: Over | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class Contribution:
    """A line of an uncertainty budget, in the result's unit. `degrees_of_freedom` None: infinite."""

    source: str
    kind: str
    distribution: str
    half_width: str
    sensitivity: str
    standard_uncertainty: float
    degrees_of_freedom: float | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class Result:
    """A measured value in `unit`, with an expanded uncertainty or a 95 % interval.

    `at_most` says that the value is an upper bound (printed with ≤), `at_least` that it is a lower one
    (≥). What was not evaluated is None; where that is the value itself, `condition` says why.
    `not_included` names contributions that could not be had.
    """

    name: str
    label: str
    value: float | None
    unit: str
    expanded_uncertainty: float | None = None
    coverage_factor: float | None = None
    lower_95: float | None = None
    upper_95: float | None = None
    at_most: bool = False
    at_least: bool = False
    condition: str = ""
    budget: tuple[Contribution, ...] = ()
    not_included: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True, kw_only=True)
class JudgedLimit:
    """A limit as it was applied, in the result's unit."""

    min: float | None
    max: float | None
    unit: str
    decision: DecisionRule
    over: Over | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class JudgedResult:
    """A result of a case, the limit on it (or None) and the verdict (None: for information).

    `axis` is the axis that it belongs to (empty for a single-axis gyro).
    """

    case: str
    repeat: int | None
    axis: str = ""
    name: str
    label: str
    value: float | None
    unit: str
    expanded_uncertainty: float | None = None
    coverage_factor: float | None = None
    lower_95: float | None = None
    upper_95: float | None = None
    at_most: bool = False
    at_least: bool = False
    condition: str = ""
    limit: JudgedLimit | None = None
    verdict: Verdict | None = None
    reason: str = ""
    budget: tuple[Contribution, ...] = ()
    not_included: tuple[str, ...] = ()
