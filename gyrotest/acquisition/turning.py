"""A rate table in an acquisition: whether a plan is within its motion, and bringing it to each rate."""

import contextlib
import logging
import math
import sys
from collections.abc import Callable
from dataclasses import dataclass

from gyrotest.errors import InstrumentError
from gyrotest.ports import Clock, RateTable
from gyrotest.records.plan import Plan, Turning
from gyrotest.records.station import Motion
from gyrotest.units import Dimension

_TURN_DEG = 360.0
# A table gets half as long again as its acceleration takes, and this for settling and answering.
_RUN_UP_MARGIN = 1.5
_GRACE_S = 3.0
_POLL_S = 0.1
_WATCH_S = 1.0
_AT_REST_DPS = 0.1
# Nearer than this to where it stood at first, the cables are unwound.
_UNWOUND_DEG = 5.0
_MOST_RETURNS = 4

_logger = logging.getLogger(__name__)


@dataclass
class _Swing:
    """How far a table has turned from its start, at least and at most, °."""

    acceleration_dps2: float
    rate_dps: float = 0.0
    least_deg: float = 0.0
    most_deg: float = 0.0

    def change(self, rate_dps: float) -> None:
        """To a rate, at the acceleration; it may take as long as it is waited for."""
        took_s = abs(rate_dps - self.rate_dps) / self.acceleration_dps2
        self._turn((self.rate_dps + rate_dps) / 2 * took_s)
        late_deg = rate_dps * (time_limit_s(rate_dps - self.rate_dps, self.acceleration_dps2) - took_s)
        self.least_deg += min(0.0, late_deg)
        self.most_deg += max(0.0, late_deg)
        self.rate_dps = rate_dps

    def dwell(self, duration_s: float) -> None:
        """Go on at the rate."""
        self._turn(self.rate_dps * duration_s)

    def farthest_deg(self) -> float:
        """How far it may be from the start, either way; and to rest from there."""
        stopping_deg = self.rate_dps * abs(self.rate_dps) / (2 * self.acceleration_dps2)
        least_deg, most_deg = (
            self.least_deg + min(0.0, stopping_deg),
            self.most_deg + max(0.0, stopping_deg),
        )
        return max(-least_deg, most_deg)

    def _turn(self, angle_deg: float) -> None:
        self.least_deg += angle_deg
        self.most_deg += angle_deg


def time_limit_s(change_dps: float, acceleration_dps2: float) -> float:
    """How long a change of rate may take before it is a fault, s."""
    return _RUN_UP_MARGIN * abs(change_dps) / acceleration_dps2 + _GRACE_S


def come_to_rest(table: RateTable, *, clock: Clock, motion: Motion, name: str) -> None:
    """Return when a table rests; raises `InstrumentError` where it does not."""
    deadline_s = clock.now_s() + time_limit_s(
        motion.max_rate.to(Dimension.RATE), motion.max_acceleration.to(Dimension.RATE_RAMP)
    )
    while abs(table.rate_dps()) > _AT_REST_DPS:
        if clock.now_s() >= deadline_s:
            raise InstrumentError(f"{name}: does not come to rest")
        clock.sleep_until(clock.now_s() + _POLL_S)


def motion_faults(plan: Plan, motion: Motion) -> tuple[str, ...]:
    """What a table with this motion cannot do of a plan; nothing is commanded for it.

    Turns are counted through all steps from where the table stands before them: run-up (however long it
    is waited for), settling, samples, run-down.
    """
    most_dps = motion.max_rate.to(Dimension.RATE)
    faults = [
        f"step '{step.name}': {step.stimulus.rate_dps:g} deg/s is more than the table's {most_dps:g} deg/s"
        " (motion.max_rate); lower the rate, or correct the station"
        for step in plan.steps
        if isinstance(step.stimulus, Turning) and not abs(step.stimulus.rate_dps) <= most_dps
    ]
    if not motion.slip_ring:
        faults += _winding_faults(plan, motion)
    return tuple(faults)


def _winding_faults(plan: Plan, motion: Motion) -> list[str]:
    turning = [one for one in plan.steps if isinstance(one.stimulus, Turning) and one.stimulus.rate_dps]
    if turning and motion.max_turns is None:
        return [
            f"step '{turning[0].name}' turns the table, and the station states neither a slip ring nor how far"
            " the cables let it turn; give the instrument's motion 'slip_ring: true' or 'max_turns'"
        ]
    swing = _Swing(acceleration_dps2=motion.max_acceleration.to(Dimension.RATE_RAMP))
    for step in plan.steps:
        if isinstance(step.stimulus, Turning):
            swing.change(step.stimulus.rate_dps)
            swing.dwell(step.stimulus.settle_s)
        swing.dwell(step.samples * plan.interval_s)
        needed = swing.farthest_deg() / _TURN_DEG
        if motion.max_turns is not None and needed > motion.max_turns:
            return [
                f"step '{step.name}' takes the table up to {math.ceil(10 * needed) / 10:g} turns from its start,"
                f" the cables allow ±{motion.max_turns:g} (motion.max_turns); order the rates alternately,"
                " shorten the dwells, or use a slip ring"
            ]
    return []


class TableDrive:
    """Brings a rate table to the rates of a plan's steps and watches it there.

    The table is opened by its owner, who also closes it; it is switched on with the first rate. Where
    there is no slip ring it turns back after the plan to where it stood before. After a fault it is
    put down, and opened anew for what comes next. A `go_home` that is given does the going back.
    """

    def __init__(
        self,
        table: RateTable,
        *,
        clock: Clock,
        motion: Motion,
        name: str = "rate table",
        go_home: Callable[[], None] | None = None,
    ) -> None:
        self._table = table
        self._clock = clock
        self._motion = motion
        self._name = name
        self._go_home = self._unwind if go_home is None else go_home
        self._acceleration_dps2 = motion.max_acceleration.to(Dimension.RATE_RAMP)
        self._start_deg: float | None = None
        self._turning = Turning(rate_dps=0.0)
        self._enabled = False
        self._put_down = False
        self._between_plans = True
        self._watched_s = 0.0
        self._sum_dps = 0.0
        self._count = 0

    def reach(self, turning: Turning) -> None:
        """Return when it turns at the rate and has settled; raises `InstrumentError` where it does not."""
        self._forget()
        self.switch_on()
        change_dps = turning.rate_dps - self._turning.rate_dps
        self._turning = turning
        self._table.set_rate(turning.rate_dps)
        self._settle(turning, self._clock.now_s() + time_limit_s(change_dps, self._acceleration_dps2))
        self._hold(turning)
        self._watched_s = self._clock.now_s()

    def watch(self) -> None:
        """Look at it, about once a second; raises `InstrumentError` where it has left the rate."""
        now_s = self._clock.now_s()
        if now_s - self._watched_s < _WATCH_S:
            return
        self._watched_s = now_s
        read_dps = self._read()
        if abs(read_dps - self._turning.rate_dps) > self._turning.tolerance_dps:
            raise InstrumentError(
                f"{self._name}: left its rate: {self._turning.rate_dps:g} deg/s is demanded, {read_dps:.6g} deg/s"
                f" is read back, ±{self._turning.tolerance_dps:g} deg/s is accepted; look at its"
                " interlocks, its load and its balance"
            )

    def read_back(self) -> float | None:
        """The mean of what was read back since the rate was reached, °/s."""
        return self._sum_dps / self._count if self._count else None

    def rest(self) -> None:
        """Bring it to rest, and back where cables ask for it; never raises.

        Nothing is turned back while an error is being dealt with: somebody may be at the table. An
        interruption is not even kept waiting until it rests.
        """
        if not self._enabled:
            return
        fault = sys.exception()
        self._table.stop()
        self._between_plans = True
        self._turning = Turning(rate_dps=0.0)
        if fault is not None and not isinstance(fault, Exception):
            return
        with contextlib.suppress(InstrumentError):
            come_to_rest(self._table, clock=self._clock, motion=self._motion, name=self._name)
            if fault is None:
                self._go_home()

    def put_down(self) -> None:
        """After a fault: at rest, switched off and disconnected, its turns still counted; never raises."""
        self._table.close()
        self._put_down, self._enabled, self._between_plans = True, False, True
        self._turning = Turning(rate_dps=0.0)

    def switch_off(self) -> None:
        """Seen at rest, and put down; raises `InstrumentError` where it does not rest."""
        if self._enabled:
            self._table.stop()
            come_to_rest(self._table, clock=self._clock, motion=self._motion, name=self._name)
        self.put_down()

    def take_up(self) -> None:
        """Open it anew where it was put down; raises `InstrumentError`."""
        if self._put_down:
            self._table.open()
            self._put_down = False

    def switch_on(self) -> None:
        """See that it is on, and at its start where a plan begins; raises `InstrumentError`."""
        if not self._enabled:
            if self._start_deg is None:
                self._start_deg = self._table.position_deg()
            self._table.enable()
            self._enabled = True
        if self._between_plans:
            # An earlier plan that broke off may have left the cables wound up.
            self._go_home()
            self._between_plans = False

    def _settle(self, turning: Turning, deadline_s: float) -> None:
        while True:
            # A rate that is a mean over a while counts only if all of the while was after the deadline.
            begun_s = self._clock.now_s()
            read_dps = self._table.rate_dps()
            if abs(read_dps - turning.rate_dps) <= turning.tolerance_dps:
                return
            if begun_s >= deadline_s:
                self._table.stop()
                raise InstrumentError(
                    f"{self._name}: {turning.rate_dps:g} deg/s is demanded, {read_dps:.6g} deg/s read back after"
                    " all the time that the station's acceleration gives it, ±"
                    f"{turning.tolerance_dps:g} deg/s is accepted; it is stopped; look at its load, its limits and"
                    " motion.max_acceleration"
                )
            self._clock.sleep_until(self._clock.now_s() + _POLL_S)

    def _hold(self, turning: Turning) -> None:
        """Let the settling time pass, with the table in its tolerance at its end too."""
        if turning.settle_s > 0.0:
            self._clock.sleep_until(self._clock.now_s() + turning.settle_s)
        self._watched_s = -math.inf
        self.watch()

    def _read(self) -> float:
        read_dps = self._table.rate_dps()
        self._sum_dps += read_dps
        self._count += 1
        return read_dps

    def _forget(self) -> None:
        self._sum_dps = 0.0
        self._count = 0

    def _unwind(self) -> None:
        """Turn back to the start, not by the shorter way but by the one that it came."""
        if self._motion.slip_ring or self._start_deg is None:
            return
        for _ in range(_MOST_RETURNS):
            wound_deg = self._table.position_deg() - self._start_deg
            if abs(wound_deg) < _UNWOUND_DEG:
                return
            self._turn_back(wound_deg)
        _logger.warning(
            "%s: not back at its start, %.1f turns are left", self._name, wound_deg / _TURN_DEG
        )

    def _turn_back(self, wound_deg: float) -> None:
        # At this rate run-up and run-down together are the whole way at most.
        fastest_dps = math.sqrt(abs(wound_deg) * self._acceleration_dps2)
        rate_dps = min(self._motion.max_rate.to(Dimension.RATE), fastest_dps)
        begun_s = self._clock.now_s()
        self._table.set_rate(-math.copysign(rate_dps, wound_deg))
        self._clock.sleep_until(begun_s + abs(wound_deg) / rate_dps)
        self._table.set_rate(0.0)
        come_to_rest(self._table, clock=self._clock, motion=self._motion, name=self._name)
