"""The real clock: monotonic time for spacing, UTC that follows it from the start."""

import time
from datetime import UTC, datetime, timedelta

# A sleep is taken in slices so that Ctrl-C is seen on platforms whose sleep cannot be interrupted.
_SLICE_S = 0.5


class RealClock:
    """The machine's monotonic clock; its UTC does not jump when the wall clock is set."""

    def __init__(self) -> None:
        self._start_s = time.monotonic()
        self._start_utc = datetime.now(UTC)

    def now_s(self) -> float:
        """Monotonic time, s."""
        return time.monotonic()

    def utc(self) -> datetime:
        """Aware UTC: that of the start plus the monotonic time since."""
        return self._start_utc + timedelta(seconds=time.monotonic() - self._start_s)

    def sleep_until(self, deadline_s: float) -> None:
        """Return when `now_s()` has reached the absolute deadline; at once if it has passed."""
        while (left_s := deadline_s - time.monotonic()) > 0.0:
            time.sleep(min(left_s, _SLICE_S))
