"""Keysight 34970A and its family: a multimeter that scans channels one after another, paced by its timer."""

import math
import re
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from gyrotest.errors import InstrumentError, InstrumentProtocolError, InstrumentTimeoutError
from gyrotest.instruments import scpi
from gyrotest.instruments.identity import Expected
from gyrotest.instruments.pacing import Grid, margin_s
from gyrotest.instruments.scanner_commands import Scan
from gyrotest.instruments.scanner_readings import SweepReader, Sweeps
from gyrotest.instruments.scanner_samples import first_trouble, samples_of
from gyrotest.instruments.scanner_settings import Keysight34970ASettings, is_channel
from gyrotest.instruments.scpi import Setting
from gyrotest.instruments.session import Session
from gyrotest.instruments.transport.channel import Connect
from gyrotest.instruments.transport.visa import open_channel
from gyrotest.instruments.voltage import noise_of_mean, power_line_cycle_s, too_short
from gyrotest.ports import Clock
from gyrotest.records.recording import Auxiliary, Block, Identity, Sampling
from gyrotest.records.station import Accuracy

_MEMORY_OVERFLOW = 1 << 12
_TIMER_STEP_S = 1e-3
# What a channel takes beside its readings at the most: relay, settling, reference junction.
_CHANNEL_S = 0.25
_TRIAL_SWEEPS = 2
_POLL_S = 5.0
_GRACE_S = 2.0
_CLOCK_TOLERANCE = 1e-3

_EXPECTED = Expected(
    manufacturer=re.compile("HEWLETT|HP|AGILENT|KEYSIGHT", re.IGNORECASE),
    model=re.compile("34970A|34972A|DAQ970A|DAQ973A", re.IGNORECASE),
    spoken="a Keysight 34970A, 34972A, DAQ970A or DAQ973A",
)


class Keysight34970A:
    """The scanner measures its channels' order in time by a trial, then sweeps by its own timer.

    Channels are named by their numbers (`'101'`), in `select` as in the sampling that `configure` returns.
    """

    settings: ClassVar[type] = Keysight34970ASettings

    def __init__(
        self,
        resource: str,
        settings: Keysight34970ASettings,
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
        self._resource = resource
        self._session = Session(
            resource,
            _EXPECTED,
            line=settings.line,
            serial_number=serial_number,
            io_timeout_s=io_timeout_s,
            connect=connect,
        )
        self._newer = False
        self._scan = Scan(settings=settings, outputs=(), auxiliary=())
        self._times_s: NDArray[np.float64] = np.empty(0)
        self._sweep_s = 0.0
        self._grid: Grid | None = None
        self._reader: SweepReader | None = None
        self._first = 0
        self._position = 0
        self._end = 0
        self._init_s = 0.0
        self._polled_s = 0.0
        self._begun_s: float | None = None
        self._fault: InstrumentError | None = None

    def open(self) -> Identity:
        """Connect and ask who is there; raises `InstrumentError`."""
        identity = self._session.open()
        self._newer = identity.model.upper().startswith("DAQ")
        return identity

    def select(self, outputs: tuple[str, ...], auxiliary: tuple[str, ...]) -> None:
        """Choose the channels, by number; raises `InstrumentError` for what is none, or chosen twice."""
        if not outputs:
            raise InstrumentError(
                f"{self._resource}: no channel is named for the unit's output; give the slot a 'channel',"
                " e.g. '101'"
            )
        scan = Scan(settings=self._settings, outputs=outputs, auxiliary=tuple(dict.fromkeys(auxiliary)))
        for channel in scan.columns:
            if not is_channel(channel):
                raise InstrumentError(
                    f"{self._resource}: '{channel}' is no channel; write slot and channel, e.g. '101'"
                )
        twice = sorted({one for one in scan.columns if scan.columns.count(one) > 1})
        if twice:
            raise InstrumentError(
                f"{self._resource}: channel {', '.join(twice)} is chosen twice; each slot has its own"
            )
        self._scan = scan

    def configure(self, interval_s: float) -> Sampling:
        """Set the channels up, measure how a sweep runs, set the timer; raises `InstrumentError`."""
        self._apply_channels()
        self._try_out()
        shortest_s = self._sweep_s + margin_s(self._sweep_s)
        if interval_s < shortest_s:
            raise too_short(
                self._session.talk.who,
                interval_s,
                reading=f"{len(self._scan.columns)} channel(s) at nplc {self._settings.nplc:g}"
                f" ({self._sweep_s:.4g} s a sweep)",
                shortest_s=math.ceil(shortest_s / _TIMER_STEP_S) * _TIMER_STEP_S,
            )
        self._grid = Grid(self._clock, self._apply_timer(interval_s))
        return Sampling(
            interval_s=self._grid.interval_s,
            aperture_s=self._settings.nplc * self._cycle_s,
            channels=self._scan.outputs,
            auxiliary=tuple(
                Auxiliary(name=one, unit=self._settings.at(one).printed) for one in self._scan.auxiliary
            ),
            offsets_s=self._offsets_s(),
            noise=noise_of_mean(self._accuracy, 1),
            range=self._settings.range.to("V"),
        )

    def start(self, first: int, count: int) -> None:
        """Begin: samples `first` … `count - 1`; the grid lies from the first start on."""
        grid, talk = self._laid_grid(), self._session.talk
        grid.begin(first)
        # A scan that was broken off goes on until it is stopped.
        talk.write("ABOR")
        self._clock.sleep_until(grid.deadline_s(first))
        self._init_s = self._polled_s = self._clock.now_s()
        scpi.initiate(talk, self._session.timeout_s)
        self._reader = SweepReader(self._scan.scanned, talk.who)
        self._first, self._position, self._end = first, first, count
        self._begun_s = self._fault = None

    def fetch(self) -> Block | None:
        """Wait for the next whole sweeps, a few seconds of them; None after the last."""
        if self._fault is not None:
            fault, self._fault = self._fault, None
            raise fault
        if self._position >= self._end:
            self._session.talk.write("ABOR")
            scpi.refuse_errors(self._session.talk, self._session.timeout_s)
            return None
        reader = self._begun_reader()
        while not reader.sweeps:
            self._clock.sleep_until(self._next_poll_s())
            self._poll(reader)
            self._refuse_silence(reader)
        return self._block(reader.take(self._end - self._position))

    def recover(self) -> int:
        """Clear or reconnect, the same scanner, settings again; returns the next position on the grid."""
        grid = self._laid_grid()
        self._session.bring_back()
        self._apply_channels()
        self._apply_timer(grid.interval_s)
        return grid.position_to_go_on()

    def remarks(self) -> tuple[str, ...]:
        """How the channels follow one another, for the certificate."""
        if len(self._scan.columns) < 2 or not self._times_s.size:
            return ()
        first, *rest = zip(self._scan.columns, self._offsets_s(), strict=True)
        told = ", ".join(f"{name} {1e3 * offset_s:+.0f} ms" for name, offset_s in rest)
        return (f"channels are read one after another: {told} from channel {first[0]}",)

    def query(self, command: str) -> str:
        """Ask the scanner anything, outside of an acquisition; raises `InstrumentError`."""
        return self._session.talk.query(command, self._session.timeout_s)

    def close(self) -> None:
        """Stopped and disconnected; never raises."""
        self._session.leave("ABOR")

    @property
    def _cycle_s(self) -> float:
        return power_line_cycle_s(self._line_frequency_hz, self._session.talk.who)

    def _offsets_s(self) -> tuple[float, ...]:
        times_s = self._times_s[self._scan.places]
        return tuple((times_s - times_s[0]).tolist())

    # Settings

    def _apply_channels(self) -> None:
        scan, talk, timeout_s = self._scan, self._session.talk, self._session.timeout_s
        if not scan.outputs:
            raise InstrumentError(
                f"{talk.who}: no channels are selected; give the slot a 'channel', e.g. '101'"
            )
        scpi.apply(talk, scan.channel_settings(newer=self._newer), timeout_s)
        scpi.apply(talk, scan.list_settings(), timeout_s)
        found = talk.query_block("ROUT:SCAN?", timeout_s).decode("ascii", "replace")
        if found != scan.written:
            raise InstrumentProtocolError(
                f"{talk.who}: the scan list is {found}, expected {scan.written}; are these channels of a"
                " multiplexer that is plugged in?"
            )

    def _apply_timer(self, interval_s: float) -> float:
        """Set the timer and return what it is set to: it counts milliseconds."""
        talk, timeout_s = self._session.talk, self._session.timeout_s
        settings = (
            Setting("TRIG:SOUR TIM", "TRIG:SOUR?", "TIM"),
            Setting(f"TRIG:TIM {interval_s:.3f}"),
            Setting("TRIG:COUN INF"),
        )
        scpi.apply(talk, settings, timeout_s)
        found_s = scpi.number(talk, "TRIG:TIM?", timeout_s)
        if abs(found_s - interval_s) > _TIMER_STEP_S:
            raise InstrumentProtocolError(
                f"{talk.who}: TRIG:TIM? gives {found_s:g} s, expected {interval_s:g} s;"
                " is the setting within what this model can do?"
            )
        return found_s

    def _try_out(self) -> None:
        """Two sweeps, as fast as they go: when each channel's turn comes, and how long a sweep takes."""
        talk, timeout_s = self._session.talk, self._session.timeout_s
        scpi.apply(
            talk,
            (
                Setting("TRIG:SOUR IMM", "TRIG:SOUR?", "IMM"),
                Setting(f"TRIG:COUN {_TRIAL_SWEEPS}", "TRIG:COUN?", float(_TRIAL_SWEEPS)),
            ),
            timeout_s,
        )
        scpi.initiate(talk, timeout_s)
        times_s = self._trial_sweeps().times_s
        self._times_s = (times_s - times_s[:, :1]).mean(axis=0)
        self._sweep_s = float(times_s[1, 0] - times_s[0, 0])

    def _trial_sweeps(self) -> Sweeps:
        talk, began_s = self._session.talk, self._clock.now_s()
        reader = SweepReader(self._scan.scanned, talk.who)
        least_s = _TRIAL_SWEEPS * self._scan.least_sweep_s(self._cycle_s)
        most_s = least_s + _TRIAL_SWEEPS * _CHANNEL_S * len(self._scan.columns) + _GRACE_S
        self._clock.sleep_until(began_s + least_s)
        while True:
            reader.push(talk.query_block("R?", self._session.timeout_s))
            if reader.sweeps >= _TRIAL_SWEEPS:
                return reader.take(_TRIAL_SWEEPS)
            now_s = self._clock.now_s()
            if now_s > began_s + most_s:
                raise InstrumentTimeoutError(
                    f"{talk.who}: {reader.sweeps} of {_TRIAL_SWEEPS} sweeps of a trial came within"
                    f" {now_s - began_s:.3g} s; was its scan stopped at the front panel?"
                )
            self._clock.sleep_until(now_s + max(0.05, 0.1 * least_s))

    # Readings

    def _next_poll_s(self) -> float:
        """Every few seconds, but not before a sweep is whole, nor later than the last one is."""
        last_s = self._ready_s(self._end - 1)
        due_s = max(self._ready_s(self._position), min(self._polled_s + _POLL_S, last_s))
        # A scanner whose clock runs slow is asked again a moment later.
        return max(due_s, self._polled_s + min(self._laid_grid().interval_s, 0.5))

    def _ready_s(self, position: int) -> float:
        interval_s = self._laid_grid().interval_s
        return self._init_s + (position - self._first) * interval_s + self._sweep_s + _TIMER_STEP_S

    def _poll(self, reader: SweepReader) -> None:
        """Take what the memory holds. A memory that has overflowed has lost readings, nobody knows which."""
        talk, timeout_s = self._session.talk, self._session.timeout_s
        content = talk.query_block("R?", timeout_s)
        self._polled_s = self._clock.now_s()
        if int(scpi.number(talk, "STAT:QUES?", timeout_s)) & _MEMORY_OVERFLOW:
            raise InstrumentProtocolError(
                f"{talk.who}: its memory overflowed and readings are lost; was this computer asleep?"
            )
        reader.push(content)

    def _refuse_silence(self, reader: SweepReader) -> None:
        now_s = self._clock.now_s()
        late_s = now_s - self._ready_s(self._position)
        interval_s = self._laid_grid().interval_s
        if not reader.sweeps and late_s > _GRACE_S + interval_s + _CLOCK_TOLERANCE * (
            now_s - self._init_s
        ):
            raise InstrumentTimeoutError(
                f"{self._session.talk.who}: no whole sweep in its memory, expected since {late_s:.3g} s;"
                " is its trigger source TIM, and was its scan stopped at the front panel?"
            )

    def _block(self, sweeps: Sweeps) -> Block:
        """Samples of these sweeps; those before a trouble go out first, the trouble with the next fetch."""
        samples, grid = samples_of(sweeps, self._scan), self._laid_grid()
        due_s = self._due_s(samples.times_s, grid.interval_s)
        trouble = first_trouble(
            samples,
            self._scan,
            due_s=due_s,
            interval_s=grid.interval_s,
            who=self._session.talk.who,
        )
        count = len(due_s) if trouble is None else trouble.at
        if trouble is not None:
            if not count:
                raise trouble.error
            self._fault = trouble.error
        first, self._position = self._position, self._position + count
        return Block(
            first=first,
            time_s=self._init_s - grid.deadline_s(0) + samples.times_s[:count],
            values=np.ascontiguousarray(samples.values[:count]),
            flags=np.bitwise_or.reduce(samples.flags[:count, : len(self._scan.outputs)], axis=1),
        )

    def _due_s(self, times_s: NDArray[np.float64], interval_s: float) -> NDArray[np.float64]:
        """When these samples are due on the timer's grid, which the first one of the scan has laid."""
        if self._begun_s is None:
            self._begun_s = float(times_s[0])
        step = self._position - self._first
        steps = np.arange(step, step + len(times_s), dtype=np.float64)
        return np.asarray(self._begun_s + interval_s * steps)

    def _begun_reader(self) -> SweepReader:
        if self._reader is None:
            raise InstrumentError(f"{self._session.talk.who}: not started; start it first")
        return self._reader

    def _laid_grid(self) -> Grid:
        if self._grid is None:
            raise InstrumentError(
                f"{self._session.talk.who}: not configured; configure an interval first"
            )
        return self._grid
