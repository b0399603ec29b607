"""The envelope of a rate table: rates, turns, and the count of turns from angles within one turn."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from gyrotest.errors import InstrumentError
from gyrotest.instruments.motion import Envelope, Ramp, nearest_turn
from tests.instruments.table_bench import motion


def envelope(max_turns: float | None = 3.0, *, slip_ring: bool = False) -> Envelope:
    made = Envelope("table", motion(slip_ring=slip_ring, max_turns=max_turns))
    made.begin(0.0, 350.0)
    return made


@given(st.floats(-1e4, 1e4), st.floats(-1e4, 1e4))
def test_the_nearest_turn_is_the_same_direction_within_half_a_turn(angle: float, near: float) -> None:
    found = nearest_turn(angle, near_deg=near)
    assert abs(found - near) <= 180.0 + 1e-6
    assert abs((found - angle) / 360.0 - round((found - angle) / 360.0)) < 1e-6


@given(st.floats(-200, 200), st.floats(-200, 200), st.floats(0, 10))
def test_a_ramp_s_angle_is_the_integral_of_its_rate(start: float, end: float, time_s: float) -> None:
    ramp = Ramp(start_s=0.0, angle_deg=5.0, from_dps=start, to_dps=end, acceleration_dps2=100.0)
    step_s = time_s / 2000
    summed = 5.0 + sum(ramp.rate_dps((k + 0.5) * step_s) for k in range(2000)) * step_s
    assert ramp.angle_at_deg(time_s) == pytest.approx(summed, abs=1e-2)


@pytest.mark.parametrize("rate_dps", [200.1, -200.1, float("nan"), float("inf")])
def test_a_rate_beyond_the_greatest_is_refused(rate_dps: float) -> None:
    with pytest.raises(InstrumentError, match=r"^table: .* the station allows 200 deg/s"):
        envelope(slip_ring=True).refuse_rate(0.0, rate_dps)


def test_without_a_word_on_cables_only_rest_is_allowed() -> None:
    silent = envelope(None)
    silent.refuse_rate(0.0, 0.0)
    with pytest.raises(InstrumentError, match="neither a slip ring nor how far"):
        silent.refuse_rate(0.0, 0.1)


def test_a_rate_from_which_it_could_not_stop_in_time_is_refused() -> None:
    near_the_end = envelope(1.0)
    near_the_end.refuse_rate(0.0, 180.0)
    near_the_end.demanded(0.0, 90.0)
    near_the_end.read(3.0, (350.0 + 90.0 * 3.0 - 40.5) % 360.0)
    near_the_end.demanded(3.0, 0.0)
    with pytest.raises(InstrumentError, match=r"120 deg/s would turn the table by 1\.\d+ turns"):
        near_the_end.refuse_rate(10.0, 120.0)
    near_the_end.refuse_rate(10.0, -120.0)


def test_turning_back_is_allowed_from_beyond_the_end() -> None:
    beyond = envelope(1.0)
    beyond.demanded(0.0, 90.0)
    with pytest.raises(InstrumentError, match=r"it has turned by 1\.\d+ turns"):
        beyond.read(6.0, (350.0 + 90.0 * 6.0 - 40.5) % 360.0)
    beyond.demanded(6.0, 0.0)
    beyond.refuse_rate(10.0, -90.0)
    with pytest.raises(InstrumentError, match="order the rates alternately"):
        beyond.refuse_rate(10.0, 1.0)


def test_turns_are_counted_through_the_zero_of_the_angle() -> None:
    counting = envelope(None, slip_ring=True)
    counting.demanded(0.0, 180.0)
    for second in range(1, 20):
        true_deg = 350.0 + 180.0 * second - 162.0
        assert counting.read(second, true_deg % 360.0) == pytest.approx(true_deg, abs=1e-9)


def test_before_it_is_open_nothing_is_known() -> None:
    with pytest.raises(InstrumentError, match="not open"):
        Envelope("table", motion(slip_ring=False, max_turns=1.0)).refuse_rate(0.0, 1.0)
