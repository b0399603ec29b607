"""A rotation stage in an acquisition: a turn from 0° to 360° and back, or angles held; never beyond these."""

from dataclasses import dataclass

from gyrotest.acquisition.deadline import Deadline
from gyrotest.acquisition.pointing import HAIR_DEG, Angles
from gyrotest.acquisition.rotation_limits import (
    LATENCY_S,
    SETTLE_S,
    TURN_DEG,
    least_run_up_deg,
    stopping_deg,
)
from gyrotest.acquisition.stimulation import ReadBack
from gyrotest.acquisition.turning import TableDrive, time_limit_s
from gyrotest.errors import InstrumentError
from gyrotest.ports import Clock, RateTable
from gyrotest.records.plan import Pointing, Rotating
from gyrotest.records.station import Motion
from gyrotest.units import Dimension

_POLL_S = 0.1
_WATCH_S = 0.5
# It comes nearer for ever if it is waited for by what is left alone.
_LEAST_S = 1e-3


@dataclass(frozen=True, slots=True, kw_only=True)
class _Seen:
    """Where the stage was seen at a time: how far along its way it was."""

    time_s: float
    along_deg: float


class StageDrive:
    """Turns a rotation stage within one turn, and holds it at angles.

    Where it stands when it is switched on first is taken as an angle between 0° and 360°: it goes back
    from there to 0 by that way, and so it does after every plan. `turning` is for the steps that turn it
    like any rate table. A thread stops it in time where the source keeps everybody waiting.
    """

    def __init__(
        self, table: RateTable, *, clock: Clock, motion: Motion, name: str = "rotation stage"
    ) -> None:
        self._angles = Angles(table, clock=clock, motion=motion, name=name)
        self.turning = TableDrive(
            table, clock=clock, motion=motion, name=name, go_home=self._angles.go_home
        )
        self._table = table
        self._clock = clock
        self._name = name
        self._acceleration_dps2 = motion.max_acceleration.to(Dimension.RATE_RAMP)
        self._now: Rotating | Pointing | None = None
        self._seen = _Seen(time_s=0.0, along_deg=0.0)
        self._read: list[float] = []
        self._reading_s = 0.0
        self._end = Deadline(clock, self._stop, name=f"end of {name}")

    def reach(self, stimulus: Rotating | Pointing, *, sampled_s: float) -> None:
        """Return when the first sample may be taken, of `sampled_s`; raises `InstrumentError`."""
        self._now, self._read = stimulus, []
        self.turning.switch_on()
        if isinstance(stimulus, Pointing):
            self._point(stimulus)
        else:
            self._rotate(stimulus, sampled_s)

    def watch(self) -> None:
        """See that it turns, or stands, as it shall; raises `InstrumentError`, stopped, where not."""
        self.allow_pause(0.0)
        if self._clock.now_s() - self._seen.time_s < _WATCH_S:
            return
        if isinstance(self._now, Rotating):
            self._look_on_the_way(self._now)
        elif isinstance(self._now, Pointing):
            self._look_at_rest(self._now)

    def allow_pause(self, pause_s: float) -> None:
        """See that it can be left alone for so long; raises `InstrumentError`, stopped, where not."""
        if not isinstance(self._now, Rotating):
            return
        latest_s = self._latest_stop_s(self._now)
        if self._end.reached or self._clock.now_s() + pause_s >= latest_s:
            self._halt()
            raise InstrumentError(self._too_far(self._now))

    def leave(self) -> None:
        """The last sample is taken: stop at once; raises `InstrumentError` where that was too late."""
        if not isinstance(self._now, Rotating):
            return
        rotating = self._now
        was_stopped = self._end.call_off()
        with self._angles.talking:
            self._table.set_rate(0.0)
        if was_stopped:
            raise InstrumentError(self._too_far(rotating))
        self._angles.come_to_rest()
        beyond_deg = self._look(rotating).along_deg - TURN_DEG
        if beyond_deg > HAIR_DEG:
            raise InstrumentError(
                f"{self._name}: came to rest {beyond_deg:.2f}° beyond the end of its turn, after"
                f" {rotating.run_up_deg:g}° in which to stop; see that the cables are whole, and look at"
                " motion.max_acceleration"
            )

    def read_back(self) -> ReadBack:
        """What the step asked for, and the mean of what was read back meanwhile."""
        mean = sum(self._read) / len(self._read) if self._read else None
        if isinstance(self._now, Rotating):
            return ReadBack(demanded_rate_dps=self._now.rate_dps, rate_dps=mean)
        if isinstance(self._now, Pointing):
            return ReadBack(demanded_position_deg=self._now.position_deg, position_deg=mean)
        return ReadBack()

    def rest(self) -> None:
        """Bring it to rest, and back to 0 unless an error is being dealt with; never raises."""
        self._end.call_off()
        self._now = None
        self.turning.rest()

    # A turn

    def _rotate(self, rotating: Rotating, sampled_s: float) -> None:
        rate_dps = abs(rotating.rate_dps)
        lead_deg = least_run_up_deg(rate_dps, self._acceleration_dps2)
        if not -HAIR_DEG <= self._look(rotating).along_deg <= rotating.run_up_deg - lead_deg:
            self._angles.go_to(0.0 if rotating.rate_dps > 0.0 else TURN_DEG)
        way_deg = rotating.run_up_deg - self._look(rotating).along_deg
        begun_s = self._clock.now_s()
        with self._angles.talking:
            self._table.set_rate(rotating.rate_dps)
        self._clock.sleep_until(begun_s + rate_dps / self._acceleration_dps2 + SETTLE_S)
        limit_s = time_limit_s(rate_dps, self._acceleration_dps2) + way_deg / rate_dps
        read_dps = self._pass_run_up(rotating, begun_s + limit_s)
        self._refuse_rate(rotating, read_dps, "at the end of its run-up")
        self._refuse_late_begin(rotating, sampled_s)
        self._read.append(read_dps)
        self._end.set(self._latest_stop_s(rotating))

    def _pass_run_up(self, rotating: Rotating, deadline_s: float) -> float:
        """Return when the run-up lies behind it; the rate that was read last."""
        read_dps = self._read_rate_dps()
        while True:
            self._seen = self._look(rotating)
            left_s = (rotating.run_up_deg - self._seen.along_deg) / abs(rotating.rate_dps)
            if left_s <= 0.0:
                return read_dps
            if self._seen.time_s >= deadline_s:
                self._refuse_rate(
                    rotating, read_dps, "after all the time that the acceleration gives it"
                )
                self._halt()
                raise InstrumentError(
                    f"{self._name}: has come {self._seen.along_deg:.2f}° along its way, of a run-up of"
                    f" {rotating.run_up_deg:g}°, after all the time that {rotating.rate_dps:g} deg/s gives it; it"
                    " is stopped; look at its load, its limits and motion.max_acceleration"
                )
            if left_s > _POLL_S + self._reading_s:
                self._clock.sleep_until(self._seen.time_s + min(_POLL_S, left_s - self._reading_s))
                read_dps = self._read_rate_dps()
            else:
                self._clock.sleep_until(self._seen.time_s + max(left_s, _LEAST_S))

    def _refuse_late_begin(self, rotating: Rotating, sampled_s: float) -> None:
        """See that the samples end in time for it to stop, with half of the run-up's spare for a late source."""
        begin_deg = self._seen.along_deg
        ends_deg = begin_deg + abs(rotating.rate_dps) * sampled_s
        if ends_deg <= TURN_DEG - (rotating.run_up_deg + self._stopping_deg(rotating)) / 2:
            return
        self._halt()
        raise InstrumentError(
            f"{self._name}: the first sample would be taken {begin_deg:.2f}° along its way and the last one at"
            f" {ends_deg:.2f}°, too near to its end; the run-up of {rotating.run_up_deg:g}° is too short for a"
            f" controller that takes {self._reading_s:.2g} s to tell the rate; lengthen it"
        )

    def _look_on_the_way(self, rotating: Rotating) -> None:
        left_deg = TURN_DEG - rotating.run_up_deg - self._seen.along_deg
        slow_deg = (self._reading_s + _WATCH_S) * abs(rotating.rate_dps)
        # A controller that takes its time to tell the rate is not asked right before the end.
        if self._reading_s < LATENCY_S or left_deg > 2 * slow_deg:
            read_dps = self._read_rate_dps()
            self._read.append(read_dps)
            self._refuse_rate(rotating, read_dps, "on its way")
        self._seen = self._look(rotating)
        self._end.set(self._latest_stop_s(rotating))
        self.allow_pause(0.0)

    def _read_rate_dps(self) -> float:
        """The rate that the controller reads back; how long that took is kept in mind."""
        begun_s = self._clock.now_s()
        with self._angles.talking:
            read_dps = self._table.rate_dps()
        self._reading_s = self._clock.now_s() - begun_s
        return read_dps

    def _refuse_rate(self, rotating: Rotating, read_dps: float, where: str) -> None:
        if abs(read_dps - rotating.rate_dps) <= rotating.tolerance_dps:
            return
        self._halt()
        raise InstrumentError(
            f"{self._name}: {rotating.rate_dps:g} deg/s is demanded, {read_dps:.6g} deg/s read back {where},"
            f" ±{rotating.tolerance_dps:g} deg/s is accepted; it is stopped; look at its interlocks, its load and"
            " its balance, or lengthen the run-up"
        )

    def _too_far(self, rotating: Rotating) -> str:
        return (
            f"{self._name}: stopped before it came to the end of its turn, with samples still to be taken, which"
            f" were to end {rotating.run_up_deg:g}° before; the source is late, or broke off: look at it, or"
            " lengthen the run-up"
        )

    def _latest_stop_s(self, rotating: Rotating) -> float:
        """When it has to be told to stop, by where it was seen last, so that it stops before the end."""
        way_deg = TURN_DEG - self._stopping_deg(rotating) - self._seen.along_deg
        return self._seen.time_s + way_deg / (abs(rotating.rate_dps) + rotating.tolerance_dps)

    def _stopping_deg(self, rotating: Rotating) -> float:
        return stopping_deg(rotating.rate_dps, self._acceleration_dps2)

    def _look(self, rotating: Rotating) -> _Seen:
        """How far along its way it is, from 0° to 360°, whichever way it turns."""
        angle_deg = self._angles.angle_deg()
        along_deg = angle_deg if rotating.rate_dps > 0.0 else TURN_DEG - angle_deg
        return _Seen(time_s=self._clock.now_s(), along_deg=along_deg)

    def _halt(self) -> None:
        self._end.call_off()
        self._stop()

    def _stop(self) -> None:
        with self._angles.talking:
            self._table.stop()

    # An angle

    def _point(self, pointing: Pointing) -> None:
        self._angles.go_to(pointing.position_deg, within_deg=pointing.tolerance_deg)
        if pointing.settle_s > 0.0:
            self._clock.sleep_until(self._clock.now_s() + pointing.settle_s)
        self._look_at_rest(pointing)

    def _look_at_rest(self, pointing: Pointing) -> None:
        angle_deg = self._angles.angle_deg()
        self._seen = _Seen(time_s=self._clock.now_s(), along_deg=angle_deg)
        self._read.append(angle_deg)
        if abs(angle_deg - pointing.position_deg) > pointing.tolerance_deg:
            self._halt()
            raise InstrumentError(
                f"{self._name}: stands at {angle_deg:.3f}°, {pointing.position_deg:g}° is demanded,"
                f" ±{pointing.tolerance_deg:g}° is accepted; look at its interlocks, its load and its balance"
            )


class RotationRecorded:
    """What is played back was turned when it was recorded: nothing is moved."""

    def __init__(self) -> None:
        self._now: Rotating | Pointing | None = None

    def reach(self, stimulus: Rotating | Pointing, *, sampled_s: float) -> None:  # noqa: ARG002 - recorded
        """Nothing to do."""
        self._now = stimulus

    def watch(self) -> None:
        """Nothing to look at."""

    def allow_pause(self, pause_s: float) -> None:
        """Nothing that could come too far."""

    def leave(self) -> None:
        """Nothing to stop."""

    def read_back(self) -> ReadBack:
        """What the step asked for; nothing was read back."""
        if isinstance(self._now, Rotating):
            return ReadBack(demanded_rate_dps=self._now.rate_dps)
        if isinstance(self._now, Pointing):
            return ReadBack(demanded_position_deg=self._now.position_deg)
        return ReadBack()

    def rest(self) -> None:
        """Nothing to stop."""
