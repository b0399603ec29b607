"""What strikes a simulated acquisition system and the encoder in front of it during one record."""

import numpy as np
from numpy.typing import NDArray

from gyrotest.simulation.housed import Housed
from gyrotest.simulation.scenarios import Misbehaviour, Scenario, Strike

_LOST_S = 0.02
_ONCE = {Misbehaviour.BAD_BLOCK, Misbehaviour.LOST_CONNECTION}
_OF_DAQ = {*_ONCE, Misbehaviour.LOST_SAMPLES, Misbehaviour.ENCODER_DARK, Misbehaviour.RAIL}


class DaqFaults:
    """The strikes of a scenario on one record."""

    def __init__(self, scenario: Scenario, housed: Housed) -> None:
        recorded = housed.occasion.duration_s > 0.0
        self._begun_s, self._duration_s = housed.begun_s, housed.occasion.duration_s
        self._strikes = [one for one in scenario.strikes if one.misbehaviour in _OF_DAQ and recorded]
        self._to_come = [one for one in self._strikes if one.misbehaviour in _ONCE]

    def due(self, misbehaviour: Misbehaviour, now_s: float) -> bool:
        """Whether it strikes now; each strikes once."""
        for strike in self._to_come:
            if strike.misbehaviour is misbehaviour and now_s >= self._at_s(strike):
                self._to_come.remove(strike)
                return True
        return False

    def lost(self, time_s: NDArray[np.float64]) -> NDArray[np.bool_] | None:
        """Which samples the system has no room for, (n,); None: it has for all."""
        for strike in self._strikes:
            if strike.misbehaviour is Misbehaviour.LOST_SAMPLES:
                from_s = self._at_s(strike)
                found = (time_s >= from_s) & (time_s < from_s + _LOST_S)
                return np.asarray(found) if found.any() else None
        return None

    def during(
        self, misbehaviour: Misbehaviour, time_s: NDArray[np.float64]
    ) -> NDArray[np.bool_] | None:
        """At which times it lasts, (n,); None: at none."""
        for strike in self._strikes:
            if strike.misbehaviour is misbehaviour:
                until_s = self._begun_s + strike.until * self._duration_s
                found = (time_s >= self._at_s(strike)) & (time_s < until_s)
                return np.asarray(found) if found.any() else None
        return None

    def _at_s(self, strike: Strike) -> float:
        return self._begun_s + strike.at * self._duration_s
