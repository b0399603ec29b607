"""Keysight 33500B and its family as the drive of a vibration table: noise, sines and sweeps over SCPI."""

import contextlib
import logging
import math
import re
from dataclasses import dataclass
from typing import ClassVar

from gyrotest.errors import InstrumentError, InstrumentProtocolError
from gyrotest.instruments import scpi
from gyrotest.instruments.identity import Expected
from gyrotest.instruments.keysight33500b_settings import Keysight33500BSettings
from gyrotest.instruments.scpi import Setting
from gyrotest.instruments.session import Session
from gyrotest.instruments.standstill import dismiss, guard_for, start_guard
from gyrotest.instruments.transport.channel import Connect
from gyrotest.instruments.transport.conversation import shown
from gyrotest.instruments.transport.visa import open_channel
from gyrotest.ports import Clock
from gyrotest.records.plan import Excitation, Vibrating
from gyrotest.records.recording import Identity

_EXPECTED = Expected(
    manufacturer=re.compile("AGILENT|KEYSIGHT", re.IGNORECASE),
    model=re.compile("335[0-2][0-9][AB]|336[12][0-9]A", re.IGNORECASE),
    spoken="a Keysight 33500 or 33600 series waveform generator",
)
# The generator rounds a root mean square to its own steps of peak to peak.
_LEVEL_RATIO = 5e-3

_logger = logging.getLogger(__name__)


@dataclass(frozen=True, slots=True, kw_only=True)
class _Order:
    """What the generator gives at present."""

    function: str
    level_v: float
    start_hz: float


class Keysight33500B:
    """One output. The generator is reset when it is opened, so that no modulation is left from before.

    While it drives, a guard process waits that switches it off when this process is killed.
    """

    settings: ClassVar[type] = Keysight33500BSettings

    def __init__(
        self,
        resource: str,
        settings: Keysight33500BSettings,
        *,
        clock: Clock,  # noqa: ARG002 - part of how every drive is made; nothing is timed here
        io_timeout_s: float | None = None,
        serial_number: str | None = None,
        connect: Connect = open_channel,
    ) -> None:
        self._settings = settings
        self._resource = resource
        self._out, self._source = f"OUTP{settings.output}", f"SOUR{settings.output}"
        self._session = Session(
            resource,
            _EXPECTED,
            line=settings.line,
            serial_number=serial_number,
            io_timeout_s=io_timeout_s,
            connect=connect,
        )
        self._guard = guard_for(resource, settings.line, (f"{self._out} OFF\n",), who=resource)
        self._guarded = False
        self._order: _Order | None = None

    def open(self) -> Identity:
        """Connect, ask who is there, reset, and see that the output is off; raises `InstrumentError`."""
        identity = self._session.open()
        if self._is_on():
            raise InstrumentError(
                f"{self._session.talk.who}: {self._out}? gives 1 after a reset, expected 0; is it set by hand, or"
                " by another program?"
            )
        return identity

    def random(self, *, rms_dps: float, low_hz: float, high_hz: float) -> None:
        """Give noise up to a frequency and return at once; raises `InstrumentError`.

        The generator's noise begins at 0 Hz: below `low_hz` the table itself is what does not move.
        """
        vibrating = Vibrating(
            excitation=Excitation.RANDOM, rms_dps=rms_dps, low_hz=low_hz, high_hz=high_hz
        )
        self._refuse(vibrating)
        self._begin(
            _Order(function="NOIS", level_v=self._settings.drive_v(vibrating), start_hz=0.0),
            _number(f"{self._source}:FUNC:NOIS:BAND", high_hz),
        )

    def sine(self, *, rms_dps: float, frequency_hz: float) -> None:
        """Give a sine and return at once; raises `InstrumentError`."""
        vibrating = Vibrating(
            excitation=Excitation.SINE, rms_dps=rms_dps, low_hz=frequency_hz, high_hz=frequency_hz
        )
        self._refuse(vibrating)
        self._begin(
            _Order(function="SIN", level_v=self._settings.drive_v(vibrating), start_hz=frequency_hz),
            _number(f"{self._source}:FREQ", frequency_hz),
        )

    def sweep(self, *, rms_dps: float, low_hz: float, high_hz: float, duration_s: float) -> None:
        """Begin a logarithmic sweep and return at once; raises `InstrumentError`.

        A sine of its first frequency that is there already goes on into it.
        """
        vibrating = Vibrating(
            excitation=Excitation.SWEEP, rms_dps=rms_dps, low_hz=low_hz, high_hz=high_hz
        )
        self._refuse(vibrating, duration_s=duration_s)
        order = _Order(function="SIN", level_v=self._settings.drive_v(vibrating), start_hz=low_hz)
        if order != self._order:
            self._begin(order, _number(f"{self._source}:FREQ", low_hz))
        self._apply(
            _number(f"{self._source}:FREQ:STAR", low_hz),
            _number(f"{self._source}:FREQ:STOP", high_hz),
            _word(f"{self._source}:SWE:SPAC", "LOG"),
            _number(f"{self._source}:SWE:TIME", duration_s),
            _word(f"TRIG{self._settings.output}:SOUR", "BUS"),
            _word(f"{self._source}:FREQ:MODE", "SWE"),
        )
        # Until here it gives the first frequency. No *OPC? after this: it would wait for the sweep's end.
        self._session.talk.write("*TRG")
        self._refuse_errors()

    def check(self) -> None:
        """See that the output is on and gives what it was asked for; raises `InstrumentError`."""
        talk, timeout_s = self._session.talk, self._session.timeout_s
        if self._order is None:
            raise InstrumentError(f"{talk.who}: nothing was asked of it since it was stopped")
        if not self._is_on():
            raise InstrumentError(
                f"{talk.who}: {self._out}? gives 0: the output has gone off by itself; look for a voltage that is"
                " fed back into it, a short, or a hand at its front panel"
            )
        function = talk.query(f"{self._source}:FUNC?", timeout_s).upper()
        if function != self._order.function:
            raise InstrumentProtocolError(
                f"{talk.who}: {self._source}:FUNC? gives {shown(function.encode())}, expected"
                f" {self._order.function}; was it set by hand, or by another program?"
            )
        self._read_level(self._order.level_v)

    def stop(self) -> None:
        """Output off, over a new connection or by the guard where this one is lost; never raises."""
        if not self._switched_off() and self._guard is not None and self._guarded:
            self._session.disconnect()
            self._guard.call()
            self._guarded = False

    def close(self) -> None:
        """Output off, disconnected; idempotent, never raises."""
        off = self._switched_off()
        self._session.leave()
        if self._guarded:
            dismiss(self._guard, at_rest=off)
            self._guarded = False

    def _begin(self, order: _Order, frequency: Setting) -> None:
        """Give something else: set up with the output off, then on."""
        load_ohm = self._settings.load_ohm
        self._order = None
        self._apply(
            _word(self._out, "OFF", read="0"),
            _word(f"{self._source}:FREQ:MODE", "CW"),
            # The load first: the generator reckons levels by it, and changes their unit with it.
            _word(f"{self._out}:LOAD", "INF", read=9.9e37)
            if math.isinf(load_ohm)
            else _number(f"{self._out}:LOAD", load_ohm),
            _word(f"{self._source}:FUNC", order.function),
            _word(f"{self._source}:VOLT:UNIT", "VRMS"),
            frequency,
            Setting(f"{self._source}:VOLT {_text(order.level_v)}"),
            _number(f"{self._source}:VOLT:OFFS", 0.0),
        )
        self._read_level(order.level_v)
        start_guard(self._guard, self._session.talk.who)
        self._guarded = True
        self._order = order
        self._apply(_word(self._out, "ON", read="1"))

    def _refuse(self, vibrating: Vibrating, *, duration_s: float = 0.0) -> None:
        refusal = self._settings.refusal(vibrating, sampled_s=duration_s)
        if refusal is not None:
            raise InstrumentError(f"{self._resource}: {refusal}; nothing was sent")

    def _switched_off(self) -> bool:
        """Whether the output is off now, as far as anything was ever asked of it. Never raises."""
        self._order = None
        if not self._guarded:
            return True
        for again in (False, True):
            with contextlib.suppress(InstrumentError):
                if again:
                    self._session.bring_back()
                if self._off():
                    return True
        _logger.warning(
            "%s: cannot be switched off, and may go on driving the vibration table; switch its output off at"
            " its front panel",
            self._resource,
        )
        return False

    def _off(self) -> bool:
        self._session.talk.write(f"{self._out} OFF")
        return not self._is_on()

    def _is_on(self) -> bool:
        return scpi.number(self._session.talk, f"{self._out}?", self._session.timeout_s) != 0.0

    def _apply(self, *settings: Setting) -> None:
        scpi.apply(self._session.talk, settings, self._session.timeout_s)

    def _refuse_errors(self) -> None:
        scpi.refuse_errors(self._session.talk, self._session.timeout_s)

    def _read_level(self, wanted_v: float) -> None:
        found_v = scpi.number(self._session.talk, f"{self._source}:VOLT?", self._session.timeout_s)
        if abs(found_v - wanted_v) > _LEVEL_RATIO * wanted_v:
            raise InstrumentProtocolError(
                f"{self._session.talk.who}: {self._source}:VOLT? gives {found_v:g} V rms, expected"
                f" {wanted_v:.4g} V; is the level within what it can do into this load?"
            )


def _number(header: str, value: float) -> Setting:
    text = _text(value)
    return Setting(f"{header} {text}", f"{header}?", float(text))


def _word(header: str, word: str, read: float | str | None = None) -> Setting:
    return Setting(f"{header} {word}", f"{header}?", word if read is None else read)


def _text(value: float) -> str:
    return f"{value:.6g}"
