"""Entry-point name → class, loaded on first use. Built-ins have no private road."""

from functools import cache
from importlib.metadata import EntryPoints, entry_points
from typing import Any

from gyrotest.errors import GyrotestError

PROCEDURES = "gyrotest.procedures"
INSTRUMENTS = "gyrotest.instruments"


def names(group: str) -> tuple[str, ...]:
    """The names registered in a group, sorted."""
    return tuple(sorted({point.name for point in _points(group)}))


def load(group: str, name: str) -> Any:
    """Load the class registered under a name; raises `GyrotestError` if there is none."""
    found = [point for point in _points(group) if point.name == name]
    if not found:
        known = ", ".join(names(group)) or "none"
        raise GyrotestError(f"'{name}' is not among the {group} that are installed ({known})")
    return found[0].load()


@cache
def _points(group: str) -> EntryPoints:
    """What is installed in a group; every distribution's files are read for it, so once a process."""
    return entry_points(group=group)
