"""The ports: what the stages ask of a bench, as Protocols of a few methods."""

from collections.abc import Iterable
from datetime import datetime
from typing import Any, Protocol, runtime_checkable

from gyrotest.records.plan import Context, Plan, Reduction
from gyrotest.records.recording import Block, Identity, Samples, Sampling
from gyrotest.records.result import Measurand, Result
from gyrotest.records.spec import Case, Output


class Clock(Protocol):
    """Time. On a bench it is the real one; the simulated bench owns a virtual one."""

    def now_s(self) -> float:
        """Monotonic time, s."""

    def utc(self) -> datetime:
        """Aware UTC; follows `now_s` from the clock's start."""

    def sleep_until(self, deadline_s: float) -> None:
        """Return when `now_s()` has reached the deadline; at once if it has passed."""


class Source(Protocol):
    """Whatever gives the gyro's output as samples: a multimeter, a digital gyro, a replayed file.

    A driver is made with its station entry and a clock, connects in `open`, and is used by one
    owner. `fetch` blocks until the next samples are there and is the only method that waits.
    Everything raises `InstrumentError` (a subclass that fits) with the resource in front.
    """

    def open(self) -> Identity:
        """Connect, ask who is there, put the instrument into a known state."""

    def configure(self, interval_s: float) -> Sampling:
        """Set up sampling every `interval_s`, read the settings back, return what really is.

        Raises `InstrumentError` where the interval cannot be reached, naming the shortest one.
        """

    def start(self, first: int, count: int) -> None:
        """Begin: samples `first` … `count - 1` of the grid whose sample 0 was due at the first start."""

    def fetch(self) -> Block | None:
        """Wait for the next samples; None after the last one (a replayed file may end early)."""

    def recover(self) -> int:
        """Bring the instrument back after a fault: clear, same identity, settings again.

        Returns the position on the grid at which sampling can go on (the next future deadline).
        """

    def close(self) -> None:
        """Leave the instrument safe and disconnect; idempotent, never raises."""


@runtime_checkable
class Playback(Protocol):
    """A source that plays what was recorded elsewhere, like a tape."""

    def cue(self, position_s: float) -> None:
        """Wind to a position, seconds of samples from the begin; the next acquisition begins there."""

    def remarks(self) -> tuple[str, ...]:
        """What is to be known of the stretch that was played, for the certificate."""


class Procedure(Protocol):
    """A test kind: what it measures, what it needs acquired, what it makes of it. No I/O.

    `parameters` is the record (a frozen dataclass) that a case's `parameters:` are checked into.
    """

    parameters: type[Any]

    def measurands(self, case: Case, parameters: Any) -> tuple[Measurand, ...]:
        """Everything that a case with these parameters measures."""

    def complaints(self, case: Case, parameters: Any, output: Output) -> Iterable[tuple[str, str]]:
        """What is wrong with a case beyond its types: pairs of key (below the case) and message."""

    def plan(self, case: Case, parameters: Any) -> Plan:
        """The acquisition of one repeat."""

    def reduce(self, samples: Samples, context: Context) -> Reduction:
        """Results and figures of one acquisition; raises `InsufficientDataError`."""

    def reduce_repeats(self, repeats: tuple[tuple[Result, ...], ...], context: Context) -> Reduction:
        """Results over the repeats, from each repeat's results."""
