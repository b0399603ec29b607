"""Results as properties of a test's report, for JUnit XML and whoever else reads them: strings only."""

from collections.abc import Iterable, Iterator

import pytest

from gyrotest.records.result import JudgedLimit, JudgedResult

_PREFIX = "gyro."


def clear_properties(item: pytest.Item) -> None:
    """Drop the results of an earlier attempt; other plugins' properties stay."""
    item.user_properties[:] = [one for one in item.user_properties if not one[0].startswith(_PREFIX)]


def add_properties(item: pytest.Item, results: Iterable[JudgedResult]) -> None:
    """Report results: value with unit, and limit and verdict where there is a limit.

    They are named `gyro.bias`, of a gyro with several axes `gyro.x.bias`.
    """
    item.user_properties.extend(pair for one in results for pair in _pairs(one))


def _pairs(result: JudgedResult) -> Iterator[tuple[str, str]]:
    name = f"{_PREFIX}{result.axis}.{result.name}" if result.axis else f"{_PREFIX}{result.name}"
    yield name, "none" if result.value is None else f"{result.value!r} {result.unit}"
    if result.limit is not None:
        yield f"{name}.limit", _limit(result.limit)
    if result.verdict is not None:
        yield f"{name}.verdict", result.verdict.value


def _limit(limit: JudgedLimit) -> str:
    ends = (("min", limit.min), ("max", limit.max))
    return ", ".join(f"{name} {end!r} {limit.unit}" for name, end in ends if end is not None)
