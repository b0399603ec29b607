"""The simulated bench's clock: virtual time that moves only when somebody waits or works."""

import threading
from datetime import UTC, datetime, timedelta


class VirtualClock:
    """Virtual time, shared by the acquiring thread and the instruments' server threads.

    Waiting costs nothing: `sleep_until` moves the time. Two that wait at once wait side by side,
    not one after the other.
    """

    def __init__(self, start_s: float = 0.0) -> None:
        self._lock = threading.Lock()
        self._start_s = start_s
        self._now_s = start_s
        self._start_utc = datetime.now(UTC)

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

    def advance(self, duration_s: float) -> None:
        """Move the time on by a duration; raises `ValueError` if it is negative."""
        if duration_s < 0.0:
            raise ValueError(f"time cannot go back by {-duration_s} s")
        with self._lock:
            self._now_s += duration_s
