"""When samples are due, and how many readings fit into the interval between two of them."""

import math
from dataclasses import dataclass

from gyrotest.ports import Clock

# A deadline that is hit to within this is not missed: times are sums of floats.
_SAME_TIME_S = 1e-9
_MARGIN = 0.02
_LEAST_MARGIN_S = 0.02
# From coming back after a fault to the start, on the host's side.
_MOMENT_S = 0.1


@dataclass(frozen=True, slots=True, kw_only=True)
class Readings:
    """One reading's times: integrating, all in all, on the way to the host; and of the query for all."""

    aperture_s: float
    reading_s: float
    transfer_s: float = 0.0
    query_s: float = 0.0

    def fitting(self, interval_s: float, most: int) -> int:
        """How many fit into an interval beside the margin; 0 if none does."""
        room_s = interval_s - margin_s(interval_s) - self.query_s + _SAME_TIME_S
        return max(0, min(most, math.floor(room_s / (self.reading_s + self.transfer_s))))

    def shortest_interval_s(self) -> float:
        """The shortest interval into which one reading fits."""
        one_s = self.reading_s + self.transfer_s + self.query_s
        return max(one_s + _LEAST_MARGIN_S, one_s / (1 - _MARGIN))


def margin_s(interval_s: float) -> float:
    """What is kept free in each interval for the transfer and for a host that wakes up late."""
    return max(_MARGIN * interval_s, _LEAST_MARGIN_S)


class Grid:
    """Absolute deadlines `start + k · interval` on a clock: no drift, whatever a sample takes."""

    def __init__(self, clock: Clock, interval_s: float) -> None:
        self._clock = clock
        self.interval_s = interval_s
        self.start_s: float | None = None

    def begin(self, first: int) -> None:
        """Lay the grid so that sample `first` is due now, unless it lies already and goes on."""
        if self.start_s is None or first == 0:
            self.start_s = self._clock.now_s() - first * self.interval_s

    def deadline_s(self, position: int) -> float:
        """When a sample is due, on the clock."""
        if self.start_s is None:
            raise RuntimeError("the grid has not begun")
        return self.start_s + position * self.interval_s

    def next_position(self) -> int:
        """The first position that is not due yet."""
        return self._position_after(0.0)

    def position_to_go_on(self) -> int:
        """The first position that can be met after a fault, a moment from now."""
        return self._position_after(_MOMENT_S)

    def _position_after(self, pause_s: float) -> int:
        if self.start_s is None:
            return 0
        elapsed = (self._clock.now_s() + pause_s - self.start_s) / self.interval_s
        return max(0, math.ceil(elapsed - _SAME_TIME_S))
