"""The plan: what a procedure wants acquired, and what it is given to reduce."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from gyrotest.records.figure import Figure
from gyrotest.records.recording import Dwell, Gap, Identity
from gyrotest.records.result import Result
from gyrotest.records.spec import Case, Output
from gyrotest.records.station import Accuracy, Site
from gyrotest.units import Quantity


@dataclass(frozen=True, slots=True, kw_only=True)
class Turning:
    """The table turns at a rate (0: enabled and at rest).

    Settled means: within `tolerance_dps` of it, and `settle_s` longer, so that the gyro follows.
    """

    rate_dps: float
    settle_s: float = 0.0
    tolerance_dps: float = 0.05


@dataclass(frozen=True, slots=True, kw_only=True)
class Soaking:
    """The chamber holds a temperature: within `tolerance_c` of it for `soak_s` before the first sample."""

    temperature_degc: float
    soak_s: float
    tolerance_c: float = 0.5


@dataclass(frozen=True, slots=True, kw_only=True)
class Step:
    """A dwell of a plan: `samples` while a stimulus holds (None: the bench is left as it is).

    `may_saturate`: overloaded samples are data here and do not end the acquisition.
    """

    samples: int
    name: str = ""
    stimulus: Turning | Soaking | None = None
    may_saturate: bool = False


@dataclass(frozen=True, slots=True, kw_only=True)
class Plan:
    """One acquisition: warm up (once after each power-on), then the steps, a sample every `interval_s`.

    The samples of all steps stand in one recording and are numbered through; what passes between two
    steps (run-up, settling) is no gap. `auxiliary` names what the reduction looks at beside the output,
    each by its name or how that begins; all else is recorded and not read again.
    """

    warm_up_s: float
    interval_s: float
    steps: tuple[Step, ...]
    auxiliary: tuple[str, ...] = ()

    @property
    def samples(self) -> int:
        """Samples of all steps."""
        return sum(step.samples for step in self.steps)

    @property
    def duration_s(self) -> float:
        """Time that is sampled, s."""
        return self.samples * self.interval_s

    @property
    def turns(self) -> bool:
        """Whether a rate table is needed."""
        return any(isinstance(step.stimulus, Turning) for step in self.steps)

    @property
    def soaks(self) -> bool:
        """Whether a temperature chamber is needed."""
        return any(isinstance(step.stimulus, Soaking) for step in self.steps)


@dataclass(frozen=True, slots=True, kw_only=True)
class Context:
    """What a reduction may use beside the samples, which are those of one axis.

    `axis` is its name (empty for a single-axis gyro), `case.mounting` the direction of this very axis.
    `dwells` are the plan's steps as they were carried out; `table` and `chamber` the accuracy of what
    moved the unit (None: not known, or there is none). `earlier` holds this axis's results of the
    cases that were judged before, by case, each case's repeats one after another.
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
    axis: str = ""
    dwells: tuple[Dwell, ...] = ()
    table: Accuracy | None = None
    chamber: Accuracy | None = None
    earlier: Mapping[str, tuple[Result, ...]] = field(default_factory=dict)


@dataclass(frozen=True, slots=True, kw_only=True)
class Export:
    """A file for other programs: its name (without folder) and its text."""

    name: str
    text: str


@dataclass(frozen=True, slots=True, kw_only=True)
class Reduction:
    """What a procedure makes of an acquisition, or of all repeats."""

    results: tuple[Result, ...]
    figures: tuple[Figure, ...] = ()
    remarks: tuple[str, ...] = ()
    exports: tuple[Export, ...] = ()
