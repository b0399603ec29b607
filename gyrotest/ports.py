"""The ports: what the stages ask of a bench, as Protocols of a few methods."""

from collections.abc import Iterable
from datetime import datetime
from typing import Any, Protocol, runtime_checkable

from gyrotest.records.bench import DaqChannel, Device, Supplied
from gyrotest.records.plan import Context, Plan, Reduction
from gyrotest.records.recording import Block, Identity, Samples, SampleStream, Sampling
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


@runtime_checkable
class Remarking(Protocol):
    """A source that has more to say of an acquisition than its samples: what was lost, and why."""

    def remarks(self) -> tuple[str, ...]:
        """What is to be known of the acquisition made last, for the certificate."""


@runtime_checkable
class Selecting(Protocol):
    """A source with many channels, of which some are wanted."""

    def select(self, outputs: tuple[str, ...], auxiliary: tuple[str, ...]) -> None:
        """Say which, before `configure`: gyro outputs, and what is recorded beside them."""


@runtime_checkable
class SyncDaq(Selecting, Protocol):
    """A source with channels that one hardware clock takes, block by block of (n, channels) float64.

    Its `Sampling` is `synchronous`; `offsets_s` are the channels' skews, which the reduction corrects.
    It starts by itself or by a trigger, as its settings say. What it overran is missing from the grid
    and told in its remarks.
    """

    def channels(self) -> tuple[DaqChannel, ...]:
        """Every channel that it has, after `open`."""


@runtime_checkable
class DigitalGyro(Protocol):
    """A source that is itself the unit under test, and can say what it is and how it is set."""

    def device(self) -> Device:
        """What the unit says of itself, after `configure`; what it cannot be asked is None."""


class RateTable(Protocol):
    """A rate table, one axis of it. It is made with the station's `motion`, and refuses what lies beyond.

    Everything raises `InstrumentError` (a subclass that fits) with the resource in front, but `stop`
    and `close`, which never raise and may be called at any time.
    """

    def open(self) -> Identity:
        """Connect, ask who is there and whether an interlock is open; moves nothing."""

    def enable(self) -> None:
        """Set the controller's own limits, close the loop, hold at rate 0."""

    def set_rate(self, rate_dps: float) -> None:
        """Ask for a rate and return at once; the table gets there by the station's acceleration."""

    def rate_dps(self) -> float:
        """The rate that the controller reads back, °/s; a fault that it reports is raised."""

    def position_deg(self) -> float:
        """The angle that the controller reads back, °."""

    def move_to(self, position_deg: float) -> None:
        """Ask for an angle and return at once."""

    def stop(self) -> None:
        """Bring it to rest, whatever it does."""

    def close(self) -> None:
        """Stop, switch the drive off, disconnect; idempotent."""


class VibrationDrive(Protocol):
    """What drives an angular vibration table: levels are root mean squares of the table's rate.

    Everything raises `InstrumentError` (a subclass that fits) with the resource in front, but `stop`
    and `close`, which never raise and may be called at any time. What the drive cannot do, or the
    station does not allow, is refused before anything is sent.
    """

    def open(self) -> Identity:
        """Connect and ask who is there; moves nothing."""

    def random(self, *, rms_dps: float, low_hz: float, high_hz: float) -> None:
        """Move randomly between two frequencies, and return at once."""

    def sine(self, *, rms_dps: float, frequency_hz: float) -> None:
        """Move as a sine, and return at once."""

    def sweep(self, *, rms_dps: float, low_hz: float, high_hz: float, duration_s: float) -> None:
        """Begin a logarithmic sweep of that duration, and return at once."""

    def check(self) -> None:
        """See that it still does what it was asked for; raises `InstrumentError` where not."""

    def stop(self) -> None:
        """Bring the table to rest."""

    def close(self) -> None:
        """Stop and disconnect; idempotent."""


class PowerSupply(Protocol):
    """One output of a power supply. `off` and `close` may be called at any time."""

    def open(self) -> Identity:
        """Connect and ask who is there; an output that is on stays as it is."""

    def set(self, *, voltage_v: float, current_limit_a: float, over_voltage_v: float) -> None:
        """Set the protection first, then current limit and voltage; read all back."""

    def on(self) -> None:
        """Switch the output on and return at once."""

    def off(self) -> None:
        """Switch the output off and return at once."""

    def measure(self) -> Supplied:
        """Voltage and current at the output, and whether it is held by its current limit or tripped."""

    def close(self) -> None:
        """Switch the output off and disconnect; idempotent, never raises."""


class Chamber(Protocol):
    """A temperature chamber."""

    def open(self) -> Identity:
        """Connect and ask who is there."""

    def set_temperature(self, temperature_degc: float) -> None:
        """Ask for a temperature and return at once."""

    def temperature_degc(self) -> float:
        """The temperature that the chamber reads back, °C."""

    def close(self) -> None:
        """Leave it at rest (no heating or cooling) and disconnect; idempotent, never raises."""


class Procedure(Protocol):
    """A test kind: what it measures, what it needs acquired, what it makes of it. No I/O.

    It is `Reducing` or `StreamReducing`, and sees one axis at a time: of a gyro with several, its
    samples are reduced once for each.

    `parameters` is the record (a frozen dataclass) that a case's `parameters:` are checked into.
    """

    parameters: type[Any]

    def measurands(self, case: Case, parameters: Any, output: Output) -> tuple[Measurand, ...]:
        """Everything that a case with these parameters measures of such an output."""

    def complaints(self, case: Case, parameters: Any, output: Output) -> Iterable[tuple[str, str]]:
        """What is wrong with a case beyond its types: pairs of key (below the case) and message."""

    def plan(self, case: Case, parameters: Any) -> Plan:
        """The acquisition of one repeat."""

    def reduce_repeats(self, repeats: tuple[tuple[Result, ...], ...], context: Context) -> Reduction:
        """Results over the repeats, from each repeat's results."""


@runtime_checkable
class Reducing(Procedure, Protocol):
    """A procedure that is given an acquisition's samples all at once."""

    def reduce(self, samples: Samples, context: Context) -> Reduction:
        """Results and figures of one acquisition; raises `InsufficientDataError`."""


@runtime_checkable
class StreamReducing(Procedure, Protocol):
    """A procedure that reads an acquisition's samples block by block: they may exceed the memory."""

    def reduce_stream(self, stream: SampleStream, context: Context) -> Reduction:
        """Results and figures of one acquisition; raises `InsufficientDataError`."""
