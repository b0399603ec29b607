"""The plan: what a procedure wants acquired, and what it is given to reduce."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import StrEnum
from typing import Any

from gyrotest.records.figure import Figure
from gyrotest.records.recording import Dwell, Gap, Identity
from gyrotest.records.result import Result
from gyrotest.records.spec import Case, Output
from gyrotest.records.station import Accuracy, Encoder, Shaft, Site
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
class Rotating:
    """The stage turns evenly through a turn: from 0° to 360° at a positive rate, back at a negative one.

    It starts from rest at the one end. Within `run_up_deg` of either end it runs up and stops: samples
    are taken between, and never is an angle beyond the ends reached.
    """

    rate_dps: float
    run_up_deg: float
    tolerance_dps: float = 0.05

    @property
    def sampled_deg(self) -> float:
        """The angle that is turned while samples are taken."""
        return 360.0 - 2.0 * self.run_up_deg


@dataclass(frozen=True, slots=True, kw_only=True)
class Pointing:
    """The stage holds an angle for `settle_s` before the first sample.

    It lies between 0° and 360°, and is reached without going beyond these.
    """

    position_deg: float
    settle_s: float = 0.0
    tolerance_deg: float = 0.1


class Excitation(StrEnum):
    """How a vibration table moves."""

    NONE = "none"
    RANDOM = "random"
    SINE = "sine"
    SWEEP = "sweep"


@dataclass(frozen=True, slots=True, kw_only=True)
class Vibrating:
    """The vibration table moves, with a root mean square of its rate, for `settle_s` before the first sample.

    Randomly between two frequencies; as a sine (both are the same); or as a sine whose frequency goes
    evenly on a logarithmic scale from the one to the other while the step is sampled.
    """

    excitation: Excitation
    rms_dps: float = 0.0
    low_hz: float = 0.0
    high_hz: float = 0.0
    settle_s: float = 0.0


Stimulus = Turning | Soaking | Rotating | Pointing | Vibrating


@dataclass(frozen=True, slots=True, kw_only=True)
class Placement:
    """How a unit is mounted for an acquisition: turned by `turned_deg` about its own sensitive axis.

    Counted right-handed from the mounting that its slot describes; `sensitive_axis` is one of x, y, z.
    """

    sensitive_axis: str
    turned_deg: float


@dataclass(frozen=True, slots=True, kw_only=True)
class Step:
    """A dwell of a plan: `samples` while a stimulus holds (None: the bench is left as it is).

    `may_saturate`: overloaded samples are data here and do not end the acquisition.
    """

    samples: int
    name: str = ""
    stimulus: Stimulus | None = None
    may_saturate: bool = False


@dataclass(frozen=True, slots=True, kw_only=True)
class Plan:
    """One acquisition: warm up (once after each power-on), then the steps, a sample every `interval_s`.

    The samples of all steps stand in one recording and are numbered through; what passes between two
    steps (run-up, settling) is no gap. `auxiliary` names what the reduction looks at beside the output,
    each by its name or how that begins; all else is recorded and not read again. `placements` are how
    the unit is mounted in each repeat, over and over (none: as it is); the operator is asked to change it.
    """

    warm_up_s: float
    interval_s: float
    steps: tuple[Step, ...]
    auxiliary: tuple[str, ...] = ()
    placements: tuple[Placement, ...] = ()

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
        """Whether a rate table (or a stage) is needed."""
        return any(isinstance(step.stimulus, Turning | Rotating | Pointing) for step in self.steps)

    @property
    def rotates(self) -> bool:
        """Whether that has to be a stage with a level shaft."""
        return any(isinstance(step.stimulus, Rotating | Pointing) for step in self.steps)

    @property
    def vibrates(self) -> bool:
        """Whether a vibration table is needed."""
        return any(isinstance(step.stimulus, Vibrating) for step in self.steps)

    @property
    def soaks(self) -> bool:
        """Whether a temperature chamber is needed."""
        return any(isinstance(step.stimulus, Soaking) for step in self.steps)

    def placement(self, repeat: int | None) -> Placement | None:
        """How the unit is mounted in a repeat, counted from 1; None where it is left as it is."""
        if not self.placements or repeat is None:
            return None
        return self.placements[(repeat - 1) % len(self.placements)]


@dataclass(frozen=True, slots=True, kw_only=True)
class Context:
    """What a reduction may use beside the samples, which are those of one axis.

    `axis` is its name (empty for a single-axis gyro), `case.mounting` the direction of this very axis.
    `dwells` are the plan's steps as they were carried out; `table` and `chamber` the accuracy of what
    moved the unit (None: not known, or there is none). `earlier` holds this axis's results of the
    cases that were judged before, by case, each case's repeats one after another.
    `since_power_on_s` is the time from power-on to the record's begin (None: not known). `repeat` counts
    from 1 (None: what is over the repeats). `encoder` is that of the slot, `frame` how the unit's own axes
    lie in the stage's as its slot describes it, `placement` how it is turned from there; `shaft` is how
    the stage's shaft lies.
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
    repeat: int | None = None
    encoder: Encoder | None = None
    frame: Mapping[str, str] = field(default_factory=dict)
    placement: Placement | None = None
    shaft: Shaft | None = None


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
