"""HP / Agilent 34401A multimeter, DC volts; the host paces it with one READ? an interval."""

import re
from dataclasses import dataclass
from typing import Annotated, ClassVar

import numpy as np

from gyrotest.errors import InstrumentError
from gyrotest.instruments import scpi
from gyrotest.instruments.identity import Expected
from gyrotest.instruments.pacing import Grid, Readings
from gyrotest.instruments.scpi import Setting
from gyrotest.instruments.session import Session
from gyrotest.instruments.transport.channel import Connect, FlowControl
from gyrotest.instruments.transport.serial_settings import SerialSettings
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
from gyrotest.records.described import Described
from gyrotest.records.recording import Block, Identity, Sampling
from gyrotest.records.station import Accuracy

# Resolution as a part of the range that stands for each integration time.
_RESOLUTION = {0.02: 1e-4, 0.2: 1e-5, 1.0: 3e-6, 10.0: 1e-6, 100.0: 3e-7}
_SHORTEST_READING_S = 1e-3
_MOST_READINGS = 50_000
_MEMORY = 512
_BYTES_PER_READING = 17
_BYTES_PER_QUERY = 7
_BLOCK_S = 1.0
_SAFE_PART_OF_WAIT = 0.8

_EXPECTED = Expected(
    manufacturer=re.compile("HEWLETT|HP|AGILENT|KEYSIGHT", re.IGNORECASE),
    model=re.compile("34401A", re.IGNORECASE),
    spoken="an HP / Agilent 34401A",
)


@dataclass(frozen=True, slots=True, kw_only=True)
class Agilent34401ASettings(SerialSettings, MeterSettings):
    """The station's settings of a 34401A; the serial ones count on RS-232 only."""

    stop_bits: Annotated[int, Described("RS-232: 1 or 2 stop bits.", "2")] = 1
    flow_control: Annotated[
        FlowControl, Described("RS-232: handshake; the meter's own is `dtr_dsr`.", "dtr_dsr")
    ] = FlowControl.NONE

    def __post_init__(self) -> None:
        check_range(self.range)
        check_nplc(self.nplc, tuple(_RESOLUTION), "34401A")
        _ = self.line  # checks the serial settings


class Agilent34401A:
    """The meter has no sample timer: each sample is a READ? at its deadline, of as many readings as fit."""

    settings: ClassVar[type] = Agilent34401ASettings

    def __init__(
        self,
        resource: str,
        settings: Agilent34401ASettings,
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
        self._io_timeout_s = io_timeout_s
        self._session = Session(
            resource,
            _EXPECTED,
            line=settings.line,
            serial_number=serial_number,
            io_timeout_s=io_timeout_s,
            connect=connect,
        )
        self._grid: Grid | None = None
        self._count = 1
        self._busy_s = 0.0
        self._reading_timeout_s = 1.0
        self._by_memory = False
        self._position = 0
        self._end = 0
        self._fault: InstrumentError | None = None

    def open(self) -> Identity:
        """Connect and ask who is there; raises `InstrumentError`."""
        return self._session.open()

    def configure(self, interval_s: float) -> Sampling:
        """Average as many readings as fit into each interval; raises `InstrumentError`."""
        readings = self._readings()
        self._count = self._fitting(readings, interval_s)
        self._busy_s = self._count * readings.reading_s
        self._reading_timeout_s = self._io_timeout_s or (
            2 * self._count * (readings.reading_s + readings.transfer_s) + 1.0
        )
        self._by_memory = self._needs_memory(self._busy_s)
        self._grid = Grid(self._clock, interval_s)
        self._apply()
        return Sampling(
            interval_s=interval_s,
            aperture_s=readings.aperture_s,
            readings=self._count,
            noise=noise_of_mean(self._accuracy, self._count),
            range=self._settings.range.to("V"),
        )

    def start(self, first: int, count: int) -> None:
        """Begin: samples `first` … `count - 1`; the grid lies from the first start on."""
        self._laid_grid().begin(first)
        self._position, self._end, self._fault = first, count, None
        if not self._settings.autozero:
            self._session.talk.write("ZERO:AUTO ONCE")

    def fetch(self) -> Block | None:
        """Wait for about a second of samples, one at least; None after the last."""
        if self._fault is not None:
            fault, self._fault = self._fault, None
            raise fault
        grid = self._laid_grid()
        self._skip_what_was_missed(grid)
        if self._position >= self._end:
            scpi.refuse_errors(self._session.talk, self._session.timeout_s)
            return None
        return self._gather(grid)

    def recover(self) -> int:
        """Clear or reconnect, the same meter, settings again; returns the next position on the grid."""
        self._session.bring_back()
        self._apply()
        return self._laid_grid().position_to_go_on()

    def query(self, command: str) -> str:
        """Ask the meter anything, outside of an acquisition; raises `InstrumentError`."""
        return self._session.talk.query(command, self._session.timeout_s)

    def close(self) -> None:
        """Display on, front panel back, disconnected; never raises."""
        self._session.leave("DISP ON")

    def _gather(self, grid: Grid) -> Block:
        first, start_s = self._position, grid.deadline_s(0)
        most = min(self._end - first, max(1, round(_BLOCK_S / grid.interval_s)))
        times: list[float] = []
        samples: list[tuple[float, int]] = []
        try:
            for position in range(first, first + most):
                begin_s = self._begin_of(grid.deadline_s(position))
                if samples and begin_s >= grid.deadline_s(position + 1):
                    break
                samples.append(self._sample())
                times.append(begin_s - start_s)
        except InstrumentError as fault:
            # What was read before the fault is good: it goes out first, the fault with the next fetch.
            if not samples:
                raise
            self._fault = fault
        self._position = first + len(samples)
        values, flags = zip(*samples, strict=True)
        return Block(
            first=first,
            time_s=np.array(times),
            values=np.array(values).reshape(-1, 1),
            flags=np.array(flags, dtype=np.uint8),
        )

    def _begin_of(self, deadline_s: float) -> float:
        self._clock.sleep_until(deadline_s)
        return self._clock.now_s()

    def _sample(self) -> tuple[float, int]:
        talk = self._session.talk
        if self._by_memory:
            scpi.initiate(talk, self._session.timeout_s)
            self._clock.sleep_until(self._clock.now_s() + self._busy_s)
            reply = talk.query_line(b"FETC?\n", self._reading_timeout_s)
        else:
            reply = talk.query_line(b"READ?\n", self._reading_timeout_s)
        return scpi.sample_of(scpi.readings(reply, self._count, talk.who))

    def _skip_what_was_missed(self, grid: Grid) -> None:
        """A sample that is late by an interval or more is a gap, not a late sample."""
        if self._clock.now_s() >= grid.deadline_s(self._position + 1):
            self._position = grid.next_position()

    def _readings(self) -> Readings:
        cycle_s = power_line_cycle_s(self._line_frequency_hz, self._session.talk.who)
        aperture_s = self._settings.nplc * cycle_s
        byte_s = self._session.talk.channel.seconds_per_byte
        return Readings(
            aperture_s=aperture_s,
            # Every reading is followed by one of the zero with autozero.
            reading_s=max(aperture_s, _SHORTEST_READING_S) * (2 if self._settings.autozero else 1),
            transfer_s=_BYTES_PER_READING * byte_s,
            query_s=_BYTES_PER_QUERY * byte_s,
        )

    def _fitting(self, readings: Readings, interval_s: float) -> int:
        count = readings.fitting(interval_s, _MOST_READINGS)
        if not count:
            zeroed = " and autozero" if self._settings.autozero else ""
            raise too_short(
                self._session.talk.who,
                interval_s,
                reading=f"nplc {self._settings.nplc:g}{zeroed} ({readings.reading_s:.4g} s a reading)",
                shortest_s=readings.shortest_interval_s(),
            )
        return min(count, _MEMORY) if self._needs_memory(count * readings.reading_s) else count

    def _needs_memory(self, busy_s: float) -> bool:
        """Whether READ? takes longer than the adapter waits, so that INIT, a pause and FETC? are needed."""
        longest_s = self._session.talk.channel.longest_wait_s
        return longest_s is not None and busy_s > _SAFE_PART_OF_WAIT * longest_s

    def _apply(self) -> None:
        volts = self._settings.range.to("V")
        resolution = _RESOLUTION[self._settings.nplc] * volts
        autozero, high = self._settings.autozero, self._settings.high_impedance
        scpi.apply(
            self._session.talk,
            (
                # CONF first: it resets trigger, sample count and autozero.
                Setting(f"CONF:VOLT:DC {volts:g},{resolution:.0E}", "VOLT:DC:RANG?", volts),
                Setting(f"VOLT:DC:NPLC {self._settings.nplc:g}", "VOLT:DC:NPLC?", self._settings.nplc),
                Setting(f"INP:IMP:AUTO {on_off(on=high)}", "INP:IMP:AUTO?", float(high)),
                Setting(f"ZERO:AUTO {on_off(on=autozero)}", "ZERO:AUTO?", float(autozero)),
                Setting("TRIG:SOUR IMM", "TRIG:SOUR?", "IMM"),
                Setting("TRIG:COUN 1", "TRIG:COUN?", 1.0),
                # The automatic delay would lengthen every reading.
                Setting("TRIG:DEL 0", "TRIG:DEL?", 0.0),
                Setting(f"SAMP:COUN {self._count}", "SAMP:COUN?", float(self._count)),
                Setting("DISP OFF"),
            ),
            self._session.timeout_s,
        )

    def _laid_grid(self) -> Grid:
        if self._grid is None:
            raise InstrumentError(
                f"{self._session.talk.who}: not configured; configure an interval first"
            )
        return self._grid
