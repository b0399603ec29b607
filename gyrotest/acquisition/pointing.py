"""A stage's own angle, counted within one turn, and coming to rest at one without passing its ends."""

import math
import threading

from gyrotest.acquisition.turning import come_to_rest
from gyrotest.errors import InstrumentError
from gyrotest.ports import Clock, RateTable
from gyrotest.records.station import Motion
from gyrotest.units import Dimension

HAIR_DEG = 0.5
"""So far outside of the ends is still at them."""

_TURN_DEG = 360.0
# A longer way than this is turned at a rate, no faster than this; what is left of it is gone by position.
_BY_POSITION_DEG, _LEFT_DEG = 90.0, 30.0
_SLOWLY_DPS = 20.0
_MOST_TRIES = 4
_AT_END_DEG = 0.2
_GRACE_S = 5.0
_POLL_S = 0.1


class Angles:
    """A stage's angle by its controller, and the way to angles between 0° and 360°.

    Controllers tell an angle within one turn. Where the stage stands when it is asked first is taken to
    lie between 0° and 360°, to which ends it is never taken but from within. `talking` is held while the
    controller is asked or told something.
    """

    def __init__(self, table: RateTable, *, clock: Clock, motion: Motion, name: str) -> None:
        self._table = table
        self._clock = clock
        self._motion = motion
        self._name = name
        self._acceleration_dps2 = motion.max_acceleration.to(Dimension.RATE_RAMP)
        self._rate_dps = min(motion.max_rate.to(Dimension.RATE), _SLOWLY_DPS)
        self._zero_deg: float | None = None
        self.talking = threading.RLock()

    def angle_deg(self) -> float:
        """Where it is; raises `InstrumentError`."""
        with self.talking:
            position_deg = self._table.position_deg()
        if self._zero_deg is None:
            self._zero_deg = _TURN_DEG * math.floor((position_deg + HAIR_DEG) / _TURN_DEG)
        return position_deg - self._zero_deg

    def go_home(self) -> None:
        """Come to rest at 0; raises `InstrumentError`."""
        self.go_to(0.0)

    def go_to(self, target_deg: float, *, within_deg: float = _AT_END_DEG) -> None:
        """Come to rest at an angle, slowly; raises `InstrumentError`, stopped, where it does not."""
        way_deg = target_deg - self.angle_deg()
        for _ in range(_MOST_TRIES):
            if abs(way_deg) <= _BY_POSITION_DEG:
                break
            self._turn_by(way_deg - math.copysign(_LEFT_DEG, way_deg))
            way_deg = target_deg - self.angle_deg()
        if abs(way_deg) <= within_deg:
            return
        with self.talking:
            # The controller goes the shorter way, which is the one that is left.
            self._table.move_to(target_deg % _TURN_DEG)
        self._wait_for(target_deg, abs(way_deg), within_deg)

    def come_to_rest(self) -> None:
        """Return when it rests; raises `InstrumentError` where it does not."""
        with self.talking:
            come_to_rest(self._table, clock=self._clock, motion=self._motion, name=self._name)

    def _wait_for(self, target_deg: float, way_deg: float, within_deg: float) -> None:
        needed_s = way_deg / self._rate_dps + 2 * math.sqrt(way_deg / self._acceleration_dps2)
        deadline_s = self._clock.now_s() + 2 * needed_s + _GRACE_S
        while abs((found_deg := self.angle_deg()) - target_deg) > within_deg:
            if self._clock.now_s() >= deadline_s:
                with self.talking:
                    self._table.stop()
                raise InstrumentError(
                    f"{self._name}: does not come to {target_deg:g}°: it is at {found_deg:.3f}° after all the time"
                    f" that the station's motion gives it, ±{within_deg:g}° is accepted; it is stopped; look at"
                    " its interlocks, its load and its limits"
                )
            self._clock.sleep_until(self._clock.now_s() + _POLL_S)
        self.come_to_rest()

    def _turn_by(self, way_deg: float) -> None:
        """Turn about so far at a rate, and come to rest."""
        # At this rate run-up and run-down together are the whole way at most.
        fastest_dps = math.sqrt(abs(way_deg) * self._acceleration_dps2)
        rate_dps = min(self._rate_dps, fastest_dps)
        begun_s = self._clock.now_s()
        with self.talking:
            self._table.set_rate(math.copysign(rate_dps, way_deg))
        self._clock.sleep_until(begun_s + abs(way_deg) / rate_dps)
        with self.talking:
            self._table.set_rate(0.0)
        self.come_to_rest()
