"""A simulated rate table: how it turns, its own errors, its ripple, and its true angle at any time."""

import math
import threading
from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from gyrotest.ports import Clock
from gyrotest.simulation.occasion import Occasion
from gyrotest.simulation.streams import generator

_TURN_DEG = 360.0
# A profile has settled after so many time constants.
_SETTLED = 12.0
# Greatest rate and acceleration of the smooth move x³(10 − 15x + 6x²) of length and duration 1.
_MOVE_RATE = 1.875
_MOVE_ACCELERATION = 5.7736


@dataclass(frozen=True, slots=True, kw_only=True)
class TableParameters:
    """A simulated table: half-widths of its errors, what it can do, how it runs.

    `gain_error` is in proportion and common to all rates, `setting_error_dps` drawn anew for each rate
    that is set. `ripple` is the greatest deviation of the rate in proportion to it, `ripple_per_turn`
    times a turn.
    """

    gain_error: float = 0.0
    setting_error_dps: float = 0.0
    ripple: float = 0.0
    ripple_per_turn: int = 36
    settling_time_constant_s: float = 0.05
    max_rate_dps: float = 1000.0
    max_acceleration_dps2: float = 1000.0


@dataclass(frozen=True, slots=True, kw_only=True)
class TableFaults:
    """What goes wrong: how much of a rate is reached, when the interlock opens, whether commands are refused."""

    reaches: float = 1.0
    interlock_opens_s: float | None = None
    refuses: bool = False


@dataclass(frozen=True, slots=True, kw_only=True)
class TableErrors:
    """A table's drawn error: its gain."""

    gain: float = 0.0


class Segment(Protocol):
    """How the table turns from a time on, until the next one begins."""

    @property
    def start_s(self) -> float:
        """When it begins."""

    def angle_deg(self, elapsed_s: NDArray[np.float64]) -> NDArray[np.float64]:
        """The angle without ripple, ° (as the controller means it, and the table's own errors)."""

    def rate_dps(self, elapsed_s: float) -> float:
        """The rate that the controller means, °/s."""

    def error_dps(self, elapsed_s: float) -> float:
        """The setting's own error, °/s."""


@dataclass(frozen=True, slots=True, kw_only=True)
class RateSegment:
    """To a rate: as fast as the acceleration lets it, the last of it exponentially."""

    start_s: float
    begin_deg: float
    from_dps: float
    to_dps: float
    from_error_dps: float
    to_error_dps: float
    gain: float
    acceleration_dps2: float
    time_constant_s: float

    @property
    def _linear_s(self) -> float:
        """While it changes as fast as it may."""
        change_dps = abs(self.to_dps - self.from_dps)
        return max(0.0, change_dps / self.acceleration_dps2 - self.time_constant_s)

    @property
    def _left_dps(self) -> float:
        """What is left then, and dies away."""
        sign = math.copysign(self.acceleration_dps2, self.to_dps - self.from_dps)
        return self.to_dps - self.from_dps - sign * self._linear_s

    @property
    def settled_s(self) -> float:
        """When nothing is left."""
        return self.start_s + self._linear_s + _SETTLED * self.time_constant_s

    def angle_deg(self, elapsed_s: NDArray[np.float64]) -> NDArray[np.float64]:
        """The angle without ripple, (n,), °."""
        tau_s, linear_s = self.time_constant_s, self._linear_s
        slope = math.copysign(self.acceleration_dps2, self.to_dps - self.from_dps)
        ramp_s = np.minimum(elapsed_s, linear_s)
        then_s = np.maximum(elapsed_s - linear_s, 0.0)
        meant = self.from_dps * ramp_s + 0.5 * slope * ramp_s**2
        meant = meant + self.to_dps * then_s - self._left_dps * tau_s * -np.expm1(-then_s / tau_s)
        fading = (self.to_error_dps - self.from_error_dps) * tau_s * -np.expm1(-elapsed_s / tau_s)
        own = self.to_error_dps * elapsed_s - fading
        return np.asarray(self.begin_deg + (1.0 + self.gain) * meant + own, dtype=np.float64)

    def rate_dps(self, elapsed_s: float) -> float:
        """The rate that the controller means, °/s."""
        if elapsed_s < self._linear_s:
            slope = math.copysign(self.acceleration_dps2, self.to_dps - self.from_dps)
            return self.from_dps + slope * elapsed_s
        fading = math.exp(-(elapsed_s - self._linear_s) / self.time_constant_s)
        return self.to_dps - self._left_dps * fading

    def error_dps(self, elapsed_s: float) -> float:
        """The setting's own error, °/s."""
        fading = math.exp(-elapsed_s / self.time_constant_s)
        return self.to_error_dps + (self.from_error_dps - self.to_error_dps) * fading


@dataclass(frozen=True, slots=True, kw_only=True)
class MoveSegment:
    """From rest to an angle and to rest again."""

    start_s: float
    begin_deg: float
    distance_deg: float
    duration_s: float

    def angle_deg(self, elapsed_s: NDArray[np.float64]) -> NDArray[np.float64]:
        """The angle, (n,), °."""
        x = np.clip(elapsed_s / self.duration_s, 0.0, 1.0)
        return np.asarray(self.begin_deg + self.distance_deg * x**3 * (10 - 15 * x + 6 * x**2))

    def rate_dps(self, elapsed_s: float) -> float:
        """The rate, °/s."""
        x = min(max(elapsed_s / self.duration_s, 0.0), 1.0)
        return self.distance_deg / self.duration_s * 30 * x**2 * (1 - x) ** 2

    def error_dps(self, elapsed_s: float) -> float:  # noqa: ARG002 - a position is held without error
        """None: where it comes to rest is what the controller means."""
        return 0.0


class SimulatedTable:
    """One axis of a rate table on the bench; commanded by a controller's server, felt by the gyro.

    Its methods may be called from several threads. What it does is a function of the commands' times
    and of the seed, not of when it is asked.
    """

    def __init__(self, name: str, parameters: TableParameters, *, seed: int, clock: Clock) -> None:
        self.name = name
        self.parameters = parameters
        self._seed = seed
        self._clock = clock
        self._changed = threading.Condition(threading.RLock())
        self._own = generator(seed, "table settings", name)
        self.errors = TableErrors()
        self.faults = TableFaults()
        self.rate_limit_dps = parameters.max_rate_dps
        self.acceleration_limit_dps2 = parameters.max_acceleration_dps2
        self.tripped = False
        self.demanded_dps = 0.0
        self._began_deg = 0.0
        self._segments: list[Segment] = [self._standing(clock.now_s(), 0.0)]

    def begin(self, occasion: Occasion, faults: TableFaults | None = None) -> None:
        """Draw the table's errors for the next record; it goes on from where it stands."""
        with self._changed:
            now_s = self._clock.now_s()
            angle_deg, rate_dps = self._state(now_s)
            serial = occasion.serial_number
            spread = generator(self._seed, "table errors", serial, self.name).uniform(-1.0, 1.0)
            self._own = generator(self._seed, "table settings", self.name, *occasion.stream)
            self.errors = TableErrors(gain=self.parameters.gain_error * spread)
            self.faults = TableFaults() if faults is None else faults
            self.tripped = False
            # From here on the ripple counts: a record is the same whatever was turned before it.
            self._began_deg = angle_deg
            if rate_dps == 0.0:
                self._segments = [self._standing(now_s, angle_deg)]

    def set_rate(self, rate_dps: float) -> None:
        """Turn at a rate, reached as fast as the limits let it."""
        with self._changed:
            now_s = self._advanced()
            # Nothing is drawn for rest: how often that is asked for depends on what was before the record.
            drawn = self._own.uniform(-1.0, 1.0) if rate_dps else 0.0
            error_dps = self.parameters.setting_error_dps * drawn
            self._turn_to(now_s, rate_dps * self.faults.reaches, error_dps=error_dps)
            self.demanded_dps = rate_dps
            self._changed.notify_all()

    def move_to(self, angle_deg: float) -> None:
        """Come to rest at an angle, by the shorter way."""
        with self._changed:
            now_s = self._advanced()
            rest = self._turn_to(now_s, 0.0, error_dps=0.0)
            start_s = now_s if rest is None else rest.settled_s
            begin_deg = self._smooth_deg(start_s)
            distance_deg = math.remainder(angle_deg - begin_deg, _TURN_DEG)
            self._segments.append(
                MoveSegment(
                    start_s=start_s,
                    begin_deg=begin_deg,
                    distance_deg=distance_deg,
                    duration_s=self._move_s(abs(distance_deg)),
                )
            )
            self.demanded_dps = 0.0
            self._changed.notify_all()

    def angle_deg(self, times_s: NDArray[np.float64]) -> NDArray[np.float64]:
        """The true angle at times of the bench's clock that are not in the future, (n,), °, turns counted."""
        with self._changed:
            self._advanced()
            smooth = self._smooth(np.atleast_1d(np.asarray(times_s, dtype=np.float64)))
        cycles = self.parameters.ripple_per_turn
        # The rate's deviation is the ripple times cos: the angle's follows by integration over the angle.
        phase = np.sin(cycles * np.radians(smooth - self._began_deg))
        deviation = np.degrees(phase) * self.parameters.ripple / cycles
        return np.asarray(smooth + deviation, dtype=np.float64)

    def read_rate_dps(self) -> float:
        """The rate that the controller reads: its own measure of it, without the table's true errors."""
        with self._changed:
            now_s = self._advanced()
            rate_dps = self._at(now_s).rate_dps(now_s - self._at(now_s).start_s)
            turned_deg = self._smooth_deg(now_s) - self._began_deg
            phase = self.parameters.ripple_per_turn * math.radians(turned_deg)
            return rate_dps * (1.0 + self.parameters.ripple * math.cos(phase))

    def read_angle_deg(self) -> float:
        """The angle that the controller reads, 0 … 360°."""
        with self._changed:
            return float(self.angle_deg(np.array([self._clock.now_s()]))[0]) % _TURN_DEG

    def interlock_open(self) -> bool:
        """Whether the interlock has opened; the table comes to rest by itself then."""
        with self._changed:
            self._advanced()
            return self.tripped

    def wait_until(self, fact: Callable[[], bool], timeout_s: float) -> bool:
        """Wait in real time until a command has made something true; whether it has."""
        with self._changed:
            return self._changed.wait_for(fact, timeout_s)

    def truth(self) -> dict[str, float]:
        """The drawn error, for the record."""
        return {"table_gain_error": self.errors.gain}

    def _advanced(self) -> float:
        """Let happen what has become due; the time."""
        now_s = self._clock.now_s()
        opens_s = self.faults.interlock_opens_s
        if opens_s is not None and now_s >= opens_s and not self.tripped:
            self.tripped = True
            self._turn_to(opens_s, 0.0, error_dps=0.0)
            self.demanded_dps = 0.0
            self._changed.notify_all()
        return now_s

    def _turn_to(self, time_s: float, rate_dps: float, *, error_dps: float) -> RateSegment | None:
        """From a time on to a rate; None if it does not change anything."""
        self._segments = [one for one in self._segments if one.start_s <= time_s] or self._segments[:1]
        under_way = self._segments[-1]
        elapsed_s = max(0.0, time_s - under_way.start_s)
        now_dps, now_error_dps = under_way.rate_dps(elapsed_s), under_way.error_dps(elapsed_s)
        if now_dps == rate_dps and now_error_dps == error_dps:
            return None
        segment = RateSegment(
            start_s=time_s,
            begin_deg=self._smooth_deg(time_s),
            from_dps=now_dps,
            to_dps=rate_dps,
            from_error_dps=now_error_dps,
            to_error_dps=error_dps,
            gain=self.errors.gain,
            acceleration_dps2=min(self.acceleration_limit_dps2, self.parameters.max_acceleration_dps2),
            time_constant_s=self.parameters.settling_time_constant_s,
        )
        self._segments.append(segment)
        return segment

    def _move_s(self, distance_deg: float) -> float:
        rate_dps = min(self.rate_limit_dps, self.parameters.max_rate_dps)
        acceleration = min(self.acceleration_limit_dps2, self.parameters.max_acceleration_dps2)
        by_acceleration_s = math.sqrt(_MOVE_ACCELERATION * distance_deg / acceleration)
        return max(_MOVE_RATE * distance_deg / rate_dps, by_acceleration_s, 1e-3)

    def _state(self, now_s: float) -> tuple[float, float]:
        under_way = self._at(now_s)
        return self._smooth_deg(now_s), under_way.rate_dps(max(0.0, now_s - under_way.start_s))

    def _at(self, time_s: float) -> Segment:
        begun = [one for one in self._segments if one.start_s <= time_s]
        return begun[-1] if begun else self._segments[0]

    def _smooth_deg(self, time_s: float) -> float:
        return float(self._smooth(np.array([time_s]))[0])

    def _smooth(self, times_s: NDArray[np.float64]) -> NDArray[np.float64]:
        starts = np.array([one.start_s for one in self._segments])
        which = np.maximum(np.searchsorted(starts, times_s, side="right") - 1, 0)
        angles = np.empty_like(times_s)
        for number in np.unique(which):
            segment, chosen = self._segments[number], which == number
            angles[chosen] = segment.angle_deg(np.maximum(times_s[chosen] - segment.start_s, 0.0))
        return angles

    def _standing(self, time_s: float, angle_deg: float) -> Segment:
        return MoveSegment(start_s=time_s, begin_deg=angle_deg, distance_deg=0.0, duration_s=1.0)
