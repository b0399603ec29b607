"""An acquisition from a gyro that talks unasked: what arrives is read in blocks and put on the grid."""

import math
import sys
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from gyrotest.errors import InstrumentError, InstrumentProtocolError, InstrumentTimeoutError
from gyrotest.instruments.streaming.readings import Counter, Decoder, Readings, joined
from gyrotest.instruments.streaming.samples import Sampler
from gyrotest.instruments.streaming.timeline import Timeline
from gyrotest.instruments.transport.byte_stream import ByteStream
from gyrotest.ports import Clock
from gyrotest.records.recording import Block, SampleFlag

# What is read at once: about a second of it, but well below what a pseudo-terminal or a driver holds.
_BLOCK_S = 1.0
_BLOCK_BYTES = 8192
_FEWEST = 4
# How long bytes that are due may be on their way, in real time, before they are taken for lost.
_ON_THE_WAY_S = 0.1
# When readings seem to be lost, they may be late: look again, this long and this often.
_LOOK_AGAIN_S = 0.05
_LOOKS = 6
_FLOWING = 0.5
# Bytes but no reading for so long: these are not the bytes that are expected.
_GARBAGE_S = 2.0
_START_UP_S = 10.0
_LISTEN_S = 1.0
_RATE_TOLERANCE = 0.2
_MOMENT_S = 0.1

_T = TypeVar("_T")


@dataclass(frozen=True, slots=True, kw_only=True)
class Rhythm:
    """How often readings come, as the station says: the period, and the counter where there is one."""

    period_s: float
    counter: Counter | None = None

    @property
    def rate_hz(self) -> float:
        """Readings a second."""
        return 1.0 / self.period_s


class Flow:
    """Reads one stream in step with the clock; the decoder says what a reading is."""

    def __init__(
        self, who: str, decoder: Decoder, rhythm: Rhythm, *, clock: Clock, io_timeout_s: float
    ) -> None:
        self.who = who
        self._decoder, self._rhythm, self._clock = decoder, rhythm, clock
        self._io_timeout_s = io_timeout_s
        self._stream: ByteStream | None = None
        self._timeline = Timeline(who, rhythm.period_s, rhythm.counter)
        self._sampler = Sampler(1, rhythm.period_s)
        self._size = 1
        self._end = 0
        self._blocks: deque[Block] = deque()
        self._read_s = self._reading_s = 0.0
        self._following = False
        most_s = _BLOCK_BYTES / decoder.reading_bytes * rhythm.period_s
        self._block_s = max(min(_BLOCK_S, most_s), _FEWEST * rhythm.period_s)

    def attach(self, stream: ByteStream) -> None:
        """Read from here on."""
        self._stream = stream

    def detach(self) -> None:
        """Disconnect; idempotent, never raises."""
        if self._stream is not None:
            self._stream.close()
            self._stream = None

    def send(self, data: bytes) -> None:
        """Send bytes to the gyro; raises `InstrumentError`."""
        self._io(lambda stream: stream.write(data))

    def raw(self, duration_s: float) -> bytes:
        """What arrives in a while, undecoded; raises `InstrumentError`."""
        self._clock.sleep_until(self._clock.now_s() + duration_s)
        return self._io(lambda stream: stream.read(1, _ON_THE_WAY_S))

    def listen(self) -> None:
        """See that readings come, and as often as they should; raises `InstrumentError`."""
        self._restart()
        self._gather_some(self._block_s / 4)
        heard, count = [self._gather_some(self._block_s / 4)], 0
        since_s = self._read_s
        while self._read_s - since_s < max(_LISTEN_S, 10 * self._rhythm.period_s):
            heard.append(self._gather_some(self._block_s))
            count += len(heard[-1])
        self._refuse_other_rate(joined(heard), count / (self._read_s - since_s))

    def configure(self, size: int, interval_s: float) -> None:
        """Average so many readings to a sample from the next start on, and count losses anew."""
        self._size = size
        self._sampler = Sampler(size, interval_s)
        self._decoder.forget()

    def start(self, first: int, count: int) -> None:
        """Begin; the first reading that is no start-up is number 0, after an interruption the grid stays."""
        self._restart()
        self._blocks.clear()
        anew = first == 0 or not self._timeline.begun
        readings = self._started()
        self._sampler.begin(first, count)
        self._end = count
        if anew:
            late_s = (len(readings) - 1) * self._rhythm.period_s
            self._timeline.begin(self._read_s - late_s)
        else:
            self._timeline.resume(readings, self._read_s)
        self._following = True
        self._take(readings)

    def fetch(self) -> Block | None:
        """Wait for the next samples; None after the last."""
        while not self._blocks and self._sampler.position < self._end:
            self._take(self._gather(self._next_read_s()))
        return self._blocks.popleft() if self._blocks else None

    def position_to_go_on(self) -> int:
        """The first sample that can be met a moment from now."""
        if not self._timeline.begun:
            return 0
        since_s = self._clock.now_s() + _MOMENT_S - self._timeline.due_s(0)
        return max(0, math.ceil(since_s / (self._size * self._rhythm.period_s)))

    def remarks(self) -> tuple[str, ...]:
        """What was lost since `configure`."""
        lost, gaps = self._sampler.lost, self._sampler.gaps
        told = f"{many(lost, 'sample')} lost in {many(gaps, 'gap')}" if lost else "no sample lost"
        return (told, *self._decoder.remarks())

    def _restart(self) -> None:
        self._io(lambda stream: stream.discard())
        self._decoder.restart()
        self._following = False
        self._read_s = self._reading_s = self._clock.now_s()

    def _started(self) -> Readings:
        """The first readings that are no start-up ones."""
        until_s = self._clock.now_s() + _START_UP_S
        while True:
            readings = self._gather_some(
                min(self._block_s, max(_LOOK_AGAIN_S, 4 * self._rhythm.period_s))
            )
            ready = np.flatnonzero((readings.flags & SampleFlag.START_UP) == 0)
            if len(ready):
                return readings.part(slice(int(ready[0]), None))
            if self._read_s > until_s:
                raise InstrumentError(
                    f"{self.who}: has been starting up for {_START_UP_S:g} s and goes on; is the unit damaged?"
                )

    def _next_read_s(self) -> float:
        """A block on; not beyond the last sample that is wanted, nor long before the next one is complete."""
        last_s = self._timeline.due_s(self._end * self._size)
        return max(min(self._read_s + self._block_s, last_s), self._read_s + self._rhythm.period_s)

    def _gather_some(self, step_s: float) -> Readings:
        while True:
            readings = self._gather(self._clock.now_s() + step_s)
            if len(readings):
                return readings

    def _gather(self, deadline_s: float) -> Readings:
        """Read what has arrived by the deadline; raises where nothing does, or nothing that makes sense."""
        self._clock.sleep_until(deadline_s)
        data = self._arrived(self._outstanding_bytes())
        self._read_s = self._clock.now_s()
        readings = self._decoder.push(data)
        self._refuse_garbage(readings)
        return readings

    def _arrived(self, least: int) -> bytes:
        """At least one byte; what is due but on its way is waited for."""
        until_s = self._clock.now_s() + self._io_timeout_s
        data = self._io(lambda stream: stream.read(least, _ON_THE_WAY_S))
        while not data:
            now_s = self._clock.now_s()
            if now_s >= until_s:
                raise InstrumentTimeoutError(
                    f"{self.who}: nothing has arrived for {self._io_timeout_s:g} s;"
                    " is the unit powered, and does it send on its own?"
                )
            self._clock.sleep_until(min(now_s + _LOOK_AGAIN_S, until_s))
            data = self._io(lambda stream: stream.read(1, _ON_THE_WAY_S))
        return data

    def _outstanding_bytes(self) -> int:
        if not self._following:
            return 0
        outstanding = self._timeline.outstanding(self._clock.now_s())
        return int(outstanding * self._decoder.reading_bytes) - self._decoder.waiting()

    def _refuse_garbage(self, readings: Readings) -> None:
        if len(readings):
            self._reading_s = self._read_s
        elif self._read_s - self._reading_s > max(_GARBAGE_S, 4 * self._rhythm.period_s):
            raise InstrumentProtocolError(f"{self.who}: {self._decoder.complaint()}")

    def _take(self, readings: Readings) -> None:
        """Number the readings and make samples of them."""
        if not len(readings):
            return
        numbers = self._timeline.numbers(readings)
        if self._timeline.hidden(int(numbers[-1]), self._read_s):
            readings, numbers = self._looked_again(readings)
        self._timeline.accept(readings, numbers, self._read_s)
        self._blocks += self._sampler.push(readings, numbers)

    def _looked_again(self, readings: Readings) -> tuple[Readings, NDArray[np.int64]]:
        """Readings that come too late are lost ones, or held up: what is lost never comes, so wait a moment."""
        parts, place, hidden = [readings], 0, sys.maxsize
        for _ in range(_LOOKS):
            before_s = self._read_s
            parts.append(self._gather(self._read_s + _LOOK_AGAIN_S))
            if len(parts[-1]) * self._rhythm.period_s < _FLOWING * (self._read_s - before_s):
                place = sum(len(part) for part in parts[:-1])
            readings = joined(parts)
            numbers = self._timeline.numbers(readings)
            hidden = min(hidden, self._timeline.hidden(int(numbers[-1]), self._read_s))
            if not hidden:
                return readings, numbers
        # Where the counter shows a loss, this is that one. Else it is where the stream paused, if it did.
        jumps = np.flatnonzero(np.diff(numbers) > 1)
        place = int(jumps[0]) + 1 if len(jumps) else place
        numbers[place:] += hidden
        return readings, numbers

    def _refuse_other_rate(self, readings: Readings, heard_hz: float) -> None:
        """Hold the counter's steps, or else the clock, against the rate that the station says."""
        counter = self._rhythm.counter
        if counter is not None and readings.counter is not None:
            ticks = np.diff(readings.counter) % counter.modulus
            step = int(np.median(ticks)) if len(ticks) else counter.step
            agrees, found_hz = step == counter.step, self._rhythm.rate_hz * counter.step / max(step, 1)
        else:
            agrees = abs(heard_hz / self._rhythm.rate_hz - 1.0) <= _RATE_TOLERANCE
            found_hz = heard_hz
        if not agrees:
            raise InstrumentError(
                f"{self.who}: sends {found_hz:.4g} samples a second, the station says"
                f" {self._rhythm.rate_hz:g}; correct sample_rate or set the unit"
            )

    def _io(self, act: Callable[[ByteStream], _T]) -> _T:
        if self._stream is None:
            raise InstrumentError(f"{self.who}: not open; open the instrument first")
        try:
            return act(self._stream)
        except OSError as error:
            raise InstrumentError(
                f"{self.who}: connection lost: {error}; is the cable plugged in and the adapter there?"
            ) from error


def many(count: int, noun: str) -> str:
    """A count and its noun."""
    return f"{count} {noun}{'' if count == 1 else 's'}"
