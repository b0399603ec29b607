"""The order in which results are printed."""

from collections.abc import Hashable, Iterable
from typing import TypeVar

from gyrotest.records.result import JudgedResult
from gyrotest.records.run import RunRecord

_T = TypeVar("_T", bound=Hashable)


def in_order(record: RunRecord) -> tuple[JudgedResult, ...]:
    """Return all results: cases and axes as in the spec, in each case what was measured as it came.

    The repeats follow one another, what is computed over them comes last.
    """
    cases = _ranks((*record.header.spec.spec.cases, *(one.case for one in record.results)))
    names = _ranks((one.case, one.name) for one in record.results)
    axes = _ranks(axes_of(record))

    def place(one: JudgedResult) -> tuple[int, int, int, bool, int]:
        over = one.repeat is None
        return cases[one.case], names[one.case, one.name], axes[one.axis], over, one.repeat or 0

    return tuple(sorted(record.results, key=place))


def axes_of(record: RunRecord) -> tuple[str, ...]:
    """Return the axes of results and figures in the spec's order; what belongs to none comes first."""
    figures = (one.axis for item in record.items for attempt in item.attempts for one in attempt.figures)
    found = ("", *record.header.spec.spec.output.axes, *(one.axis for one in record.results), *figures)
    return tuple(dict.fromkeys(found))


def _ranks(values: Iterable[_T]) -> dict[_T, int]:
    return {value: rank for rank, value in enumerate(dict.fromkeys(values))}
