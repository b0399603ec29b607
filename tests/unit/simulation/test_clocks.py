"""Virtual time moves only when somebody waits; real time only forwards."""

import threading
from datetime import UTC, datetime, timedelta

import pytest

from gyrotest.clock import RealClock
from gyrotest.simulation.clock import VirtualClock


def test_waiting_moves_virtual_time_to_the_deadline() -> None:
    clock = VirtualClock()
    clock.sleep_until(3600.0)
    assert clock.now_s() == 3600.0


def test_a_deadline_in_the_past_does_not_move_virtual_time() -> None:
    clock = VirtualClock(10.0)
    clock.sleep_until(3.0)
    assert clock.now_s() == 10.0


def test_virtual_utc_starts_at_the_real_one_and_follows_virtual_time() -> None:
    before = datetime.now(UTC)
    clock = VirtualClock(100.0)
    start = clock.utc()
    assert timedelta(0) <= start - before < timedelta(minutes=1)
    clock.advance(7200.0)
    assert clock.utc() - start == timedelta(hours=2)


def test_virtual_time_does_not_go_back() -> None:
    with pytest.raises(ValueError, match="go back"):
        VirtualClock().advance(-1.0)


def test_no_advance_is_lost_between_threads() -> None:
    clock = VirtualClock()

    def advance_often() -> None:
        for _ in range(2000):
            clock.advance(1.0)

    threads = [threading.Thread(target=advance_often) for _ in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert clock.now_s() == 8000.0


def test_the_real_clock_waits_until_its_deadline() -> None:
    clock = RealClock()
    deadline_s = clock.now_s() + 0.01
    clock.sleep_until(deadline_s)
    assert clock.now_s() >= deadline_s


def test_the_real_clocks_utc_follows_its_monotonic_time() -> None:
    clock = RealClock()
    first_utc, first_s = clock.utc(), clock.now_s()
    clock.sleep_until(first_s + 0.01)
    elapsed = (clock.utc() - first_utc).total_seconds()
    assert elapsed == pytest.approx(clock.now_s() - first_s, abs=0.05)
    assert first_utc.tzinfo is not None
