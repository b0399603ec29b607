"""What strikes a meter during one record, and when."""

import math

from gyrotest.simulation.scenarios import Misbehaviour, Strike

_OF_REPLIES = frozenset(
    {Misbehaviour.NO_REPLY, Misbehaviour.HANG_UP, Misbehaviour.DEAD, Misbehaviour.GARBLE}
)


class Faults:
    """The strikes of a scenario laid on a record that starts at a time and lasts for a duration."""

    def __init__(self, strikes: tuple[Strike, ...], *, start_s: float, duration_s: float) -> None:
        self._replies = sorted(
            (
                (start_s + strike.at * duration_s, strike.misbehaviour)
                for strike in strikes
                if strike.misbehaviour in _OF_REPLIES
            ),
            key=lambda due: due[0],
        )
        self.stuck_from_s = min(
            (
                start_s + strike.at * duration_s
                for strike in strikes
                if strike.misbehaviour is Misbehaviour.STUCK
            ),
            default=math.inf,
        )

    def strike(self, now_s: float) -> Misbehaviour | None:
        """The misbehaviour that is due for the reply at this time; each strikes once."""
        if not self._replies or now_s < self._replies[0][0]:
            return None
        return self._replies.pop(0)[1]
