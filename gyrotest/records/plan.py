"""The plan: what a procedure wants acquired, and what it is given to reduce."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from gyrotest.records.figure import Figure
from gyrotest.records.recording import Gap, Identity
from gyrotest.records.result import Result
from gyrotest.records.spec import Case, Output
from gyrotest.records.station import Accuracy, Site
from gyrotest.units import Quantity


@dataclass(frozen=True, slots=True, kw_only=True)
class Plan:
    """One acquisition: warm up (once after each power-on), then `samples` every `interval_s`."""

    warm_up_s: float
    interval_s: float
    samples: int

    @property
    def duration_s(self) -> float:
        """The record's length, s."""
        return self.samples * self.interval_s


@dataclass(frozen=True, slots=True, kw_only=True)
class Context:
    """What a reduction may use beside the samples.

    `since_power_on_s` is the time from power-on to the record's begin (None: not known).
    """

    case_name: str
    case: Case
    parameters: Any
    output: Output
    datasheet: Mapping[str, Quantity]
    accuracy: Accuracy | None
    site: Site | None
    source: Identity | None = None
    gaps: tuple[Gap, ...] = ()
    since_power_on_s: float | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class Reduction:
    """What a procedure makes of an acquisition, or of all repeats."""

    results: tuple[Result, ...]
    figures: tuple[Figure, ...] = ()
    remarks: tuple[str, ...] = ()
