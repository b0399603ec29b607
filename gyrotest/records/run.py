"""The run record: everything that a certificate is drawn from."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from datetime import datetime
from enum import StrEnum

from gyrotest.records.figure import Figure
from gyrotest.records.recording import Identity, Recording
from gyrotest.records.result import JudgedResult, Verdict
from gyrotest.records.spec import SpecDocument
from gyrotest.records.station import StationDocument

SCHEMA_VERSION = 1


class Outcome(StrEnum):
    """How an attempt at an item ended; `ACQUIRED`: recorded, and not judged yet."""

    ACQUIRED = "acquired"
    PASSED = "passed"
    FAILED = "failed"
    ERROR = "error"
    SKIPPED = "skipped"
    INTERRUPTED = "interrupted"


class Origin(StrEnum):
    """Where the samples came from."""

    MEASURED = "measured"
    SIMULATED = "simulated"
    REPLAYED = "replayed"


@dataclass(frozen=True, slots=True, kw_only=True)
class InstrumentUse:
    """An instrument of the station as it was found and used."""

    name: str
    driver: str
    resource: str
    identity: Identity


@dataclass(frozen=True, slots=True, kw_only=True)
class ExportedFile:
    """A file for other programs, relative to the run's folder, and its SHA-256 (hex)."""

    path: str
    sha256: str


@dataclass(frozen=True, slots=True, kw_only=True)
class Attempt:
    """One try at an item: results where it was judged, a message where it was not.

    `events` are faults that were overcome, `remarks` what else is to be known; `truth` holds a
    simulated unit's true parameters (names with their units, e.g. `turn_on_bias_dps`), empty on a
    real bench.
    """

    item: str
    number: int
    outcome: Outcome
    started_utc: datetime
    ended_utc: datetime
    issued_utc: datetime
    message: str = ""
    origin: Origin | None = None
    recording: Recording | None = None
    instruments: tuple[InstrumentUse, ...] = ()
    events: tuple[str, ...] = ()
    remarks: tuple[str, ...] = ()
    truth: Mapping[str, float] = field(default_factory=dict)
    results: tuple[JudgedResult, ...] = ()
    figures: tuple[Figure, ...] = ()
    exports: tuple[ExportedFile, ...] = ()


@dataclass(frozen=True, slots=True, kw_only=True)
class PlannedItem:
    """An item that the run owes: an acquisition (`repeat` 1 …) or what is computed over repeats (None)."""

    name: str
    case: str
    repeat: int | None


@dataclass(frozen=True, slots=True, kw_only=True)
class ItemRecord:
    """A planned item, every attempt at it, and why it is missing where it is."""

    plan: PlannedItem
    attempts: tuple[Attempt, ...] = ()
    missing: str = ""

    @property
    def last(self) -> Attempt | None:
        """The attempt that counts."""
        return self.attempts[-1] if self.attempts else None

    @property
    def failed(self) -> bool:
        """Whether the attempt that counts failed without a limit's verdict (a user's own assertion)."""
        last = self.last
        return (
            last is not None
            and last.outcome is Outcome.FAILED
            and not any(one.verdict not in (None, Verdict.PASS) for one in last.results)
        )


@dataclass(frozen=True, slots=True, kw_only=True)
class RunHeader:
    """What is known before the first sample."""

    run_id: str
    model: str
    serial_number: str
    started_utc: datetime
    spec: SpecDocument
    station: StationDocument
    operator: str = ""
    meta: Mapping[str, str] = field(default_factory=dict)
    software: Mapping[str, str] = field(default_factory=dict)
    command: str = ""
    attempt: int = 1
    earlier_runs: tuple[str, ...] = ()
    deviations: tuple[str, ...] = ()
    plan: tuple[PlannedItem, ...] = ()
    slot: str = ""


@dataclass(frozen=True, slots=True, kw_only=True)
class RunRecord:
    """A run of one serial number; `results` lists every judged result of the items that count."""

    schema_version: int
    run_id: str
    model: str
    serial_number: str
    verdict: Verdict
    simulated: bool
    replayed: bool
    issued_utc: datetime
    header: RunHeader
    items: tuple[ItemRecord, ...]
    results: tuple[JudgedResult, ...]
    missing: tuple[str, ...] = ()
    amends: str | None = None
