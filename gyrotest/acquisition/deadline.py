"""What is done at a time of the clock unless it is called off before, whatever else is being waited for."""

import threading
from collections.abc import Callable

from gyrotest.ports import Clock

# Nobody tells when another's clock has moved on: it is looked at so often.
_LOOK_S = 0.05


class Deadline:
    """Does something once the clock has reached a time, in a thread of its own.

    `reached` tells that it was done, until it is called off.
    """

    def __init__(self, clock: Clock, act: Callable[[], None], *, name: str) -> None:
        self._clock = clock
        self._act = act
        self._name = name
        self._changed = threading.Condition()
        self._due_s: float | None = None
        self._thread: threading.Thread | None = None
        self.reached = False

    def set(self, due_s: float) -> None:
        """Do it then, and not when it was to be done before; where it was done already it stays so."""
        with self._changed:
            if self.reached:
                return
            self._due_s = due_s
            if self._thread is None:
                self._thread = threading.Thread(target=self._wait, name=self._name, daemon=True)
                self._thread.start()
            self._changed.notify()

    def call_off(self) -> bool:
        """Do it no more; whether it was done, once nothing is being done any more."""
        with self._changed:
            self._due_s = None
            thread, self._thread = self._thread, None
            self._changed.notify()
        if thread is not None:
            thread.join()
        was_reached, self.reached = self.reached, False
        return was_reached

    def _wait(self) -> None:
        with self._changed:
            while self._due_s is not None:
                left_s = self._due_s - self._clock.now_s()
                if left_s <= 0.0:
                    self.reached = True
                    break
                self._changed.wait(min(left_s, _LOOK_S))
        if self.reached:
            self._act()
