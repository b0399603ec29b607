"""What a rate table may do: rates and turns refused before a command is sent, and the turns counted."""

import math
from dataclasses import dataclass

from gyrotest.errors import InstrumentError
from gyrotest.ports import Clock
from gyrotest.records.station import Motion
from gyrotest.units import Dimension

_TURN_DEG = 360.0
# After a longer time an angle within one turn says too little of the rate.
_LONGEST_SPAN_S = 20.0
_SAME_TIME_S = 1e-6
# A stage that stood a hair below its zero still comes to the end of its turn: cables have that much play.
_PLAY_DEG = 1.0


def max_rate_dps(motion: Motion) -> float:
    """The station's greatest rate, °/s."""
    return motion.max_rate.to(Dimension.RATE)


def max_acceleration_dps2(motion: Motion) -> float:
    """The station's acceleration of run-up and run-down, °/s²."""
    return motion.max_acceleration.to(Dimension.RATE_RAMP)


def nearest_turn(angle_deg: float, *, near_deg: float) -> float:
    """The angle, which is known but for whole turns, where it comes nearest to another one, °."""
    return near_deg + math.remainder(angle_deg - near_deg, _TURN_DEG)


@dataclass(frozen=True, slots=True, kw_only=True)
class Ramp:
    """A change of rate at a constant acceleration, as it is demanded of a table.

    Begun at `start_s` from `angle_deg` and `from_dps`; the table goes on at `to_dps` afterwards.
    """

    start_s: float
    angle_deg: float
    from_dps: float
    to_dps: float
    acceleration_dps2: float

    def rate_dps(self, time_s: float) -> float:
        """The rate at a time, °/s."""
        change = self.acceleration_dps2 * max(0.0, time_s - self.start_s)
        whole = self.to_dps - self.from_dps
        return self.from_dps + math.copysign(min(change, abs(whole)), whole)

    def angle_at_deg(self, time_s: float) -> float:
        """The angle at a time, °."""
        elapsed_s = max(0.0, time_s - self.start_s)
        ramp_s = min(elapsed_s, abs(self.to_dps - self.from_dps) / self.acceleration_dps2)
        mean_dps = (self.from_dps + self.rate_dps(self.start_s + ramp_s)) / 2
        return self.angle_deg + mean_dps * ramp_s + self.to_dps * (elapsed_s - ramp_s)


class Envelope:
    """Keeps a table within the station's `motion`; counts its turns from where it stood first.

    Controllers give an angle within one turn: whole turns follow from what was demanded, and the
    count is put right by every angle that is read.
    """

    def __init__(self, who: str, motion: Motion) -> None:
        self.who = who
        self._motion = motion
        self._acceleration_dps2 = max_acceleration_dps2(motion)
        self._ramp: Ramp | None = None
        self._start_deg = 0.0

    @property
    def begun(self) -> bool:
        """Whether it is known where the table stood first."""
        return self._ramp is not None

    def begin(self, time_s: float, angle_deg: float) -> None:
        """Count turns from here; the table is at rest."""
        self._start_deg = angle_deg
        self._ramp = self._new_ramp(time_s, angle_deg, 0.0, 0.0)

    def refuse_rate(self, time_s: float, rate_dps: float) -> None:
        """Raise `InstrumentError` for a rate that the table, its cables or the unit do not stand."""
        most_dps = max_rate_dps(self._motion)
        if not abs(rate_dps) <= most_dps:
            raise InstrumentError(
                f"{self.who}: {rate_dps:g} deg/s is asked for, the station allows {most_dps:g} deg/s"
                " (motion.max_rate); nothing was sent; correct the case's rates or the station"
            )
        if rate_dps and not self._motion.slip_ring:
            turned_deg = self._demanded(time_s) - self._start_deg
            farthest_deg = self._farthest_deg(time_s, rate_dps)
            if self._motion.max_turns is None or abs(farthest_deg) > abs(turned_deg):
                self._refuse_turns(farthest_deg, f"{rate_dps:g} deg/s")

    def refuse_move(self, time_s: float, angle_deg: float) -> None:
        """Raise `InstrumentError` for an angle, reached by the shorter way, that winds the cables up."""
        if not self._motion.slip_ring:
            target_deg = nearest_turn(angle_deg, near_deg=self._demanded(time_s))
            self._refuse_turns(target_deg - self._start_deg, f"the angle {angle_deg:g} deg")

    def demanded(self, time_s: float, rate_dps: float) -> None:
        """A rate was sent."""
        ramp = self._laid_ramp()
        self._ramp = self._new_ramp(time_s, ramp.angle_at_deg(time_s), ramp.rate_dps(time_s), rate_dps)

    def moved(self, time_s: float, angle_deg: float) -> None:
        """An angle was sent: the table comes to rest there, by the shorter way."""
        target_deg = nearest_turn(angle_deg, near_deg=self._demanded(time_s))
        self._ramp = self._new_ramp(time_s, target_deg, 0.0, 0.0)

    def read(self, time_s: float, angle_deg: float) -> float:
        """An angle was read: put the count right; the angle with its whole turns, °.

        Raises `InstrumentError` beyond the turns that are allowed.
        """
        ramp = self._laid_ramp()
        there_deg = nearest_turn(angle_deg, near_deg=ramp.angle_at_deg(time_s))
        self._ramp = self._new_ramp(time_s, there_deg, ramp.rate_dps(time_s), ramp.to_dps)
        turned_deg = there_deg - self._start_deg
        if not self._motion.slip_ring and self._motion.max_turns is not None:
            self._refuse_wound_up(turned_deg, self._motion.max_turns)
        return there_deg

    def _refuse_wound_up(self, turned_deg: float, max_turns: float) -> None:
        if abs(turned_deg) > max_turns * _TURN_DEG + _PLAY_DEG:
            raise InstrumentError(
                f"{self.who}: it has turned by {turned_deg / _TURN_DEG:.2f} turns, the cables allow ±{max_turns:g}"
                " (motion.max_turns); it is stopped; see that the cables are whole, and turn it back by hand"
            )

    def _refuse_turns(self, turned_deg: float, asked: str) -> None:
        max_turns = self._motion.max_turns
        if max_turns is None:
            raise InstrumentError(
                f"{self.who}: {asked} is asked for, and the station states neither a slip ring nor how far the"
                " cables let the table turn; nothing was sent; give the instrument's motion 'slip_ring: true' or"
                " 'max_turns'"
            )
        if abs(turned_deg) > max_turns * _TURN_DEG + _PLAY_DEG:
            raise InstrumentError(
                f"{self.who}: {asked} would turn the table by {turned_deg / _TURN_DEG:.2f} turns from its start,"
                f" the cables allow ±{max_turns:g} (motion.max_turns); nothing was sent; order the rates"
                " alternately, shorten the dwells or use a slip ring"
            )

    def _farthest_deg(self, time_s: float, rate_dps: float) -> float:
        """How far from the start it comes at least: to the rate, and to rest again."""
        ramp = self._laid_ramp()
        now_dps = ramp.rate_dps(time_s)
        begun = self._new_ramp(time_s, ramp.angle_at_deg(time_s), now_dps, rate_dps)
        reached_s = time_s + abs(rate_dps - now_dps) / self._acceleration_dps2
        stopping_deg = rate_dps * abs(rate_dps) / (2 * self._acceleration_dps2)
        return begun.angle_at_deg(reached_s) + stopping_deg - self._start_deg

    def _demanded(self, time_s: float) -> float:
        return self._laid_ramp().angle_at_deg(time_s)

    def _laid_ramp(self) -> Ramp:
        if self._ramp is None:
            raise InstrumentError(f"{self.who}: not open; open the rate table first")
        return self._ramp

    def _new_ramp(self, time_s: float, angle_deg: float, from_dps: float, to_dps: float) -> Ramp:
        return Ramp(
            start_s=time_s,
            angle_deg=angle_deg,
            from_dps=from_dps,
            to_dps=to_dps,
            acceleration_dps2=self._acceleration_dps2,
        )


class Progress:
    """The mean rate between two positions, for controllers that read no rate back.

    They are `span_s` apart at least: the jitter of the line's and the computer's times, over the span,
    is the relative error of the rate.
    """

    def __init__(self, clock: Clock, span_s: float) -> None:
        self._clock = clock
        self._span_s = span_s
        self._demanded_dps: float | None = None
        self._earlier: tuple[float, float] | None = None
        self._latest: tuple[float, float] | None = None

    def begin(self, demanded_dps: float | None) -> None:
        """Another rate was asked for (None: an angle): positions from before count no more."""
        if demanded_dps is None or demanded_dps != self._demanded_dps:
            self._earlier = self._latest = None
        self._demanded_dps = demanded_dps

    def read(self, time_s: float, angle_deg: float) -> None:
        """A position was read; positions closer together than makes sense are one."""
        if self._latest is None or time_s - self._latest[0] >= self._span_s - _SAME_TIME_S:
            self._earlier, self._latest = self._latest, (time_s, angle_deg)

    def pause_s(self) -> float:
        """How long to wait until the next position makes a rate with the one before, s."""
        if self._latest is None:
            return self._span_s
        since_s = self._clock.now_s() - self._latest[0]
        left_s = self._span_s if since_s > self._span_s + _LONGEST_SPAN_S else self._span_s - since_s
        return left_s if left_s > _SAME_TIME_S else 0.0

    def rate_dps(self) -> float:
        """The mean rate between the last two positions, °/s; raises `InstrumentError` before the second."""
        if self._earlier is None or self._latest is None:
            raise InstrumentError("the rate follows from two positions, and only one was read")
        return (self._latest[1] - self._earlier[1]) / (self._latest[0] - self._earlier[0])
