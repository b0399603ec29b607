"""What strikes the frames of a digital gyro on their way, and its status, during one record."""

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from gyrotest.simulation.housed import Housed
from gyrotest.simulation.scenarios import Misbehaviour, Scenario, Strike
from gyrotest.simulation.streams import generator

_LOST_AT_ONCE = 7
_LOST_PERIODS = 3
_EVERY_DAMAGED = 3
_NOISE_EVERY = 10
_MOST_NOISE = 40
# Of what is sent at another baud rate so many bytes arrive, and none as it was sent.
_SHARE_AT_OTHER_RATE = 0.4

# Bits of the status byte, with that of the first axis. What leaves a meter's range leaves a unit's own.
_STATUS = {
    Misbehaviour.OVERLOAD_STATUS: 0x11,
    Misbehaviour.RAIL: 0x11,
    Misbehaviour.CHANNEL_ERROR: 0x09,
}
_OF_LINES = {
    *_STATUS,
    Misbehaviour.LOST_FRAMES,
    Misbehaviour.LOST_COUNTER_PERIOD,
    Misbehaviour.BAD_CRC,
    Misbehaviour.LINE_NOISE,
    Misbehaviour.UNPLUGGED,
}


class LineFaults:
    """The strikes of a scenario on one record of a gyro whose frame counter repeats after `period` frames."""

    def __init__(self, scenario: Scenario, housed: Housed, *, seed: int, period: int) -> None:
        occasion = housed.occasion
        self._strikes = tuple(one for one in scenario.strikes if one.misbehaviour in _OF_LINES)
        self._begun_s, self._duration_s = housed.begun_s, occasion.duration_s
        self._random = generator(seed, "line", *occasion.stream)
        self._period = period
        self._lost_until: dict[Strike, int] = {}
        self._garbled = scenario.has(Misbehaviour.WRONG_BAUD_RATE)
        recorded = occasion.duration_s > 0.0
        self._first_s = (
            min((self._at_s(one) for one in self._strikes), default=math.inf) if recorded else math.inf
        )

    def _at_s(self, strike: Strike) -> float:
        return self._begun_s + strike.at * self._duration_s

    def _during(self, misbehaviour: Misbehaviour, time_s: NDArray[np.float64]) -> NDArray[np.bool_]:
        found = np.zeros(time_s.shape, dtype=np.bool_)
        for strike in self._strikes:
            if strike.misbehaviour is misbehaviour:
                until_s = self._begun_s + strike.until * self._duration_s
                found |= (time_s >= self._at_s(strike)) & (time_s < until_s)
        return found

    def unplugged(self, now_s: float) -> bool:
        """Whether the line is gone by now."""
        return now_s >= self._first_s and any(
            strike.misbehaviour is Misbehaviour.UNPLUGGED and now_s >= self._at_s(strike)
            for strike in self._strikes
        )

    def status(self, time_s: NDArray[np.float64]) -> NDArray[np.uint8]:
        """Bits of the status byte that are set beside the unit's own, (n,)."""
        bits = np.zeros(time_s.shape, dtype=np.uint8)
        if time_s[-1] >= self._first_s:
            for misbehaviour, bit in _STATUS.items():
                bits[self._during(misbehaviour, time_s)] |= np.uint8(bit)
        return bits

    def strike(self, frames: Sequence[bytes], time_s: NDArray[np.float64]) -> bytes:
        """What arrives of frames that end at these times."""
        damaged = self._during(Misbehaviour.BAD_CRC, time_s)
        noisy = self._during(Misbehaviour.LINE_NOISE, time_s)
        arrived = []
        for place in np.flatnonzero(~self._lost(time_s)).tolist():
            frame = frames[place]
            if damaged[place] and place % _EVERY_DAMAGED == 0:
                frame = self._damaged(frame)
            if noisy[place] and place % _NOISE_EVERY == 0:
                frame += self._random.bytes(int(self._random.integers(1, _MOST_NOISE)))
            arrived.append(frame)
        return b"".join(arrived)

    def touches(self, time_s: NDArray[np.float64]) -> bool:
        """Whether anything may happen to frames that end at these times."""
        return bool(time_s[-1] >= self._first_s) and not self._garbled

    def garbled(self, data: bytes) -> bytes:
        """What a receiver at another baud rate makes of bytes; the bytes themselves where it has the same."""
        if not self._garbled:
            return data
        return bytes(self._random.bytes(math.ceil(_SHARE_AT_OTHER_RATE * len(data))))

    def _damaged(self, frame: bytes) -> bytes:
        place = int(self._random.integers(1, len(frame)))
        return frame[:place] + bytes([frame[place] ^ 0x5A]) + frame[place + 1 :]

    def _lost(self, time_s: NDArray[np.float64]) -> NDArray[np.bool_]:
        lost = np.zeros(time_s.shape, dtype=np.bool_)
        for strike in self._strikes:
            count = {
                Misbehaviour.LOST_FRAMES: _LOST_AT_ONCE,
                Misbehaviour.LOST_COUNTER_PERIOD: _LOST_PERIODS * self._period,
            }.get(strike.misbehaviour)
            if count is None:
                continue
            left = self._lost_until.get(strike, count)
            if left and time_s[-1] >= self._at_s(strike):
                first = int(np.searchsorted(time_s, self._at_s(strike))) if left == count else 0
                taken = min(left, time_s.size - first)
                lost[first : first + taken] = True
                self._lost_until[strike] = left - taken
        return lost
