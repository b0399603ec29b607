"""Intervals of magnitudes hold, also where the truth is 0."""

import numpy as np
import pytest

from gyrotest.analysis.extremes import largest_magnitude, magnitude


@pytest.mark.parametrize("truth", [0.0, 0.5, 2.0, 10.0])
def test_the_interval_of_a_magnitude_contains_the_truth(truth: float) -> None:
    drawn = np.random.default_rng(3).normal(truth, 1.0, 2000)
    found = [magnitude(float(one), standard=1.0, freedom=np.inf) for one in drawn]
    inside = np.mean([one.lower_95 <= abs(truth) <= one.upper_95 for one in found])
    assert 0.935 <= inside <= 1.0


@pytest.mark.parametrize("size", [0.0, 1.0, 5.0, 30.0])
def test_the_interval_of_the_largest_contains_the_truth_though_noise_makes_it_larger(
    size: float,
) -> None:
    random = np.random.default_rng(4)
    truth = size * np.sin(np.linspace(0.0, 6.0, 10))
    freedom = np.full(10, np.inf)
    found = [
        largest_magnitude(truth + random.normal(0.0, 1.0, 10), standard=np.ones(10), freedom=freedom)
        for _ in range(1000)
    ]
    largest = float(np.abs(truth).max())
    assert np.mean([one.lower_95 <= largest <= one.upper_95 for one in found]) >= 0.93
    if size == 0.0:
        assert np.mean([one.value for one in found]) > 1.5  # the bias that the interval allows for
        assert np.mean([one.lower_95 == 0.0 for one in found]) > 0.95


def test_few_degrees_of_freedom_widen_the_interval() -> None:
    narrow = magnitude(10.0, standard=1.0, freedom=np.inf)
    wide = magnitude(10.0, standard=1.0, freedom=5.0)
    assert wide.upper_95 - 10.0 == pytest.approx(2.571, abs=1e-3)
    assert narrow.upper_95 - 10.0 == pytest.approx(1.960, abs=1e-3)
