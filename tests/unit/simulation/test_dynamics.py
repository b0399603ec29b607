"""A simulated gyro's dynamics: the response that is promised, and what the recursion makes of a rate."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from gyrotest.simulation.dynamics import Dynamics, Follower, frequency_response

KNOT_S = 1e-4
BANDWIDTHS = st.floats(5.0, 500.0)
DAMPINGS = st.floats(0.2, 2.0)


@given(bandwidth_hz=BANDWIDTHS, damping=DAMPINGS)
def test_at_its_bandwidth_the_response_is_3_db_down(bandwidth_hz: float, damping: float) -> None:
    dynamics = Dynamics(bandwidth_hz=bandwidth_hz, damping=damping)
    assert abs(dynamics.response(np.array([bandwidth_hz]))[0]) == pytest.approx(math.sqrt(0.5))
    assert dynamics.response(np.zeros(1))[0] == pytest.approx(1.0)


def test_a_delay_turns_the_phase_back_and_leaves_the_gain() -> None:
    found = Dynamics(bandwidth_hz=50.0, delay_s=1e-3).response(np.array([10.0, 100.0]))
    assert np.abs(found) == pytest.approx(1.0)
    assert np.degrees(np.angle(found)) == pytest.approx([-3.6, -36.0])


def test_the_truth_of_a_record_gives_the_output_by_the_rate() -> None:
    truth = {
        "z.bandwidth_hz": 80.0,
        "z.damping": 0.7,
        "z.delay_s": 5e-4,
        "z.scale_factor": -0.05,
    }
    found = frequency_response(np.array([0.0, 80.0]), truth, "z")
    assert found[0] == pytest.approx(-0.05)
    assert abs(found[1]) == pytest.approx(0.05 / math.sqrt(2.0))


def followed(dynamics: Dynamics, frequency_hz: float, shift_s: float, parts: int = 7) -> complex:
    """The response to a sine by the recursion, fed in parts; its first second is left out."""
    knots = np.arange(30_000)
    follower = Follower(dynamics, interval_s=KNOT_S, shift_s=shift_s)
    rates = 0.3 + np.sin(2.0 * math.pi * frequency_hz * KNOT_S * knots)
    given_out = np.concatenate([follower.follow(part) for part in np.array_split(rates, parts)])
    times_s = (knots - follower.ahead) * KNOT_S
    turn = 2.0 * math.pi * frequency_hz * times_s
    columns = np.column_stack([np.sin(turn), np.cos(turn), np.ones(turn.size)])
    sine, cosine, level = np.linalg.lstsq(columns[10_000:], given_out[10_000:], rcond=None)[0]
    assert level == pytest.approx(0.3)
    # A rate that goes straight from knot to knot is a sine of so much less, and images far above.
    return complex(sine, cosine) / float(np.sinc(frequency_hz * KNOT_S)) ** 2


@pytest.mark.parametrize("frequency_hz", [5.0, 20.0, 100.0])
@pytest.mark.parametrize("shift_s", [0.0, 2.7e-6, -1.3e-6, 1.37e-4])
@pytest.mark.parametrize(("damping", "delay_s"), [(0.7, 0.0), (0.3, 5e-4), (1.5, 1.234e-4)])
def test_the_recursion_is_the_response_itself(
    damping: float, delay_s: float, shift_s: float, frequency_hz: float
) -> None:
    dynamics = Dynamics(bandwidth_hz=80.0, damping=damping, delay_s=delay_s)
    expected = dynamics.response(np.array([frequency_hz]))[0] * np.exp(
        2j * math.pi * frequency_hz * shift_s
    )
    ratio = followed(dynamics, frequency_hz, shift_s) / expected
    assert abs(ratio) == pytest.approx(1.0, abs=1e-6)
    assert np.degrees(np.angle(ratio)) == pytest.approx(0.0, abs=1e-4)


def test_without_dynamics_the_rate_is_the_answer() -> None:
    follower = Follower(Dynamics(bandwidth_hz=50.0), interval_s=KNOT_S, shift_s=0.0)
    rates = np.random.default_rng(1).standard_normal(100)
    assert follower.follow(rates)[follower.ahead :] == pytest.approx(rates[: -follower.ahead])


def test_how_a_rate_is_cut_into_parts_changes_nothing() -> None:
    dynamics = Dynamics(bandwidth_hz=80.0, damping=0.7, delay_s=5e-4)
    assert followed(dynamics, 40.0, 0.0, parts=1) == pytest.approx(
        followed(dynamics, 40.0, 0.0, parts=1000), rel=1e-9
    )


def test_a_steady_rate_from_the_beginning_is_no_step() -> None:
    follower = Follower(Dynamics(bandwidth_hz=20.0, damping=0.5), interval_s=KNOT_S, shift_s=0.0)
    assert follower.follow(np.full(500, 3.0)) == pytest.approx(3.0, abs=1e-9)


@pytest.mark.parametrize("bandwidth_hz", [20.0, 300.0])
@pytest.mark.parametrize("damping", [0.2, 0.7, 1.0, 2.0])
def test_after_its_settling_time_nothing_is_left_of_a_step(bandwidth_hz: float, damping: float) -> None:
    dynamics = Dynamics(bandwidth_hz=bandwidth_hz, damping=damping)
    follower = Follower(dynamics, interval_s=KNOT_S, shift_s=0.0)
    settled = math.ceil(dynamics.settling_s / KNOT_S)
    answers = follower.follow(np.concatenate([np.zeros(10), np.ones(settled + 10)]))
    assert answers[-1] == pytest.approx(1.0, abs=1e-6)
