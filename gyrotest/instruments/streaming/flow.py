"""An acquisition from a gyro that talks unasked: what arrives is read in blocks and put on the grid."""

import math
import sys
from collections import deque
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gyrotest.errors import InstrumentError
from gyrotest.instruments.streaming.intake import Intake
from gyrotest.instruments.streaming.readings import Counter, Decoder, Readings, joined
from gyrotest.instruments.streaming.samples import Sampler
from gyrotest.instruments.streaming.timeline import Timeline
from gyrotest.ports import Clock
from gyrotest.records.recording import Block, SampleFlag

# What is read at once: about a second of it, but well below what a pseudo-terminal or a driver holds.
_BLOCK_S = 1.0
_BLOCK_BYTES = 8192
_FEWEST = 4
# When readings seem to be lost, they may be late: look again, this long and this often.
_LOOK_AGAIN_S = 0.05
_LOOKS = 6
# With fewer than this share of what should have come meanwhile, the stream paused.
_FLOWING = 0.5
_START_UP_S = 10.0
_LISTEN_S = 1.0
_LISTEN_READINGS = 10
_RATE_TOLERANCE = 0.2
_MOMENT_S = 0.1


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
        self.intake = Intake(
            who, decoder, clock=clock, io_timeout_s=io_timeout_s, period_s=rhythm.period_s
        )
        self._timeline = Timeline(who, rhythm.period_s, rhythm.counter)
        self._sampler = Sampler(1, rhythm.period_s)
        self._size = 1
        self._end = 0
        self._blocks: deque[Block] = deque()
        most_s = _BLOCK_BYTES / decoder.reading_bytes * rhythm.period_s
        self._block_s = max(min(_BLOCK_S, most_s), _FEWEST * rhythm.period_s)

    def listen(self) -> None:
        """See that readings come, and as often as they should; raises `InstrumentError`."""
        intake = self.intake
        intake.restart()
        intake.some(self._block_s / 4)
        heard, count = [intake.some(self._block_s / 4)], 0
        since_s = intake.read_s
        while intake.read_s - since_s < max(_LISTEN_S, _LISTEN_READINGS * self._rhythm.period_s):
            heard.append(intake.some(self._block_s))
            count += len(heard[-1])
        self._refuse_other_rate(joined(heard), count / (intake.read_s - since_s))

    def configure(self, size: int, interval_s: float) -> None:
        """Average so many readings to a sample from the next start on, and count losses anew."""
        self._size = size
        self._sampler = Sampler(size, interval_s)
        self._decoder.forget()

    def start(self, first: int, count: int) -> None:
        """Begin; the first reading that is no start-up is number 0, after an interruption the grid stays."""
        self.intake.restart()
        self._blocks.clear()
        readings = self._started()
        self._sampler.begin(first, count)
        self._end = count
        read_s = self.intake.read_s
        if first == 0 or not self._timeline.begun:
            self._timeline.begin(read_s - (len(readings) - 1) * self._rhythm.period_s)
        else:
            self._timeline.resume(readings, read_s)
        self._take(readings)

    def fetch(self) -> Block | None:
        """Wait for the next samples; None after the last."""
        while not self._blocks and self._sampler.position < self._end:
            self._take(self.intake.by(self._next_read_s(), self._timeline.outstanding))
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

    def _started(self) -> Readings:
        """The first readings that are no start-up ones."""
        until_s = self._clock.now_s() + _START_UP_S
        while True:
            readings = self.intake.some(self._block_s / 4)
            ready = np.flatnonzero((readings.flags & SampleFlag.START_UP) == 0)
            if len(ready):
                return readings.part(slice(int(ready[0]), None)).as_first()
            if self.intake.read_s > until_s:
                raise InstrumentError(
                    f"{self.who}: has been starting up for {_START_UP_S:g} s and goes on; is the unit damaged?"
                )

    def _next_read_s(self) -> float:
        """A block on; not beyond the last sample that is wanted, nor long before the next one is complete."""
        last_s, read_s = self._timeline.due_s(self._end * self._size), self.intake.read_s
        return max(min(read_s + self._block_s, last_s), read_s + self._rhythm.period_s)

    def _take(self, readings: Readings) -> None:
        """Number the readings and make samples of them."""
        if not len(readings):
            return
        numbers = self._timeline.numbers(readings)
        if self._timeline.hidden(int(numbers[-1]), self.intake.read_s):
            readings, numbers = self._looked_again(readings)
        self._timeline.accept(readings, numbers, self.intake.read_s)
        self._blocks += self._sampler.push(readings, numbers)

    def _looked_again(self, readings: Readings) -> tuple[Readings, NDArray[np.int64]]:
        """Readings that come too late are lost ones, or held up: what is lost never comes, so wait a moment."""
        parts, place, hidden = [readings], 0, sys.maxsize
        for _ in range(_LOOKS):
            before_s = self.intake.read_s
            parts.append(self.intake.by(before_s + _LOOK_AGAIN_S))
            meanwhile_s = self.intake.read_s - before_s
            if len(parts[-1]) * self._rhythm.period_s < _FLOWING * meanwhile_s:
                place = sum(len(part) for part in parts[:-1])
            readings = joined(parts)
            numbers = self._timeline.numbers(readings)
            hidden = min(hidden, self._timeline.hidden(int(numbers[-1]), self.intake.read_s))
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


def many(count: int, noun: str) -> str:
    """A count and its noun."""
    return f"{count} {noun}{'' if count == 1 else 's'}"
