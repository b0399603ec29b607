"""The low-pass that both channels share."""

from itertools import pairwise

import numpy as np
import pytest

from gyrotest.analysis.lowpass import Lowpass, require_no_aliasing
from gyrotest.errors import InsufficientDataError

RATE_HZ, CUTOFF_HZ = 10_000.0, 250.0


def signals(samples: int) -> np.ndarray:
    return np.random.default_rng(5).normal(size=(2, samples)) + np.array([[7.0], [-3.0]])


def test_it_is_the_third_order_butterworth_of_the_method() -> None:
    frequency_hz = np.array([0.0, 5.0, 50.0, 100.0, 250.0])
    s = 1j * frequency_hz / CUTOFF_HZ
    expected = 1.0 / (s**3 + 2.0 * s**2 + 2.0 * s + 1.0)
    found = Lowpass(CUTOFF_HZ, RATE_HZ, 2).transfer(frequency_hz)
    np.testing.assert_allclose(found, expected, atol=3e-3)
    assert abs(found[-1]) == pytest.approx(np.sqrt(0.5), rel=1e-12)


def test_blocks_of_any_size_give_what_one_block_gives() -> None:
    given = signals(5000)
    whole = Lowpass(CUTOFF_HZ, RATE_HZ, 2).push(given)
    low_pass = Lowpass(CUTOFF_HZ, RATE_HZ, 2)
    cuts = np.array([0, 1, 1, 17, 1234, 1235, 5000])
    parts = [low_pass.push(given[:, a:b]) for a, b in pairwise(cuts)]
    np.testing.assert_array_equal(np.concatenate(parts, axis=1), whole)


def test_a_level_to_begin_with_is_no_step() -> None:
    level = np.full((2, 100), 1000.0)
    np.testing.assert_allclose(Lowpass(CUTOFF_HZ, RATE_HZ, 2).push(level), level, rtol=1e-9)


def test_a_new_stretch_begins_as_the_first_did() -> None:
    given = signals(300)
    low_pass = Lowpass(CUTOFF_HZ, RATE_HZ, 2)
    first = low_pass.push(given)
    low_pass.begin_stretch()
    np.testing.assert_array_equal(low_pass.push(given), first)


def test_it_makes_a_sine_what_its_transfer_says() -> None:
    time_s = np.arange(20_000) / RATE_HZ
    sine = np.sin(2.0 * np.pi * 100.0 * time_s)[np.newaxis]
    low_pass = Lowpass(CUTOFF_HZ, RATE_HZ, 1)
    found = low_pass.push(sine)[0, 10_000:]
    turn = np.exp(-2j * np.pi * 100.0 * time_s[10_000:])
    expected = low_pass.transfer(np.array([100.0]))[0]
    assert 2j * np.mean(found * turn) == pytest.approx(expected, abs=1e-9)


@pytest.mark.parametrize("cutoff_hz", [0.0, 5000.0, float("nan")])
def test_a_cut_off_beyond_half_the_rate_is_refused(cutoff_hz: float) -> None:
    with pytest.raises(ValueError, match="10000 Hz"):
        Lowpass(cutoff_hz, RATE_HZ, 2)


def test_another_number_of_channels_is_refused() -> None:
    with pytest.raises(ValueError, match="2 channels, found 3"):
        Lowpass(CUTOFF_HZ, RATE_HZ, 2).push(np.zeros((3, 4)))


def test_enough_samples_or_an_analogue_filter_prevent_aliasing() -> None:
    require_no_aliasing(rate_hz=2500.0, cutoff_hz=250.0, analogue_hz=None)
    require_no_aliasing(rate_hz=2500.0 - 1e-9, cutoff_hz=250.0, analogue_hz=2000.0)
    require_no_aliasing(rate_hz=1000.0, cutoff_hz=250.0, analogue_hz=400.0)


@pytest.mark.parametrize(
    ("analogue_hz", "said"), [(None, "none is stated"), (600.0, "600 Hz is stated")]
)
def test_samples_that_may_be_aliased_are_refused(analogue_hz: float | None, said: str) -> None:
    with pytest.raises(
        InsufficientDataError, match=f"1000 Hz .*250 Hz.*2500 Hz or more.*500 Hz.*{said}"
    ):
        require_no_aliasing(rate_hz=1000.0, cutoff_hz=250.0, analogue_hz=analogue_hz)
