"""A power supply of any maker that speaks SCPI: VOLT, CURR, VOLT:PROT, OUTP, MEAS; one of its outputs."""

import contextlib
import math
import re
from dataclasses import dataclass
from enum import StrEnum
from typing import Annotated, ClassVar

from gyrotest.errors import (
    InstrumentError,
    InstrumentIdentityError,
    InstrumentProtocolError,
    InstrumentTimeoutError,
)
from gyrotest.instruments import scpi
from gyrotest.instruments.identity import Expected
from gyrotest.instruments.session import Session
from gyrotest.instruments.transport.channel import Connect
from gyrotest.instruments.transport.conversation import shown
from gyrotest.instruments.transport.serial_settings import SerialSettings
from gyrotest.instruments.transport.visa import open_channel
from gyrotest.ports import Clock
from gyrotest.records.bench import Supplied
from gyrotest.records.described import Described
from gyrotest.records.recording import Identity

# A supply rounds a setting to its own steps: so far may what it reads back lie from what was asked for.
_STEP_RATIO = 2e-3
_STEP_V = 0.01
_STEP_A = 0.01
# Held by the limit: the measured current is the limit, but for the read-back's own error.
_AT_LIMIT = 0.985

# Some say it in words.
_WORDS = {"ON": True, "YES": True, "OFF": False, "NO": False}

_ANYBODY = Expected(manufacturer=re.compile(""), model=re.compile(".*"), spoken="a SCPI power supply")


class Select(StrEnum):
    """How a command says for which output it is."""

    NSEL = "nsel"
    CHANNEL_LIST = "channel_list"


@dataclass(frozen=True, slots=True, kw_only=True)
class ScpiSupplySettings(SerialSettings):
    """The station's settings of a power supply; the serial ones count on RS-232 only."""

    outputs: Annotated[int, Described("How many outputs the supply has.", "3")] = 1
    select: Annotated[
        Select,
        Described(
            "How an output of several is named: `nsel` sends INST:NSEL before each command,"
            " `channel_list` adds (@n) to it."
        ),
    ] = Select.NSEL
    identity: Annotated[
        str,
        Described(
            "A regular expression that is found in maker and model; another supply is refused.",
            "KEYSIGHT.*E36312A",
        ),
    ] = ""
    protection_on: Annotated[
        str,
        Described(
            "The command that arms the over-voltage protection, where setting it does not.",
            "VOLT:PROT:STAT ON",
        ),
    ] = ""
    trip_query: Annotated[
        str,
        Described(
            "The query that tells whether the over-voltage protection has tripped, {output} in it being the"
            " output's number; '' if there is none: an output that has gone off by itself has tripped.",
            "VOLT:PROT:TRIP?",
        ),
    ] = "VOLT:PROT:TRIP?"
    trip_mask: Annotated[int, Described("The bits of the answer that say so.", "1")] = 1
    limit_query: Annotated[
        str,
        Described(
            "The query that tells whether the current limit holds the output; without it, a current at the"
            " limit says so.",
            "STAT:QUES:INST:ISUM{output}:COND?",
        ),
    ] = ""
    limit_mask: Annotated[int, Described("The bits of the answer that say so.", "1")] = 1

    def __post_init__(self) -> None:
        if self.outputs < 1:
            raise ValueError(f"outputs {self.outputs} is less than one")
        _ = self.pattern  # checks it
        for query in (self.trip_query, self.limit_query):
            if query and "?" not in query:
                raise ValueError(f"'{query}' is no query; write e.g. STAT:QUES:COND?")
        if self.trip_mask <= 0 or self.limit_mask <= 0:
            raise ValueError("a mask without a bit; write e.g. 1 for the lowest")
        _ = self.line  # checks the serial settings

    @property
    def pattern(self) -> re.Pattern[str]:
        """The identity's pattern; raises `ValueError`."""
        try:
            return re.compile(self.identity, re.IGNORECASE)
        except re.error as error:
            raise ValueError(f"identity '{self.identity}' is no regular expression: {error}") from None


class ScpiSupply:
    """One output of a supply. The instrument is never reset: other outputs may feed other units."""

    settings: ClassVar[type] = ScpiSupplySettings

    def __init__(
        self,
        resource: str,
        settings: ScpiSupplySettings,
        *,
        clock: Clock,  # noqa: ARG002 - part of how every supply is made; nothing is timed here
        output: int = 1,
        io_timeout_s: float | None = None,
        serial_number: str | None = None,
        connect: Connect = open_channel,
    ) -> None:
        self._settings = settings
        self._output = output
        self._resource = resource
        self._session = Session(
            resource,
            _ANYBODY,
            line=settings.line,
            serial_number=serial_number,
            io_timeout_s=io_timeout_s,
            reset="*CLS",
            connect=connect,
        )
        self._opened = False
        self._switched_on = False
        self._limit_a = math.inf

    def open(self) -> Identity:
        """Connect and ask who is there; an output that is on stays as it is. Raises `InstrumentError`."""
        if not 1 <= self._output <= self._settings.outputs:
            raise InstrumentError(
                f"{self._resource}: output {self._output} is asked for, the supply has"
                f" {self._settings.outputs}; correct the slot's supply_output or the setting outputs"
            )
        identity = self._session.open()
        named = f"{identity.manufacturer} {identity.model}"
        if not self._settings.pattern.search(named):
            self._session.disconnect()
            raise InstrumentIdentityError(
                f"{self._resource}: found {named} (serial number {identity.serial_number}), expected"
                f" '{self._settings.identity}'; correct the station's resource or the setting identity"
            )
        self._opened = True
        return identity

    def set(self, *, voltage_v: float, current_limit_a: float, over_voltage_v: float) -> None:
        """Protection first, then current limit and voltage, all read back; raises `InstrumentError`."""
        self._refuse_senseless(voltage_v, current_limit_a, over_voltage_v)
        if self._number("VOLT") > over_voltage_v:
            # Many refuse a protection below the voltage that is set; this only lowers it.
            self._command("VOLT", voltage_v)
        self._command("VOLT:PROT", over_voltage_v)
        if self._settings.protection_on:
            self._write(self._settings.protection_on)
        self._command("CURR", current_limit_a)
        self._command("VOLT", voltage_v)
        try:
            self._refuse_errors()
        except InstrumentProtocolError as error:
            raise InstrumentProtocolError(
                f"{error} Asked for: {voltage_v:g} V, at most {current_limit_a:g} A, protection at"
                f" {over_voltage_v:g} V; is that within what this output can do?"
            ) from error
        self._read_back("VOLT:PROT", over_voltage_v, step=_STEP_V, unit="V")
        self._read_back("CURR", current_limit_a, step=_STEP_A, unit="A")
        self._read_back("VOLT", voltage_v, step=_STEP_V, unit="V")
        self._limit_a = current_limit_a

    def on(self) -> None:
        """Switch the output on and return at once; raises `InstrumentError`."""
        self._switched_on = True
        self._write("OUTP ON")
        self._refuse_errors()

    def off(self) -> None:
        """Switch the output off, and see that it is; nothing where the supply is not open."""
        if not self._opened:
            return
        self._switched_on = False
        self._write("OUTP OFF")
        if self._flag("OUTP?"):
            raise InstrumentProtocolError(
                f"{self._who}: still on after OUTP OFF; switch it off at its front panel"
            )

    def measure(self) -> Supplied:
        """What the output gives; raises `InstrumentError`."""
        voltage_v = self._number("MEAS:VOLT")
        current_a = self._number("MEAS:CURR")
        return Supplied(
            voltage_v=voltage_v,
            current_a=current_a,
            limiting=self._limiting(current_a),
            tripped=self._tripped(),
        )

    def close(self) -> None:
        """Switch the output off, over a new connection where the old one is lost; never raises."""
        if self._opened:
            try:
                self.off()
            except InstrumentError:
                with contextlib.suppress(InstrumentError):
                    self._session.bring_back()
                    self.off()
        self._opened = False
        self._session.leave()

    def query(self, command: str) -> str:
        """Ask the supply anything of this output; raises `InstrumentError`."""
        self._choose()
        return self._session.talk.query(command, self._session.timeout_s)

    @property
    def _who(self) -> str:
        return f"{self._session.talk.who} output {self._output}"

    def _limiting(self, current_a: float) -> bool:
        if self._settings.limit_query:
            return self._flag(self._settings.limit_query, self._settings.limit_mask)
        return current_a >= _AT_LIMIT * self._limit_a

    def _tripped(self) -> bool:
        if not self._settings.trip_query:
            return self._switched_on and not self._flag("OUTP?")
        try:
            return self._flag(self._settings.trip_query, self._settings.trip_mask)
        except InstrumentTimeoutError as error:
            raise InstrumentTimeoutError(
                f"{error}; where this supply does not know '{self._settings.trip_query}', write the query"
                " that it knows into the setting trip_query, or ''"
            ) from error

    def _flag(self, given: str, mask: int = 1) -> bool:
        """Ask for a yes or no: a word, or a number of which these bits count."""
        query = given.replace("{output}", str(self._output))
        if query == given:
            query = self._addressed(query)
        self._choose()
        talk = self._session.talk
        reply = talk.query(query, self._session.timeout_s).strip('"').upper()
        if reply in _WORDS:
            return _WORDS[reply]
        try:
            return bool(int(float(reply)) & mask)
        except (ValueError, OverflowError):
            raise InstrumentProtocolError(
                f"{self._who}: {query} gives {shown(reply.encode())}, expected 0 or 1, or OFF or ON"
            ) from None

    def _choose(self) -> None:
        """Name the output anew each time: another program, or the other slot's driver, may have named one."""
        if self._settings.outputs > 1 and self._settings.select is Select.NSEL:
            self._session.talk.write(f"INST:NSEL {self._output}")

    def _addressed(self, command: str) -> str:
        if self._settings.outputs == 1 or self._settings.select is Select.NSEL:
            return command
        # Parameters are separated by commas, the first one by a blank.
        return f"{command}{',' if ' ' in command else ' '}(@{self._output})"

    def _write(self, command: str) -> None:
        self._choose()
        self._session.talk.write(self._addressed(command))

    def _command(self, header: str, value: float) -> None:
        self._write(f"{header} {value:.6g}")

    def _number(self, header: str) -> float:
        self._choose()
        query = self._addressed(f"{header}?")
        return scpi.number(self._session.talk, query, self._session.timeout_s)

    def _refuse_errors(self) -> None:
        scpi.refuse_errors(self._session.talk, self._session.timeout_s)

    def _read_back(self, header: str, wanted: float, *, step: float, unit: str) -> None:
        found = self._number(header)
        if abs(found - wanted) > _STEP_RATIO * wanted + step:
            raise InstrumentProtocolError(
                f"{self._who}: {header}? gives {found:g} {unit}, expected {wanted:g} {unit}; is it within"
                " what this supply can do?"
            )

    def _refuse_senseless(self, voltage_v: float, current_limit_a: float, over_voltage_v: float) -> None:
        if not 0.0 < voltage_v < over_voltage_v or current_limit_a <= 0.0:
            raise InstrumentError(
                f"{self._who}: {voltage_v:g} V, at most {current_limit_a:g} A, protection at"
                f" {over_voltage_v:g} V make no sense; the protection lies above the voltage, both above zero"
            )
