"""Ideal Aerosmith rate table by its table language (ATL): three letters and a number over a serial line."""

import contextlib
import re
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Annotated, Any, ClassVar

from gyrotest.errors import InstrumentError, InstrumentProtocolError
from gyrotest.instruments.exchange import Exchange
from gyrotest.instruments.identity import Expected, check_identity, parse_identity
from gyrotest.instruments.motion import Envelope, Progress, max_acceleration_dps2
from gyrotest.instruments.standstill import (
    comes_to_rest,
    dismiss,
    guard_for,
    seen_at_rest,
    start_guard,
    stop_surely,
)
from gyrotest.instruments.transport.channel import Connect, SerialLine
from gyrotest.instruments.transport.conversation import shown
from gyrotest.instruments.transport.serial_port import open_commands_only
from gyrotest.ports import Clock
from gyrotest.records.described import Described
from gyrotest.records.recording import Identity
from gyrotest.records.station import Motion
from gyrotest.units import Dimension, OfDimension, Quantity

_RATE_SPAN = Quantity(1.0, "s")
_SHORTEST_SPAN_S, _LONGEST_SPAN_S = 0.1, 30.0
_END = b"\r"
_PROMPT = b">"
_NUMBER = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)(E[+-]?\d+)?", re.IGNORECASE)
_COMMAND = re.compile(r"[A-Z]{3}\d*")

_EXPECTED = Expected(
    manufacturer=re.compile("AEROSMITH", re.IGNORECASE),
    model=re.compile(".+"),
    spoken="an Ideal Aerosmith rate table",
)


@dataclass(frozen=True, slots=True, kw_only=True)
class AerosmithSettings:
    """The station's settings of an Ideal Aerosmith rate table."""

    __pydantic_config__: ClassVar[Mapping[str, Any]] = {"extra": "forbid", "strict": True}

    baud_rate: Annotated[
        int, Described("Baud rate of the line; 8 data bits, no parity, 1 stop bit.", "9600")
    ] = 9600
    rate_query: Annotated[
        str,
        Described(
            "The command that prints the rate, where the controller's manual has one; without it the rate"
            " follows from two positions."
        ),
    ] = ""
    rate_span: Annotated[
        Quantity,
        OfDimension(Dimension.TIME),
        Described(
            "Least time between the two positions that give a rate: 1 ms of jitter in 1 s is 0.1 % of it.",
            "1 s",
        ),
    ] = _RATE_SPAN
    home: Annotated[
        bool,
        Described("Send HOM when the drive is switched on: the table turns to its home angle."),
    ] = False

    def __post_init__(self) -> None:
        if self.rate_query and not _COMMAND.fullmatch(self.rate_query):
            raise ValueError(
                f"rate_query '{self.rate_query}' is no command of three capital letters (and a number)"
            )
        if not _SHORTEST_SPAN_S <= self.rate_span.to("s") <= _LONGEST_SPAN_S:
            raise ValueError(
                f"rate_span {self.rate_span} is not {_SHORTEST_SPAN_S:g} s to {_LONGEST_SPAN_S:g} s"
            )
        SerialLine(baud_rate=self.baud_rate)


class Aerosmith:
    """One axis; `enable` starts a guard that stops it when this process is killed."""

    settings: ClassVar[type] = AerosmithSettings

    def __init__(
        self,
        resource: str,
        settings: AerosmithSettings,
        *,
        clock: Clock,
        motion: Motion,
        io_timeout_s: float | None = None,
        serial_number: str | None = None,
        connect: Connect = open_commands_only,
    ) -> None:
        line = SerialLine(baud_rate=settings.baud_rate)
        self._settings = settings
        self._clock = clock
        self._motion = motion
        self._serial_number = serial_number
        self._exchange = Exchange(resource, line, connect=connect, io_timeout_s=io_timeout_s)
        self._envelope = Envelope(resource, motion)
        self._progress = Progress(clock, settings.rate_span.to("s"))
        self._enabled = False
        self._guard = guard_for(resource, line, ("STO\r", "JOG0\r", "STO\r"), who=resource)

    def open(self) -> Identity:
        """Connect and ask who is there; raises `InstrumentError`."""
        self._exchange.open()
        try:
            identity = self._identify()
            position_deg = self._number("PPO")
        except InstrumentError:
            self._exchange.close()
            raise
        self._serial_number = identity.serial_number
        if self._envelope.begun:
            self._envelope.read(self._clock.now_s(), position_deg)
        else:
            self._envelope.begin(self._clock.now_s(), position_deg)
        return identity

    def enable(self) -> None:
        """Acceleration set, drive on, at rest; raises `InstrumentError`."""
        start_guard(self._guard, self._exchange.who)
        self._enabled = True
        self._command("STO")
        if not comes_to_rest(self._clock, self._motion, self.rate_dps):
            raise InstrumentError(
                f"{self._exchange.who}: the table turns and does not come to rest; stop it at the controller,"
                " and see who else is using it"
            )
        self._command(f"ACL{_text(max_acceleration_dps2(self._motion))}")
        self._command("SRV1")
        if self._settings.home:
            self._home()
        self._set(0.0)

    def set_rate(self, rate_dps: float) -> None:
        """Ask for a rate; raises `InstrumentError`, before anything is sent, beyond what is allowed."""
        self._envelope.refuse_rate(self._clock.now_s(), rate_dps)
        self._set(rate_dps)

    def rate_dps(self) -> float:
        """The rate that is read back, or follows from two positions with a while between them, °/s."""
        if self._settings.rate_query:
            rate_dps = self._number(self._settings.rate_query)
            self.position_deg()
            return rate_dps
        if (pause_s := self._progress.pause_s()) > 0.0:
            self.position_deg()
            self._clock.sleep_until(self._clock.now_s() + pause_s)
        self.position_deg()
        return self._progress.rate_dps()

    def position_deg(self) -> float:
        """The angle that the controller reads back, with the turns counted, °.

        Raises `InstrumentError`, also when the cables are wound up; the table is stopped then.
        """
        asked_s = self._clock.now_s()
        position_deg = self._number("PPO")
        # Half of the way there and back, of which the line's time is the same each time.
        read_s = (asked_s + self._clock.now_s()) / 2
        try:
            angle_deg = self._envelope.read(read_s, position_deg)
        except InstrumentError:
            self.stop()
            raise
        self._progress.read(read_s, angle_deg)
        return angle_deg

    def move_to(self, position_deg: float) -> None:
        """Ask for an angle; raises `InstrumentError`, before anything is sent, too."""
        self._envelope.refuse_move(self._clock.now_s(), position_deg)
        self._command(f"P{_text(position_deg)}")
        self._envelope.moved(self._clock.now_s(), position_deg)
        self._progress.begin(None)

    def stop(self) -> None:
        """Rate 0 from whatever it does; never raises."""
        if self._enabled:
            stop_surely(self._exchange, self._send_stop, self._guard)
        elif self._exchange.is_open:
            with contextlib.suppress(InstrumentError):
                self._send_stop()
        if self._envelope.begun:
            self._envelope.demanded(self._clock.now_s(), 0.0)
        self._progress.begin(0.0)

    def close(self) -> None:
        """At rest, drive off, disconnected; idempotent, never raises."""
        at_rest = not self._enabled or self._switched_off()
        self._exchange.close()
        dismiss(self._guard, at_rest=at_rest)

    def _switched_off(self) -> bool:
        """Stop, and switch off; whether the table was seen at rest."""
        self.stop()
        at_rest = seen_at_rest(self._clock, self._motion, self.rate_dps)
        with contextlib.suppress(InstrumentError):
            self._command("SRV0")
        self._enabled = False
        return at_rest

    def _send_stop(self) -> None:
        try:
            self._command("STO")
        except InstrumentProtocolError:
            self._exchange.insist("STO", _END)

    def _set(self, rate_dps: float) -> None:
        self._command(f"JOG{_text(rate_dps)}" if rate_dps else "STO")
        self._envelope.demanded(self._clock.now_s(), rate_dps)
        self._progress.begin(rate_dps)

    def _identify(self) -> Identity:
        """Controllers have no identity query and refuse it; whoever has an answer is believed."""
        reply = self._exchange.until("*IDN?", _END, reply_end=_PROMPT).decode("ascii", "replace")
        identity = parse_identity(_content(reply, "*IDN?"))
        if identity is None:
            self._exchange.name("Ideal Aerosmith")
            return Identity(
                manufacturer="Ideal Aerosmith",
                model="rate table (ATL)",
                serial_number=self._serial_number or "not stated",
            )
        check_identity(
            identity, who=self._exchange.who, expected=_EXPECTED, serial_number=self._serial_number
        )
        self._exchange.name(identity.model)
        self._envelope.who = self._exchange.who
        return identity

    def _home(self) -> None:
        self._command("HOM")
        if not comes_to_rest(self._clock, self._motion, self.rate_dps):
            raise InstrumentError(
                f"{self._exchange.who}: does not come to rest after HOM; is it mechanically free?"
            )

    def _number(self, query: str) -> float:
        found = self._ask(query)
        if not _NUMBER.fullmatch(found):
            raise InstrumentProtocolError(
                f"{self._exchange.who}: {query} gives {shown(found.encode())}, expected a number; is this the"
                " table's controller, and is its baud rate right?"
            )
        return float(found)

    def _command(self, command: str) -> None:
        """Send a command and see that it was taken; raises `InstrumentError`."""
        found = self._ask(command)
        if found:
            raise InstrumentProtocolError(
                f"{self._exchange.who}: {command} is answered with {shown(found.encode())}, expected '>' alone;"
                " is this the table's controller?"
            )

    def _ask(self, command: str) -> str:
        reply = self._exchange.until(command, _END, reply_end=_PROMPT).decode("ascii", "replace")
        found = _content(reply, command)
        if "?" in found:
            raise InstrumentProtocolError(
                f"{self._exchange.who}: the controller answers '?' to {command}: refused; is the drive on, are its"
                " interlocks closed, and is the value within what the table can do?"
            )
        return found


def _content(reply: str, command: str) -> str:
    """What stands before the prompt, without the echo that some controllers send."""
    found = reply.removesuffix(_PROMPT.decode()).strip()
    return found.removeprefix(command).strip()


def _text(value: float) -> str:
    return f"{value:.6f}".rstrip("0").rstrip(".")
