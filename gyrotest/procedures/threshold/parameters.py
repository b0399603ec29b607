"""What a threshold or resolution case may be told, what is wrong with it, and its steps."""

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise
from typing import Annotated

from gyrotest.procedures.case_plan import plan_of_steps, step_samples
from gyrotest.procedures.table_steps import TableParameters, table_complaints
from gyrotest.records.described import Described
from gyrotest.records.plan import Plan, Step, Turning
from gyrotest.records.spec import Case, Output
from gyrotest.units import Dimension, OfDimension, Quantity

_LEVELS = (0.25, 0.5, 1.0, 2.0)
_MOST_LEVELS, _MOST_STEPS = 20, 100
_AROUND = Quantity(10.0, "deg/s")
_OF_LEVEL = 1.0 / 3.0
"""Of a level: how near to its rate the table must be for a change by the level to be one."""


@dataclass(frozen=True, slots=True, kw_only=True)
class ThresholdParameters(TableParameters):
    """Parameters of a threshold case; its `duration` is that of each step."""

    value: Annotated[
        Quantity,
        OfDimension(Dimension.RATE),
        Described("the model's stated threshold or resolution, around which is tried", "0.05 deg/s"),
    ]
    levels: Annotated[
        tuple[float, ...],
        Described("sizes of the changes, as shares of the value, rising, 1 among them", "[0.5, 1, 2]"),
    ] = _LEVELS
    steps: Annotated[
        int, Described("changes up, and as many down, at each level; their mean counts", "4")
    ] = 4

    @property
    def around_dps(self) -> float:
        """The rate about which the input changes: rest."""
        return 0.0

    @property
    def sizes_dps(self) -> tuple[float, ...]:
        """The sizes of the changes, °/s."""
        return tuple(one * self.value.to("deg/s") for one in self.levels)


@dataclass(frozen=True, slots=True, kw_only=True)
class ResolutionParameters(ThresholdParameters):
    """Parameters of a resolution case."""

    around: Annotated[
        Quantity,
        OfDimension(Dimension.RATE),
        Described("the rate, not 0, about which the input changes", "10 deg/s"),
    ] = _AROUND

    @property
    def around_dps(self) -> float:
        """The rate about which the input changes, °/s."""
        return self.around.to("deg/s")


def small_step_plan(case: Case, parameters: ThresholdParameters) -> Plan:
    """Return up-and-down steps, level by level, from the rate around which is tried and back to it."""
    sizes = parameters.sizes_dps
    first = _step(case, parameters, "base", 0.0, sizes[0])
    changes = (
        _step(case, parameters, name, sign * size, size)
        for size in sizes
        for _ in range(parameters.steps)
        for name, sign in (("up", 1.0), ("base", 0.0), ("down", -1.0), ("base", 0.0))
    )
    return plan_of_steps(case, (first, *changes))


def _step(
    case: Case, parameters: ThresholdParameters, name: str, change_dps: float, size_dps: float
) -> Step:
    return Step(
        samples=step_samples(case),
        name=name,
        stimulus=Turning(
            rate_dps=parameters.around_dps + change_dps,
            settle_s=parameters.settle.to("s"),
            tolerance_dps=min(parameters.tolerance.to("deg/s"), largest_error_dps(size_dps)),
        ),
    )


def largest_error_dps(size_dps: float) -> float:
    """Return how near to its rate the table must be for a change of a size."""
    return _OF_LEVEL * size_dps


def small_step_complaints(
    case: Case, parameters: ThresholdParameters, output: Output, name: str
) -> Iterator[tuple[str, str]]:
    """Give what is wrong with a case that measures `name`, beyond its types: key and message."""
    yield from table_complaints(case, parameters, output)
    if parameters.value.value <= 0:
        yield "parameters.value", f"'{parameters.value}' is not more than zero"
        return
    if not 1 <= parameters.steps <= _MOST_STEPS:
        yield "parameters.steps", f"{parameters.steps} is not between 1 and {_MOST_STEPS}"
    levels = parameters.levels
    rising = all(low < high for low, high in pairwise(levels))
    if not levels or len(levels) > _MOST_LEVELS or not rising or levels[0] <= 0.0 or 1.0 not in levels:
        message = (
            f"must be rising numbers above 0, 1 among them, {_MOST_LEVELS} at most;"
            f" e.g. [{', '.join(f'{one:g}' for one in _LEVELS)}]"
        )
        yield "parameters.levels", message
        return
    yield from _around_complaints(parameters)
    yield from _limit_complaints(case, parameters, name)


def _around_complaints(parameters: ThresholdParameters) -> Iterator[tuple[str, str]]:
    largest = parameters.sizes_dps[-1]
    if isinstance(parameters, ResolutionParameters) and abs(parameters.around_dps) <= largest:
        message = (
            f"'{parameters.around}' is not beyond the largest change of {largest:g} deg/s:"
            " the input would reach 0, and the threshold with it"
        )
        yield "parameters.around", message


def _limit_complaints(
    case: Case, parameters: ThresholdParameters, name: str
) -> Iterator[tuple[str, str]]:
    """Refuse a limit that nothing tried can be held against."""
    limit = case.limits.get(name)
    if limit is None or limit.max is None:
        return
    smallest, largest = parameters.sizes_dps[0], parameters.sizes_dps[-1]
    if not smallest <= limit.max.to("deg/s") < largest:
        message = (
            f"'{limit.max}' must be at least the smallest change that is tried, {smallest:g} deg/s, and below"
            f" the largest, {largest:g} deg/s; see 'parameters.value' and 'parameters.levels'"
        )
        yield f"limits.{name}.max", message
