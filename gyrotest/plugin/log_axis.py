"""A logarithmic axis in a number of dots: where a value lies, and which values to write at it."""

import math
from collections.abc import Iterator
from dataclasses import dataclass

_STEPS = (1.0, 2.0, 5.0)


@dataclass(frozen=True, slots=True, kw_only=True)
class LogAxis:
    """From `low` at position 0 to `high` at position 1."""

    low: float
    high: float

    def position(self, value: float) -> float:
        """Return where a value lies, 0 … 1 within the axis."""
        return math.log(value / self.low) / math.log(self.high / self.low)

    def marks(self) -> Iterator[float]:
        """Yield the round values on the axis, whole decades first."""
        for step in _STEPS:
            for power in range(math.floor(math.log10(self.low)), math.ceil(math.log10(self.high)) + 1):
                value = step * 10.0**power
                if self.low * 0.999 <= value <= self.high * 1.001:
                    yield value


def round_axis(low: float, high: float) -> LogAxis:
    """Return an axis from a round value to a round value, a decade or more, that holds both."""
    top = _round_up(high)
    bottom = 1.0 / _round_up(1.0 / low)
    return LogAxis(low=min(bottom, top / 10.0), high=top)


def _round_up(value: float) -> float:
    decade = 10.0 ** math.floor(math.log10(value))
    return next((step * decade for step in _STEPS if step * decade >= value), 10.0 * decade)
