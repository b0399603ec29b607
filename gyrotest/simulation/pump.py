"""What keeps simulated instruments sending: virtual time whenever it moves, real time by a thread."""

import threading
from collections.abc import Callable

from gyrotest.ports import Clock
from gyrotest.simulation.clock import VirtualClock
from gyrotest.simulation.outlet import Outlet

_EVERY_S = 0.01
_JOIN_S = 1.0
# What a pump that moves the time itself lets pass at once.
_HURRIED_STEP_S = 0.05

Transmit = Callable[[float, Outlet], None]


class Pump:
    """Lets an instrument send into its outlet all that is due, until it is closed.

    `hurried`: nobody else moves the virtual clock, so this does, as fast as the line takes it.
    `attentive`: the instrument hears what it is told at once, also while the time stands.
    """

    def __init__(
        self,
        transmit: Transmit,
        outlet: Outlet,
        clock: Clock,
        *,
        hurried: bool = False,
        attentive: bool = False,
    ) -> None:
        self._transmit = transmit
        self._outlet = outlet
        self._clock = clock
        self._hurried = hurried
        # Threads of several servers may move the time.
        self._lock = threading.Lock()
        self._ended = threading.Event()
        self._thread: threading.Thread | None = None
        if isinstance(clock, VirtualClock) and not hurried:
            clock.subscribe(self._moved)
            if not attentive:
                return
        hears = attentive and not hurried
        self._thread = threading.Thread(
            target=self._attend if hears else self._run, daemon=True, name=f"pump-{outlet.address}"
        )
        self._thread.start()

    def _moved(self, now_s: float) -> None:
        with self._lock:
            if not self._ended.is_set():
                # While this thread waited its turn, another may have moved the time: what the instrument
                # is told now, it hears now.
                self._transmit(max(now_s, self._clock.now_s()), self._outlet)

    def _run(self) -> None:
        while not self._ended.wait(_EVERY_S if not self._hurried or self._outlet.room == 0 else 0.0):
            if self._hurried and self._outlet.room > 0:
                self._clock.sleep_until(self._clock.now_s() + _HURRIED_STEP_S)
            self._moved(self._clock.now_s())

    def _attend(self) -> None:
        while not self._ended.is_set():
            self._outlet.wait(_EVERY_S)
            self._moved(self._clock.now_s())

    def close(self) -> None:
        """Send no more, and unplug; idempotent."""
        if isinstance(self._clock, VirtualClock):
            self._clock.unsubscribe(self._moved)
        self._ended.set()
        if self._thread is not None:
            self._thread.join(_JOIN_S)
        with self._lock:
            self._outlet.close()
