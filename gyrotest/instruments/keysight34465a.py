"""Keysight 34465A and its family, DC volts; the meter's own sample timer paces it, memory read in blocks."""

import math
import re
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from gyrotest.errors import InstrumentError, InstrumentProtocolError, InstrumentTimeoutError
from gyrotest.instruments import scpi
from gyrotest.instruments.identity import Expected
from gyrotest.instruments.pacing import Grid
from gyrotest.instruments.scpi import Setting
from gyrotest.instruments.session import Session
from gyrotest.instruments.transport.channel import Connect
from gyrotest.instruments.transport.visa import open_channel
from gyrotest.instruments.voltage import (
    MeterSettings,
    check_nplc,
    check_range,
    noise_of_mean,
    on_off,
    power_line_cycle_s,
    too_short,
)
from gyrotest.ports import Clock
from gyrotest.records.recording import Block, Identity, Sampling
from gyrotest.records.station import Accuracy

_NPLC = (0.02, 0.06, 0.2, 1.0, 10.0, 100.0)
_SHORTEST_READING_S = 1e-3
# Steps of the sample timer: 20 µs with the 34410A, of which the 1 µs of the others are a part.
_TIMER_STEP_S = 20e-6
_WORTH = 0.8
_MEMORY_OVERFLOW = 1 << 14
_POLL_S = 5.0
_GRACE_S = 2.0
_CLOCK_TOLERANCE = 1e-3

_EXPECTED = Expected(
    manufacturer=re.compile("AGILENT|KEYSIGHT", re.IGNORECASE),
    model=re.compile("34410A|34411A|34465A|34470A", re.IGNORECASE),
    spoken="a Keysight 34465A, 34470A, 34410A or 34411A",
)


@dataclass(frozen=True, slots=True, kw_only=True)
class Keysight34465ASettings(MeterSettings):
    """The station's settings of a 34465A."""

    def __post_init__(self) -> None:
        check_range(self.range)
        check_nplc(self.nplc, _NPLC, "34465A")


class Keysight34465A:
    """The meter takes every reading by its own timer; `fetch` empties its memory every few seconds."""

    settings: ClassVar[type] = Keysight34465ASettings

    def __init__(
        self,
        resource: str,
        settings: Keysight34465ASettings,
        *,
        clock: Clock,
        line_frequency_hz: float | None = None,
        accuracy: Accuracy | None = None,
        io_timeout_s: float | None = None,
        serial_number: str | None = None,
        connect: Connect = open_channel,
    ) -> None:
        self._settings = settings
        self._clock = clock
        self._line_frequency_hz = line_frequency_hz
        self._accuracy = accuracy
        self._session = Session(
            resource, _EXPECTED, serial_number=serial_number, io_timeout_s=io_timeout_s, connect=connect
        )
        self._grid: Grid | None = None
        self._interval_s = 0.0
        self._count = 1
        self._timer_s = 0.0
        self._first = 0
        self._position = 0
        self._end = 0
        self._init_s = 0.0
        self._polled_s = 0.0
        self._rest: NDArray[np.float64] = np.empty(0)

    def open(self) -> Identity:
        """Connect and ask who is there; raises `InstrumentError`."""
        return self._session.open()

    def configure(self, interval_s: float) -> Sampling:
        """Set the meter's timer so that as many readings as fit are averaged; raises `InstrumentError`."""
        self._interval_s = interval_s
        self._apply()
        sampled_s = self._count * self._timer_s
        self._grid = Grid(self._clock, sampled_s)
        return Sampling(
            interval_s=interval_s if math.isclose(sampled_s, interval_s, rel_tol=1e-9) else sampled_s,
            aperture_s=self._aperture_s(),
            readings=self._count,
            noise=noise_of_mean(self._accuracy, self._count),
            range=self._settings.range.to("V"),
        )

    def start(self, first: int, count: int) -> None:
        """Begin: samples `first` … `count - 1`; the grid lies from the first start on."""
        grid = self._laid_grid()
        talk, wanted = self._session.talk, (count - first) * self._count
        self._refuse_too_many(wanted)
        scpi.apply(
            talk, (Setting(f"SAMP:COUN {wanted}", "SAMP:COUN?", float(wanted)),), self._session.timeout_s
        )
        grid.begin(first)
        self._clock.sleep_until(grid.deadline_s(first))
        self._init_s = self._polled_s = self._clock.now_s()
        scpi.initiate(talk, self._session.timeout_s)
        self._first = self._position = first
        self._end = count
        self._rest = np.empty(0)

    def fetch(self) -> Block | None:
        """Wait for the next whole samples, a few seconds of them; None after the last."""
        if self._position >= self._end:
            self._finish()
            return None
        while True:
            self._clock.sleep_until(self._next_poll_s())
            self._poll()
            if len(self._rest) >= self._count:
                return self._block()
            self._refuse_silence()

    def recover(self) -> int:
        """Clear or reconnect, the same meter, settings again; returns the next position on the grid."""
        self._session.bring_back()
        self._apply()
        return self._laid_grid().position_to_go_on()

    def query(self, command: str) -> str:
        """Ask the meter anything, outside of an acquisition; raises `InstrumentError`."""
        return self._session.talk.query(command, self._session.timeout_s)

    def close(self) -> None:
        """Stopped, display on, disconnected; never raises."""
        self._session.leave("ABOR", "DISP ON")

    def _next_poll_s(self) -> float:
        """Every few seconds, but not before a sample is whole, nor later than the last one is."""
        last_s = self._ready_s(self._end - 1)
        due_s = max(self._ready_s(self._position), min(self._polled_s + _POLL_S, last_s))
        # A meter whose clock runs slow is asked again a moment later.
        return max(due_s, self._polled_s + min(self._timer_s, 1.0))

    def _ready_s(self, position: int) -> float:
        return self._init_s + (position + 1 - self._first) * self._count * self._timer_s

    def _poll(self) -> None:
        """Take what the memory holds. A memory that has overflowed has lost readings, nobody knows which."""
        talk, timeout_s = self._session.talk, self._session.timeout_s
        content = talk.query_block("R?", timeout_s)
        self._polled_s = self._clock.now_s()
        if int(scpi.number(talk, "STAT:QUES?", timeout_s)) & _MEMORY_OVERFLOW:
            raise InstrumentProtocolError(
                f"{talk.who}: its memory overflowed and readings are lost; was this computer asleep?"
            )
        if len(content) % 8:
            raise InstrumentProtocolError(
                f"{talk.who}: a block of {len(content)} bytes, expected a multiple of 8 (FORM:DATA REAL,64)"
            )
        self._rest = np.concatenate((self._rest, np.frombuffer(content, dtype=">f8")))
        most = (self._end - self._position) * self._count
        if len(self._rest) > most:
            raise InstrumentProtocolError(
                f"{talk.who}: {len(self._rest)} readings, expected at most {most}"
            )

    def _refuse_silence(self) -> None:
        now_s = self._clock.now_s()
        late_s = now_s - self._ready_s(self._position)
        if late_s > _GRACE_S + self._interval_s + _CLOCK_TOLERANCE * (now_s - self._init_s):
            raise InstrumentTimeoutError(
                f"{self._session.talk.who}: {len(self._rest)} readings in its memory, expected {self._count}"
                f" since {late_s:.3g} s; is its trigger source IMM and its sample source TIM?"
            )

    def _block(self) -> Block:
        whole = len(self._rest) // self._count
        taken = whole * self._count
        values, flags = scpi.samples_of(self._rest[:taken], self._count)
        self._rest = self._rest[taken:]
        first, self._position = self._position, self._position + whole
        since_init_s = (np.arange(first, first + whole) - self._first) * (self._count * self._timer_s)
        start_s = self._init_s - self._laid_grid().deadline_s(0)
        time_s = (start_s + since_init_s).astype(np.float64)
        return Block(first=first, time_s=time_s, values=values, flags=flags)

    def _finish(self) -> None:
        talk, timeout_s = self._session.talk, self._session.timeout_s
        left = scpi.number(talk, "DATA:POIN?", timeout_s)
        if left:
            raise InstrumentProtocolError(
                f"{talk.who}: {left:g} readings more than were asked for; did somebody else start it?"
            )
        scpi.refuse_errors(talk, timeout_s)

    def _aperture_s(self) -> float:
        return self._settings.nplc * power_line_cycle_s(self._line_frequency_hz, self._session.talk.who)

    def _apply(self) -> None:
        """Settings first: the shortest interval depends on them; then the timer."""
        aperture_s = self._aperture_s()
        talk, timeout_s = self._session.talk, self._session.timeout_s
        scpi.apply(talk, self._measurement(), timeout_s)
        reading_s = max(aperture_s, _SHORTEST_READING_S) * (2 if self._settings.autozero else 1)
        # A shorter interval is not refused by the meter, but not kept either.
        shortest_s = max(scpi.number(talk, "SAMP:TIM? MIN", timeout_s), reading_s)
        self._count = readings_that_fit(self._interval_s, shortest_s)
        if not self._count:
            zeroed = " and autozero" if self._settings.autozero else ""
            raise too_short(
                talk.who,
                self._interval_s,
                reading=f"nplc {self._settings.nplc:g}{zeroed}",
                shortest_s=shortest_s,
            )
        wanted_s = self._interval_s / self._count
        scpi.apply(talk, _timing(wanted_s), timeout_s)
        self._timer_s = scpi.number(talk, "SAMP:TIM?", timeout_s)
        if abs(self._timer_s - wanted_s) > _TIMER_STEP_S:
            raise InstrumentProtocolError(
                f"{talk.who}: SAMP:TIM? gives {self._timer_s:g} s, expected {wanted_s:g} s;"
                " is the setting within what this model can do?"
            )

    def _measurement(self) -> tuple[Setting, ...]:
        volts = self._settings.range.to("V")
        autozero, high = self._settings.autozero, self._settings.high_impedance
        return (
            Setting(f"CONF:VOLT:DC {volts:g}", "VOLT:DC:RANG?", volts),
            Setting(f"VOLT:DC:NPLC {self._settings.nplc:g}", "VOLT:DC:NPLC?", self._settings.nplc),
            Setting(f"VOLT:DC:ZERO:AUTO {on_off(on=autozero)}", "VOLT:DC:ZERO:AUTO?", float(autozero)),
            Setting(f"VOLT:DC:IMP:AUTO {on_off(on=high)}", "VOLT:DC:IMP:AUTO?", float(high)),
            Setting("TRIG:SOUR IMM", "TRIG:SOUR?", "IMM"),
            Setting("TRIG:COUN 1", "TRIG:COUN?", 1.0),
            Setting("TRIG:DEL 0", "TRIG:DEL?", 0.0),
            Setting("DISP OFF"),
        )

    def _refuse_too_many(self, wanted: int) -> None:
        talk = self._session.talk
        most = scpi.number(talk, "SAMP:COUN? MAX", self._session.timeout_s)
        if wanted > most:
            raise InstrumentError(
                f"{talk.who}: {wanted} readings in one run, at most {most:g} are possible;"
                f" shorten the duration to {most * self._timer_s:g} s or raise nplc"
            )

    def _laid_grid(self) -> Grid:
        if self._grid is None:
            raise InstrumentError(
                f"{self._session.talk.who}: not configured; configure an interval first"
            )
        return self._grid


def _timing(timer_s: float) -> tuple[Setting, ...]:
    return (
        Setting("SAMP:SOUR TIM", "SAMP:SOUR?", "TIM"),
        Setting(f"SAMP:TIM {timer_s:.6f}"),
        Setting("FORM:DATA REAL,64", "FORM:DATA?", "REAL,64"),
        Setting("FORM:BORD NORM", "FORM:BORD?", "NORM"),
    )


def readings_that_fit(interval_s: float, shortest_s: float) -> int:
    """How many readings fit; a few less where the interval is then a whole number of timer steps."""
    most = math.floor(interval_s / shortest_s + 1e-9)
    for count in range(most, math.floor(_WORTH * most), -1):
        steps = interval_s / count / _TIMER_STEP_S
        if abs(steps - round(steps)) < 1e-6:
            return count
    return most
