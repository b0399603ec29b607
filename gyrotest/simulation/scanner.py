"""A simulated multimeter scanner: channels behind relays, sweeps by a timer, a memory with time stamps."""

from collections import deque
from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from gyrotest.ports import Clock
from gyrotest.simulation.converter import Converter
from gyrotest.simulation.faults import Faults
from gyrotest.simulation.interpreter import Interpreter
from gyrotest.simulation.meter_state import HangUp, Interface, Reply
from gyrotest.simulation.scenarios import Misbehaviour
from gyrotest.simulation.scpi import ErrorQueue, ScpiError

NPLC = (0.02, 0.2, 1.0, 2.0, 10.0, 20.0, 100.0, 200.0)
RANGES_V = (0.1, 1.0, 10.0, 100.0, 300.0)
MEMORY = 50_000
_CHANNELS_A_SLOT, _SLOTS = 20, (1, 2, 3)
_SHORTEST_READING_S = 1e-3
# Opening and closing the relay, and letting the input settle.
_RELAY_S = 0.012
_AUTO_DELAY_S = 1e-3
# A sensor of 10 mV/°C stands for every temperature probe.
_DEGC_PER_V = 100.0
_SENSOR_RANGE_V = 10.0
_NO_READING = 9.9e37
_OVERFLOW = 1 << 12
_BATCH = 512
_GARBAGE = b"\x15\x7f?+2.5#\x0b;0E\n"


@dataclass(slots=True, kw_only=True)
class Channel:
    """How a channel is set up; `probe` is that of a temperature, None for DC volts."""

    range_v: float | None = None
    nplc: float = 1.0
    autozero: bool = True
    high_impedance: bool = False
    probe: str | None = None
    kind: str = ""
    delay_s: float | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class _Reading:
    value: float
    time_s: float
    channel: int


@dataclass(slots=True, kw_only=True)
class _Scan:
    """A scan under way: `begins_s` and `ends_s` of each channel's measurement within a sweep."""

    start_s: float
    spacing_s: float
    count: float
    channels: tuple[int, ...]
    begins_s: NDArray[np.float64]
    ends_s: NDArray[np.float64]
    done: NDArray[np.int64]

    def ready(self, now_s: float) -> NDArray[np.int64]:
        """How many readings of each channel are there by now."""
        swept = np.floor((now_s - self.start_s - self.ends_s + 1e-9) / self.spacing_s) + 1.0
        return np.clip(swept, 0.0, min(self.count, 1e15)).astype(np.int64)


@dataclass(slots=True, kw_only=True)
class Form:
    """What is given with a reading."""

    time: bool = False
    channel: bool = False
    unit: bool = False
    alarm: bool = False


@dataclass(slots=True, kw_only=True)
class Settings:
    """What `*RST` resets."""

    channels: dict[int, Channel] = field(default_factory=dict)
    scan_list: tuple[int, ...] = ()
    trigger_source: str = "IMM"
    trigger_count: float = 1.0
    timer_s: float = 10.0
    form: Form = field(default_factory=Form)


class SimulatedScanner:
    """A scanner with a multiplexer in each slot; every channel may have a converter.

    `hurried`: nobody but the scanner itself moves the clock.
    """

    def __init__(
        self,
        *,
        clock: Clock,
        line_frequency_hz: float,
        identity: str = "HEWLETT-PACKARD,34970A,SIM00005,13-2-2",
        hurried: bool = False,
    ) -> None:
        self.identity = identity
        self.errors = ErrorQueue()
        self.now_s = clock.now_s()
        self.settings = Settings()
        self.questionable = 0
        self.memory: deque[_Reading] = deque(maxlen=MEMORY)
        self.faults = Faults((), start_s=0.0, duration_s=0.0)
        self.asked_for_readings = False
        self._line_frequency_hz = line_frequency_hz
        self._hurried = hurried
        self._converters: dict[int, Converter] = {}
        self._scan: _Scan | None = None

    def connect(self, converters: Mapping[int, Converter], faults: Faults) -> None:
        """Put signals on some channels; what was under way is dropped."""
        self._scan = None
        self._converters |= converters
        self.faults = faults

    def channel(self, number: int) -> Channel:
        """A channel's set-up; raises `ScpiError` for one that there is not."""
        if number // 100 not in _SLOTS or not 1 <= number % 100 <= _CHANNELS_A_SLOT:
            raise ScpiError(-222)
        return self.settings.channels.setdefault(number, Channel())

    def reset(self) -> None:
        """`*RST`."""
        self.abort()
        self.memory.clear()
        self.settings = Settings()

    # The scan

    @property
    def scanning(self) -> bool:
        """Whether a scan is under way at this moment."""
        self.catch_up()
        return self._scan is not None

    def initiate(self) -> None:
        """`INIT`: clear the memory and begin; raises `ScpiError`."""
        if self.scanning:
            raise ScpiError(-213)
        if not self.settings.scan_list:
            raise ScpiError(-221)
        self.memory.clear()
        self.questionable = 0
        self._scan = self._new_scan()

    def abort(self) -> None:
        """Stop; what is in the memory stays."""
        self.catch_up()
        self._scan = None

    def take(self, most: float) -> list[_Reading]:
        """Remove the oldest readings from the memory."""
        self.asked_for_readings = True
        self._hurry()
        self.catch_up()
        return [self.memory.popleft() for _ in range(int(min(most, len(self.memory))))]

    def catch_up(self) -> None:
        """Take the readings that the time since has made due."""
        scan = self._scan
        if scan is None:
            return
        ready = scan.ready(self.now_s)
        while (scan.done < ready).any():
            self._keep(scan, np.minimum(ready, scan.done.min() + _BATCH))
        if (scan.done >= scan.count).all():
            self._scan = None

    def _new_scan(self) -> _Scan:
        channels = self.settings.scan_list
        delays_s = np.array([self._delay_s(self.channel(one)) for one in channels])
        busy_s = np.array([self._reading_s(self.channel(one)) for one in channels])
        ends_s = np.cumsum(delays_s + busy_s)
        paced = self.settings.trigger_source == "TIM"
        sweep_s = float(ends_s[-1])
        return _Scan(
            start_s=self.now_s,
            # A timer that is too short for a sweep is not refused: the next one follows at once.
            spacing_s=max(self.settings.timer_s, sweep_s) if paced else sweep_s,
            count=self.settings.trigger_count,
            channels=channels,
            begins_s=ends_s - busy_s,
            ends_s=ends_s,
            done=np.zeros(len(channels), dtype=np.int64),
        )

    def _aperture_s(self, channel: Channel) -> float:
        return channel.nplc / self._line_frequency_hz

    def _reading_s(self, channel: Channel) -> float:
        reading_s = max(self._aperture_s(channel), _SHORTEST_READING_S)
        return reading_s * (2 if channel.autozero else 1)

    def _delay_s(self, channel: Channel) -> float:
        return _RELAY_S + (_AUTO_DELAY_S if channel.delay_s is None else channel.delay_s)

    def _keep(self, scan: _Scan, until: NDArray[np.int64]) -> None:
        """Readings of each channel up to a number of sweeps, into the memory in the order of time."""
        found: list[_Reading] = []
        for place, number in enumerate(scan.channels):
            first, count = int(scan.done[place]), int(until[place] - scan.done[place])
            if count <= 0:
                continue
            since_s = float(scan.begins_s[place]) + first * scan.spacing_s
            values = self._values(number, scan.start_s + since_s, scan.spacing_s, count)
            found += [
                _Reading(value=value, time_s=since_s + step * scan.spacing_s, channel=number)
                for step, value in enumerate(values)
            ]
            scan.done[place] += count
        if len(self.memory) + len(found) > MEMORY:
            self.questionable |= _OVERFLOW
        self.memory.extend(sorted(found, key=lambda one: one.time_s))

    def _values(self, number: int, start_s: float, spacing_s: float, count: int) -> list[float]:
        channel, converter = self.channel(number), self._converters.get(number)
        if converter is None:
            # An open input is a broken thermocouple, and next to nothing in volts.
            return [0.0 if channel.probe is None else _NO_READING] * count
        readings = converter.readings(
            start_s,
            self._aperture_s(channel),
            spacing_s,
            count,
            range_v=channel.range_v if channel.probe is None else _SENSOR_RANGE_V,
            nplc=channel.nplc,
        )
        if channel.probe is not None:
            readings = np.where(np.abs(readings) < _NO_READING, _DEGC_PER_V * readings, readings)
        values: list[float] = readings.tolist()
        return values

    def _hurry(self) -> None:
        if self._hurried and self._scan is not None and not self.memory:
            scan = self._scan
            next_s = scan.start_s + float(scan.done.min()) * scan.spacing_s + float(scan.ends_s[-1])
            self.now_s = max(self.now_s, next_s)


class ScannerSpeaker:
    """The scanner's front end; a reply with readings is what a fault of the bench strikes."""

    def __init__(self, scanner: SimulatedScanner, interpreter: Interpreter[SimulatedScanner]) -> None:
        self._scanner = scanner
        self._interpreter = interpreter
        self._dead = False

    def execute(self, message: str, interface: Interface) -> Reply | None:
        """Carry out a program message; the reply, if there is one. May raise `HangUp`."""
        if self._dead:
            return None
        self._scanner.asked_for_readings = False
        reply = self._interpreter.execute(message, interface)
        if not self._scanner.asked_for_readings or reply is None:
            return reply
        strike = self._scanner.faults.strike(self._scanner.now_s)
        if strike is None:
            return reply
        if strike is Misbehaviour.GARBLE:
            return Reply(parts=((self._scanner.now_s, _GARBAGE),))
        self._dead = strike is Misbehaviour.DEAD
        if strike is Misbehaviour.HANG_UP and interface is not Interface.SERIAL:
            raise HangUp
        return None

    def clear(self) -> None:
        """Device clear: what is under way stops."""
        self._scanner.abort()

    def refuse(self, code: int) -> None:
        """Put an error into the queue."""
        self._interpreter.refuse(code)

    def status_byte(self) -> int:
        """The status byte."""
        return self._interpreter.status_byte()
