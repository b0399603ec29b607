"""The simulated bench's clock: virtual time that moves only when somebody waits or works."""

import threading
from collections.abc import Callable
from datetime import UTC, datetime, timedelta


class VirtualClock:
    """Virtual time, shared by the acquiring thread and the instruments' server threads.

    Waiting costs nothing: `sleep_until` moves the time. Two that wait at once wait side by side,
    not one after the other. Who subscribes is told each time it has moved, before the wait returns:
    a streaming instrument has sent what is due then.
    """

    def __init__(self, start_s: float = 0.0) -> None:
        self._lock = threading.Lock()
        self._start_s = start_s
        self._now_s = start_s
        self._start_utc = datetime.now(UTC)
        self._subscribers: tuple[Callable[[float], None], ...] = ()

    def subscribe(self, moved: Callable[[float], None]) -> None:
        """Call `moved` with the time, s, whenever it has moved, in the thread that moved it."""
        with self._lock:
            self._subscribers = (*self._subscribers, moved)

    def unsubscribe(self, moved: Callable[[float], None]) -> None:
        """Call it no more."""
        with self._lock:
            self._subscribers = tuple(one for one in self._subscribers if one != moved)

    def now_s(self) -> float:
        """Virtual monotonic time, s."""
        return self._now_s

    def utc(self) -> datetime:
        """Aware UTC: the real one at the start plus the virtual time since."""
        return self._start_utc + timedelta(seconds=self._now_s - self._start_s)

    def sleep_until(self, deadline_s: float) -> None:
        """Move the time to the deadline, never back."""
        with self._lock:
            self._now_s = max(self._now_s, deadline_s)
        self._tell()

    def advance(self, duration_s: float) -> None:
        """Move the time on by a duration; raises `ValueError` if it is negative."""
        if duration_s < 0.0:
            raise ValueError(f"time cannot go back by {-duration_s} s")
        with self._lock:
            self._now_s += duration_s
        self._tell()

    def _tell(self) -> None:
        for moved in self._subscribers:
            moved(self._now_s)
