"""ACUTROL3000 rate-table controller, one axis in rate mode, by its command language (ACL)."""

import contextlib
import re
from collections.abc import Mapping
from dataclasses import dataclass
from enum import StrEnum
from typing import Annotated, Any, ClassVar

from gyrotest.errors import InstrumentError, InstrumentProtocolError
from gyrotest.instruments.exchange import Exchange
from gyrotest.instruments.identity import Expected, check_identity, parse_identity
from gyrotest.instruments.motion import Envelope, max_acceleration_dps2, max_rate_dps
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

_STATUS_BYTES = 8
_TAKEN = b"OK"
_MOST_AXES = 6
# IEEE 488.2 11.2: bit 6 of the status byte is the master summary, set while something is wrong.
_SUMMARY = 1 << 6
_SETTING_TOLERANCE = 1e-4

_EXPECTED = Expected(
    manufacturer=re.compile("ACUTRONIC", re.IGNORECASE),
    model=re.compile("ACUTROL.*", re.IGNORECASE),
    spoken="an Acutronic ACUTROL3000",
)


class Dialect(StrEnum):
    """How the controller's interface answers."""

    PLAIN = "plain"
    STATUS = "status"


@dataclass(frozen=True, slots=True, kw_only=True)
class Acutrol3000Settings:
    """The station's settings of an ACUTROL3000."""

    __pydantic_config__: ClassVar[Mapping[str, Any]] = {"extra": "forbid", "strict": True}

    axis: Annotated[int, Described("The controller's axis that is turned.", "1")] = 1
    dialect: Annotated[
        Dialect,
        Described(
            "`plain`: only queries, which end with '?', are answered, by a line. `status`: every command is"
            " answered, with status bytes in front, commands with OK."
        ),
    ] = Dialect.PLAIN
    prefix_bytes: Annotated[
        int | None,
        Described("Status bytes in front of each reply; not given: 0 with `plain`, 8 with `status`."),
    ] = None
    baud_rate: Annotated[
        int, Described("Baud rate of a serial line; 8 data bits, no parity, 1 stop bit.")
    ] = 9600

    def __post_init__(self) -> None:
        if not 1 <= self.axis <= _MOST_AXES:
            raise ValueError(f"axis {self.axis} is not 1 to {_MOST_AXES}")
        if self.prefix_bytes is not None and self.prefix_bytes < 0:
            raise ValueError(f"prefix_bytes {self.prefix_bytes} is less than 0")
        SerialLine(baud_rate=self.baud_rate)


class Acutrol3000:
    """One axis of the controller; `enable` starts a guard that stops it when this process is killed."""

    settings: ClassVar[type] = Acutrol3000Settings

    def __init__(
        self,
        resource: str,
        settings: Acutrol3000Settings,
        *,
        clock: Clock,
        motion: Motion,
        io_timeout_s: float | None = None,
        serial_number: str | None = None,
        connect: Connect = open_commands_only,
    ) -> None:
        line = SerialLine(baud_rate=settings.baud_rate)
        self._axis = settings.axis
        self._clock = clock
        self._motion = motion
        self._serial_number = serial_number
        self._exchange = Exchange(resource, line, connect=connect, io_timeout_s=io_timeout_s)
        self._envelope = Envelope(resource, motion)
        self._answers = settings.dialect is Dialect.STATUS
        self._prefix_bytes = settings.prefix_bytes
        if settings.prefix_bytes is None:
            self._prefix_bytes = _STATUS_BYTES if self._answers else 0
        self._end = b"\r\n" if self._answers else b"\n"
        self._enabled = False
        stop = tuple(f"{command}{self._end.decode()}" for command in self._stopping())
        self._guard = guard_for(resource, line, stop, who=resource)

    def open(self) -> Identity:
        """Connect, ask who is there and whether an interlock is open; raises `InstrumentError`."""
        self._exchange.open()
        try:
            identity = self._identify()
            self._command(":Interlock:Reset")
            self._refuse_interlock()
            position_deg = self._number(f":Read:Position? {self._axis}")
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
        """The controller's limits set and read back, the loop closed, rate 0; raises `InstrumentError`."""
        start_guard(self._guard, self._exchange.who)
        self._enabled = True
        axis = self._axis
        self._command(":Interlock:Reset")
        # Somebody else may have left it turning, and a drive that is switched off brakes nothing.
        self._command(f":Demand:Rate {axis},0")
        if not comes_to_rest(self._clock, self._motion, self._plain_rate_dps):
            raise InstrumentError(
                f"{self._exchange.who}: the table turns and does not come to rest; stop it at the controller's"
                " panel, and see who else is using it"
            )
        self._command(f":Mode:Off {axis}")
        for mode in ("Rate", "Position"):
            self._limit("Rate", mode, max_rate_dps(self._motion))
            self._limit("Acceleration", mode, max_acceleration_dps2(self._motion))
        self._command(f":Interlock:Close {axis}")
        self._refuse_interlock()
        self._demand("Rate", 0.0)
        self._refuse_interlock()

    def set_rate(self, rate_dps: float) -> None:
        """Ask for a rate; raises `InstrumentError`, before anything is sent, beyond what is allowed."""
        self._envelope.refuse_rate(self._clock.now_s(), rate_dps)
        self._refuse_interlock()
        self._demand("Rate", rate_dps)
        self._envelope.demanded(self._clock.now_s(), rate_dps)

    def rate_dps(self) -> float:
        """The rate that the controller reads back, °/s; raises `InstrumentError`, also of an interlock."""
        self._refuse_interlock()
        rate_dps = self._number(f":Read:Rate? {self._axis}")
        self.position_deg()
        return rate_dps

    def position_deg(self) -> float:
        """The angle that the controller reads back, with the turns counted, °.

        Raises `InstrumentError`, also when the cables are wound up; the table is stopped then.
        """
        position_deg = self._number(f":Read:Position? {self._axis}")
        try:
            return self._envelope.read(self._clock.now_s(), position_deg)
        except InstrumentError:
            self.stop()
            raise

    def move_to(self, position_deg: float) -> None:
        """Ask for an angle, by the shorter way; raises `InstrumentError`, before anything is sent, too."""
        self._envelope.refuse_move(self._clock.now_s(), position_deg)
        self._refuse_interlock()
        self._demand("Position", position_deg)
        self._envelope.moved(self._clock.now_s(), position_deg)

    def stop(self) -> None:
        """Rate 0 from whatever it does; never raises."""
        if self._enabled:
            stop_surely(self._exchange, self._send_stop, self._guard)
        elif self._exchange.is_open:
            # A drive that is off stays off.
            with contextlib.suppress(InstrumentError):
                self._command(self._stopping()[0])
        if self._envelope.begun:
            self._envelope.demanded(self._clock.now_s(), 0.0)

    def close(self) -> None:
        """At rest, drive off, interlock open, disconnected; idempotent, never raises."""
        at_rest = not self._enabled or self._switched_off()
        self._exchange.close()
        dismiss(self._guard, at_rest=at_rest)

    def _switched_off(self) -> bool:
        """Stop, and switch off; whether the table was seen at rest."""
        self.stop()
        at_rest = seen_at_rest(self._clock, self._motion, self._plain_rate_dps)
        for command in (f":Mode:Off {self._axis}", f":Interlock:Open {self._axis}"):
            with contextlib.suppress(InstrumentError):
                self._command(command)
        self._enabled = False
        return at_rest

    def _demand(self, mode: str, value: float) -> None:
        for command in self._demanding(mode, value):
            self._command(command)

    def _demanding(self, mode: str, value: float) -> tuple[str, ...]:
        """A demand of before comes to life with the mode, so that the new one goes in front, and again behind."""
        demand = f":Demand:{mode} {self._axis},{_text(value)}"
        return (demand, f":Mode:{mode} {self._axis}", demand)

    def _send_stop(self) -> None:
        for command in self._stopping():
            try:
                self._command(command)
            except InstrumentProtocolError:
                self._exchange.insist(command, self._end)

    def _stopping(self) -> tuple[str, ...]:
        return self._demanding("Rate", 0.0)

    def _identify(self) -> Identity:
        reply = self._ask("*IDN?")
        identity = parse_identity(reply)
        if identity is None:
            # An interface that knows no *IDN? is recognised by its answer to what follows.
            self._exchange.name("ACUTROL3000")
            return Identity(
                manufacturer="Acutronic",
                model="ACUTROL3000",
                serial_number=self._serial_number or "not stated",
            )
        check_identity(
            identity, who=self._exchange.who, expected=_EXPECTED, serial_number=self._serial_number
        )
        self._exchange.name(identity.model)
        self._envelope.who = self._exchange.who
        return identity

    def _refuse_interlock(self) -> None:
        state = self._ask(f":Interlock? {self._axis}")
        if state.casefold() == "fault":
            raise InstrumentError(
                f"{self._exchange.who}: the controller reports an interlock fault of axis {self._axis}"
                " (':Interlock?' gives 'Fault') and has stopped the table; close its doors, release the emergency"
                " stop, look at the controller's panel for the cause, and start the run again"
            )
        self._refuse_refusal(f":Interlock? {self._axis}", state)

    def _limit(self, of: str, mode: str, limit: float) -> None:
        self._command(f":Limit:{of} {mode},{self._axis},{_text(limit)}")
        if self._answers:
            return
        query = f":Limit:{of}? {mode},{self._axis}"
        found = self._number(query)
        if abs(found - limit) > _SETTING_TOLERANCE * limit:
            raise InstrumentProtocolError(
                f"{self._exchange.who}: {query} gives {found:g} after {limit:g} was set; is the station's motion"
                " within what the controller's own absolute limits allow?"
            )

    def _plain_rate_dps(self) -> float:
        return self._number(f":Read:Rate? {self._axis}")

    def _number(self, query: str) -> float:
        reply = self._ask(query)
        self._refuse_refusal(query, reply)
        try:
            return float(reply)
        except ValueError:
            raise InstrumentProtocolError(
                f"{self._exchange.who}: {query} gives {shown(reply.encode())}, expected a number; are dialect and"
                " prefix_bytes set as the controller's interface is?"
            ) from None

    def _refuse_refusal(self, asked: str, reply: str) -> None:
        if reply.startswith("?"):
            raise InstrumentProtocolError(
                f"{self._exchange.who}: the controller answers {shown(reply.encode())} to {asked}: refused; is"
                f" axis {self._axis} there and set up, and is the controller in remote?"
            )

    def _ask(self, query: str) -> str:
        if self._answers:
            sent = query.replace("?", "", 1) if query.startswith(":Read") else query
            reply = self._exchange.packet(
                sent, self._end, least=(self._prefix_bytes or 0) + 1, whole=_TAKEN
            )
        else:
            reply = self._exchange.until(query, self._end, reply_end=b"\n")
        return reply[self._prefix_bytes :].decode("ascii", "replace").strip()

    def _command(self, command: str) -> None:
        """Send a command and see that it was taken, which also waits until it was; raises `InstrumentError`."""
        if self._answers:
            reply = self._ask(command)
            if reply != _TAKEN.decode():
                self._refuse_refusal(command, reply)
                raise InstrumentProtocolError(
                    f"{self._exchange.who}: {command} is answered with {shown(reply.encode())}, expected OK; are"
                    " dialect and prefix_bytes set as the controller's interface is?"
                )
            return
        self._exchange.send(command, self._end)
        status = self._number("*STB?")
        if int(status) & _SUMMARY:
            self._refuse_interlock()
            raise InstrumentProtocolError(
                f"{self._exchange.who}: the status byte is {status:g} after {command}: refused; look at the"
                " controller's panel for the reason; is the value within its absolute limits?"
            )


def _text(value: float) -> str:
    return f"{value + 0.0:.6f}"
