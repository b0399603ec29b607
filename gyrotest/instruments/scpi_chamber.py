"""A temperature chamber that takes lines of text; its commands stand in the station."""

import contextlib
import re
from dataclasses import dataclass
from typing import Annotated, ClassVar

from gyrotest.errors import InstrumentError, InstrumentIdentityError, InstrumentProtocolError
from gyrotest.instruments import scpi
from gyrotest.instruments.identity import parse_identity
from gyrotest.instruments.transport.channel import Connect
from gyrotest.instruments.transport.conversation import Conversation, shown
from gyrotest.instruments.transport.serial_settings import SerialSettings
from gyrotest.instruments.transport.visa import open_channel
from gyrotest.ports import Clock
from gyrotest.records.described import Described
from gyrotest.records.recording import Identity
from gyrotest.units import Dimension, OfDimension, Quantity

_REPLY_TIMEOUT_S = 5.0
_NUMBER = r"[-+]?\d+(?:\.\d*)?(?:[eE][-+]?\d+)?"
# A chamber shows and takes its setting in tenths or coarser.
_STEP_C = 0.11
_COLDEST = Quantity(-70.0, "degC")
_HOTTEST = Quantity(180.0, "degC")


@dataclass(frozen=True, slots=True, kw_only=True)
class ScpiChamberSettings(SerialSettings):
    """The station's settings of a chamber: what is said to it; the serial ones count on RS-232 only."""

    set: Annotated[
        str, Described("The command that sets the temperature, {value} in °C.", "SOUR:TEMP {value:.2f}")
    ] = "SOUR:TEMP {value:.2f}"
    ask: Annotated[str, Described("The query of the temperature, °C.", "MEAS:TEMP?")] = "MEAS:TEMP?"
    ask_set: Annotated[
        str,
        Described(
            "The query of the temperature that is set, °C; it is read back where one is given.",
            "SOUR:TEMP?",
        ),
    ] = ""
    start: Annotated[str, Described("The command that starts it; '' if it has none.", "OUTP ON")] = (
        "OUTP ON"
    )
    stop: Annotated[
        str,
        Described(
            "The command that stops heating and cooling, sent at the end; '' if it has none.", "OUTP OFF"
        ),
    ] = "OUTP OFF"
    at_rest: Annotated[
        Quantity | None,
        OfDimension(Dimension.TEMPERATURE),
        Described("The temperature that is set at the end, where no command stops it.", "23 degC"),
    ] = None
    acknowledges: Annotated[
        bool, Described("Whether it answers commands too, with a line that is read and dropped.", "true")
    ] = False
    reading: Annotated[
        str,
        Described(
            "A regular expression for the number in its answers; a group in it is the number.",
            "'^([-+.0-9]+)'",
        ),
    ] = _NUMBER
    identify: Annotated[
        str, Described("The query of its identity (four fields); '' if it has none.", "'*IDN?'")
    ] = "*IDN?"
    identity: Annotated[
        str,
        Described(
            "A regular expression that is found in maker and model; another is refused.", "ESPEC.*SU-2"
        ),
    ] = ""
    errors: Annotated[bool, Described("Whether SYST:ERR? is asked after each command.", "true")] = False
    coldest: Annotated[
        Quantity,
        OfDimension(Dimension.TEMPERATURE),
        Described("What is never gone below, for the chamber's or the unit's sake.", "-40 degC"),
    ] = _COLDEST
    hottest: Annotated[
        Quantity,
        OfDimension(Dimension.TEMPERATURE),
        Described("What is never gone above.", "85 degC"),
    ] = _HOTTEST

    def __post_init__(self) -> None:
        if self.command(12.3) == self.command(45.6):
            raise ValueError(f"set '{self.set}' has no {{value}}; write e.g. SOUR:TEMP {{value:.2f}}")
        for key in ("reading", "identity"):
            _check_pattern(key, getattr(self, key))
        if not self.stop and self.at_rest is None:
            raise ValueError(
                "neither 'stop' nor 'at_rest' says how the chamber is left; write e.g. stop: OUTP OFF"
            )
        if not self.coldest.to("degC") < self.hottest.to("degC"):
            raise ValueError(f"coldest {self.coldest} is not below hottest {self.hottest}")
        _ = self.line  # checks the serial settings

    def command(self, temperature_degc: float) -> str:
        """The command that sets a temperature; raises `ValueError`."""
        try:
            return self.set.format(value=temperature_degc)
        except (KeyError, IndexError, ValueError, AttributeError) as error:
            raise ValueError(
                f"set '{self.set}' cannot be filled in ({error}); write e.g. SOUR:TEMP {{value:.2f}}"
            ) from None


def _check_pattern(key: str, pattern: str) -> None:
    try:
        re.compile(pattern)
    except re.error as error:
        raise ValueError(f"{key} '{pattern}' is no regular expression: {error}") from None


class ScpiChamber:
    """A chamber that is told a temperature and asked for the one it has."""

    settings: ClassVar[type] = ScpiChamberSettings

    def __init__(
        self,
        resource: str,
        settings: ScpiChamberSettings,
        *,
        clock: Clock,  # noqa: ARG002 - part of how every chamber is made; nothing is timed here
        io_timeout_s: float | None = None,
        serial_number: str | None = None,
        connect: Connect = open_channel,
    ) -> None:
        self._resource = resource
        self._settings = settings
        self._serial_number = serial_number
        self._timeout_s = _REPLY_TIMEOUT_S if io_timeout_s is None else io_timeout_s
        self._connect = connect
        self._open: Conversation | None = None
        self._running = False

    def open(self) -> Identity:
        """Connect and ask who is there; nothing is changed. Raises `InstrumentError`."""
        channel = self._connect(self._resource, self._settings.line, self._timeout_s)
        self._open = Conversation(self._resource, channel)
        try:
            identity = self._identity(self._open)
            self._refuse_another(identity)
        except InstrumentError:
            self._disconnect()
            raise
        self._open.name(identity.model)
        return identity

    def set_temperature(self, temperature_degc: float) -> None:
        """Ask for a temperature, start, and return at once; raises `InstrumentError`."""
        self._refuse_beyond(temperature_degc)
        self._running = True
        self._command(self._settings.command(temperature_degc))
        if self._settings.start:
            self._command(self._settings.start)
        if self._settings.ask_set:
            found_degc = self._number(self._settings.ask_set)
            if abs(found_degc - temperature_degc) > _STEP_C:
                raise InstrumentProtocolError(
                    f"{self._talk.who}: {self._settings.ask_set} gives {found_degc:g} °C, expected"
                    f" {temperature_degc:g} °C; is it within what this chamber can do?"
                )

    def temperature_degc(self) -> float:
        """The temperature that it reads back, °C; raises `InstrumentError`."""
        return self._number(self._settings.ask)

    def close(self) -> None:
        """Leave it at rest, if it was set running here, and disconnect; never raises."""
        if self._open is None:
            return
        if self._running:
            with contextlib.suppress(InstrumentError):
                self._rest()
            self._running = False
        self._disconnect()

    @property
    def _talk(self) -> Conversation:
        if self._open is None:
            raise InstrumentError(f"{self._resource}: not open; open the chamber first")
        return self._open

    def _rest(self) -> None:
        if self._settings.stop:
            self._command(self._settings.stop)
        elif self._settings.at_rest is not None:
            self._command(self._settings.command(self._settings.at_rest.to("degC")))
        # A line is not closed under a command that was not yet taken.
        self._number(self._settings.ask)

    def _command(self, command: str) -> None:
        if self._settings.acknowledges:
            self._talk.query(command, self._timeout_s)
        else:
            self._talk.write(command)
        if self._settings.errors:
            scpi.refuse_errors(self._talk, self._timeout_s)

    def _number(self, query: str) -> float:
        reply = self._talk.query(query, self._timeout_s)
        found = re.search(self._settings.reading, reply)
        try:
            return float(found[1 if found.re.groups else 0] if found else "")
        except ValueError:
            raise InstrumentProtocolError(
                f"{self._talk.who}: {query} gives {shown(reply.encode())}, expected a temperature in °C;"
                " correct the settings ask and reading"
            ) from None

    def _identity(self, talk: Conversation) -> Identity:
        if not self._settings.identify:
            return Identity(
                manufacturer="not stated",
                model="temperature chamber",
                serial_number=self._serial_number or "not stated",
            )
        reply = talk.query(self._settings.identify, self._timeout_s)
        identity = parse_identity(reply)
        if identity is None:
            raise InstrumentProtocolError(
                f"{self._resource}: {self._settings.identify} gives {shown(reply.encode())}, expected the four"
                " fields of an identity; where it has none, write identify: ''"
            )
        return identity

    def _refuse_another(self, identity: Identity) -> None:
        named = f"{identity.manufacturer} {identity.model}"
        if not re.search(self._settings.identity, named, re.IGNORECASE):
            raise InstrumentIdentityError(
                f"{self._resource}: found {named} (serial number {identity.serial_number}), expected"
                f" '{self._settings.identity}'; correct the station's resource or the setting identity"
            )
        if self._serial_number is not None and identity.serial_number != self._serial_number:
            raise InstrumentIdentityError(
                f"{self._resource}: found {named} with serial number {identity.serial_number}, expected"
                f" {self._serial_number}; correct the station's serial_number or connect that chamber"
            )

    def _refuse_beyond(self, temperature_degc: float) -> None:
        coldest, hottest = self._settings.coldest, self._settings.hottest
        if not coldest.to("degC") <= temperature_degc <= hottest.to("degC"):
            raise InstrumentError(
                f"{self._talk.who}: {temperature_degc:g} °C is asked for, the station allows {coldest} to"
                f" {hottest}; correct the case's temperatures or the settings coldest and hottest"
            )

    def _disconnect(self) -> None:
        if self._open is not None:
            self._open.close()
            self._open = None
