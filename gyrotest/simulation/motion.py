"""How what carries a unit moves: its true angle and rate at closely spaced knots, and its angle between them."""

import math
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from gyrotest.simulation.peer import Turning

_SETTLED_S = 0.5
# A rate table's motion is slow.
_CARRIED_HZ = 500.0
KEPT = 8
"""So many knots before the last ones are kept: a channel may be sampled a little early."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Knots:
    """Angle, °, and rate, °/s, at consecutive knots, (n,); between two of them the rate goes straight."""

    angle_deg: NDArray[np.float64]
    rate_dps: NDArray[np.float64]


class Motion(Protocol):
    """A motion that is asked for its knots in the order of time.

    Each rate is that of `late_s` before its knot. `settling_s` is how long what was before still shows.
    """

    @property
    def late_s(self) -> float:
        """How much earlier than their knots the rates are."""

    @property
    def settling_s(self) -> float:
        """So long a motion goes on after what drives it."""

    def knots_hz(self, *, damped: bool) -> float:
        """How many knots a second it needs at least, where all that follow it are damped or not."""

    def begin(self, first: int, *, origin_s: float, interval_s: float) -> None:
        """Knots from the time `origin_s + first · interval_s` on come next."""

    def take(self, count: int) -> Knots:
        """The next knots; they lie in the past."""


class Resting:
    """Nothing moves."""

    late_s = 0.0
    settling_s = _SETTLED_S

    def knots_hz(self, *, damped: bool) -> float:  # noqa: ARG002 - nothing to follow
        """As many as there are samples."""
        return 0.0

    def begin(self, first: int, *, origin_s: float, interval_s: float) -> None:
        """Nothing to prepare."""

    def take(self, count: int) -> Knots:
        """The next knots."""
        nothing = np.zeros(count)
        return Knots(angle_deg=nothing, rate_dps=nothing)


class Carried:
    """A rate table's motion: its rates are means over the interval that ends with the knot."""

    settling_s = _SETTLED_S

    def __init__(self, table: Turning) -> None:
        self._table = table
        self._origin_s, self._interval_s, self._next = 0.0, 1.0, 0
        self._before_deg = 0.0

    @property
    def late_s(self) -> float:
        """Half an interval."""
        return 0.5 * self._interval_s

    def knots_hz(self, *, damped: bool) -> float:  # noqa: ARG002 - slow in either case
        """Few: the angle itself is exact at each."""
        return _CARRIED_HZ

    def begin(self, first: int, *, origin_s: float, interval_s: float) -> None:
        """Knots from the time `origin_s + first · interval_s` on come next."""
        self._origin_s, self._interval_s, self._next = origin_s, interval_s, first
        self._before_deg = float(self._angles_deg(first - 1, 1)[0])

    def take(self, count: int) -> Knots:
        """The next knots."""
        angles_deg = self._angles_deg(self._next, count)
        rates_dps = np.diff(angles_deg, prepend=self._before_deg) / self._interval_s
        self._next += count
        self._before_deg = float(angles_deg[-1])
        return Knots(angle_deg=angles_deg, rate_dps=rates_dps)

    def _angles_deg(self, first: int, count: int) -> NDArray[np.float64]:
        knots = np.arange(first, first + count, dtype=np.float64)
        return self._table.angle_deg(self._origin_s + self._interval_s * knots)


class Kept:
    """Values at consecutive knots, of which the last ones are kept."""

    def __init__(self, first: int, kept: int = KEPT) -> None:
        self._first = first
        self._kept = kept
        self._values: NDArray[np.float64] = np.empty(0)

    def extend(self, values: NDArray[np.float64]) -> None:
        """Take the next ones, and forget all but a few of those before."""
        forgotten = max(0, self._values.size - self._kept)
        self._first += forgotten
        self._values = np.concatenate([self._values[forgotten:], values])

    def every(self, step: int, knot: int, count: int) -> NDArray[np.float64]:
        """`count` values, at every `step`-th knot from this one on, (count,); a view."""
        place = knot - self._first
        if place < 0 or place + (count - 1) * step >= self._values.size:
            last = self._first + self._values.size - 1
            raise ValueError(f"knots {self._first} to {last} are known, {knot} and on are asked for")
        return self._values[place : place + (count - 1) * step + 1 : step]


class Path:
    """The last knots of a motion, from which the angle at any instant among them follows exactly."""

    def __init__(self, first: int, interval_s: float) -> None:
        self._interval_s = interval_s
        self._angle_deg = Kept(first)
        self._rate_dps = Kept(first)

    def extend(self, knots: Knots) -> None:
        """Take the next knots."""
        self._angle_deg.extend(knots.angle_deg)
        self._rate_dps.extend(knots.rate_dps)

    def angles_deg(self, knot: int, count: int, *, step: int, shift_s: float) -> NDArray[np.float64]:
        """The angles at `count` instants, `shift_s` after every `step`-th knot from this one on, (count,)."""
        whole = math.floor(shift_s / self._interval_s)
        share = shift_s / self._interval_s - whole
        here_deg = self._angle_deg.every(step, knot + whole, count)
        if share == 0.0:
            return here_deg
        there_deg = self._angle_deg.every(step, knot + whole + 1, count)
        rise_dps = self._rate_dps.every(step, knot + whole + 1, count) - self._rate_dps.every(
            step, knot + whole, count
        )
        # The rate goes straight, so the angle is a parabola: its chord, less what it sags below that.
        sag_s = 0.5 * share * (1.0 - share) * self._interval_s
        return np.asarray(here_deg + share * (there_deg - here_deg) - sag_s * rise_dps)
