"""At which position of the grid a reading belongs: its counter and the host's clock together.

The counter says exactly how many readings were lost, but only up to its period: a loss of a whole period
looks like none. The host's clock sees that one, for readings then come later by the period than they
should, for ever. A reading can arrive late, by the jitter of the host and of a USB adapter, but never
early: so what counts is the least lateness of the last while. It is followed slowly, for the clock of
the gyro is not the host's.

Without a counter the host's clock is all there is: a loss shorter than `LEAST_LATE_S` is not found
(unless the decoder saw a reading break), and the length of a longer one is known to one reading.
"""

import math

import numpy as np
from numpy.typing import NDArray

from gyrotest.errors import InstrumentProtocolError
from gyrotest.instruments.streaming.readings import Counter, Readings

# How much earlier than ever before a reading may seem to be: the clocks drift apart in the meantime.
_EARLY_S = 0.025
# A loss that only the host's clock shows must be longer than the jitter that it is not to be taken for.
LEAST_LATE_S = 0.1
# The least lateness is that of the last one to two of these. In one of them, clocks that differ by
# 200 ppm move apart by 6 ms, which is less than the tolerance.
_WHILE_S = 30.0


class Lateness:
    """The least lateness of the last while."""

    def __init__(self) -> None:
        self._before_s = self._now_s = math.inf
        self._since_s = -math.inf

    @property
    def least_s(self) -> float:
        """The least one, s; infinite as long as none is known."""
        return min(self._before_s, self._now_s)

    def add(self, lateness_s: float, now_s: float) -> None:
        """Take one more."""
        if now_s - self._since_s > _WHILE_S:
            self._before_s, self._now_s, self._since_s = self._now_s, math.inf, now_s
        self._now_s = min(self._now_s, lateness_s)


class Timeline:
    """Numbers the readings of one gyro, lost ones included, from the first one on."""

    def __init__(self, who: str, period_s: float, counter: Counter | None) -> None:
        self._who, self._period_s, self._counter = who, period_s, counter
        self.begin(0.0)

    def begin(self, now_s: float) -> None:
        """The next reading is number 0."""
        self._zero_s = now_s
        self._lateness = Lateness()
        self._last = -1
        self._count: int | None = None

    @property
    def begun(self) -> bool:
        """Whether there was a reading."""
        return self._last >= 0

    def due_s(self, number: int) -> float:
        """When a reading arrives at the earliest, on the host's clock."""
        least_s = self._lateness.least_s
        return self._zero_s + number * self._period_s + (least_s if math.isfinite(least_s) else 0.0)

    def outstanding(self, now_s: float) -> int:
        """Readings that should have arrived since the last one."""
        return max(0, math.floor((now_s - self.due_s(self._last)) / self._period_s - 0.5))

    def numbers(self, readings: Readings) -> NDArray[np.int64]:
        """Number readings as far as counter and decoder tell; nothing is kept.

        Raises `InstrumentProtocolError` where the counter takes steps that it should not take.
        """
        if self._counter is None or readings.counter is None:
            return self._last + np.cumsum(1 + readings.lost)
        return self._last + np.cumsum(self._steps(self._counter, readings.counter, self._count))

    def hidden(self, last: int, now_s: float) -> int:
        """Readings that are lost beside those seen, if `last` is the last one that has arrived by now."""
        if not self.begun:
            return 0
        late_s = now_s - self.due_s(last)
        if self._counter is not None:
            period = self._counter.period
            return max(0, math.floor((late_s + _EARLY_S) / (period * self._period_s))) * period
        if late_s < max(LEAST_LATE_S, 1.5 * self._period_s):
            return 0
        return math.floor(late_s / self._period_s + 0.25)

    def accept(self, readings: Readings, numbers: NDArray[np.int64], now_s: float) -> None:
        """Go on from these readings, which are numbered for good."""
        self._last = int(numbers[-1])
        if readings.counter is not None:
            self._count = int(readings.counter[-1])
        self._lateness.add(now_s - self._zero_s - self._last * self._period_s, now_s)

    def resume(self, readings: Readings, now_s: float) -> None:
        """Before readings after an interruption: where they belong is told by the clock, then the counter."""
        behind = int(self._relative(readings)[-1])
        first = round((now_s - self.due_s(0)) / self._period_s) - behind
        if self._counter is not None and readings.counter is not None and self._count is not None:
            steps = (int(readings.counter[0]) - self._count) % self._counter.modulus
            if steps % self._counter.step == 0:
                exact, period = self._last + steps // self._counter.step, self._counter.period
                early = _EARLY_S / self._period_s
                first = exact + period * math.floor((first - exact + early) / period)
            self._count = (int(readings.counter[0]) - self._counter.step) % self._counter.modulus
        self._last = first - 1

    def _relative(self, readings: Readings) -> NDArray[np.int64]:
        if self._counter is None or readings.counter is None:
            return np.cumsum(1 + readings.lost) - 1
        return np.cumsum(self._steps(self._counter, readings.counter, None)) - 1

    def _steps(
        self, counter: Counter, counts: NDArray[np.int64], before: int | None
    ) -> NDArray[np.int64]:
        """How many readings on each one is from the one before; the very first is one on."""
        start = int(counts[0]) - counter.step if before is None else before
        ticks = np.diff(counts, prepend=start) % counter.modulus
        if (ticks % counter.step).any():
            wrong = int(ticks[np.flatnonzero(ticks % counter.step)[0]])
            raise InstrumentProtocolError(
                f"{self._who}: its counter went on by {wrong}, expected multiples of {counter.step};"
                " was the unit reset or its power interrupted?"
            )
        steps: NDArray[np.int64] = np.where(ticks == 0, counter.modulus, ticks) // counter.step
        return steps
