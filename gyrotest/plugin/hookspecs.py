"""Hooks that gyrotest offers to conftests and plugins."""

from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import pytest

    from gyrotest.records.run import Attempt, RunRecord


def pytest_gyro_acquired(item: "pytest.Item", attempt: "Attempt") -> None:
    """An acquisition ended completely; it is recorded and not judged yet."""


def pytest_gyro_judged(item: "pytest.Item", attempt: "Attempt") -> None:
    """An item was judged; `attempt.results` has the values, limits and verdicts."""


def pytest_gyro_certified(config: "pytest.Config", record: "RunRecord", certificate: Path) -> None:
    """A certificate was written, at the end of the session."""
