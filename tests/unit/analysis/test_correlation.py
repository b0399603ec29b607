"""The correlation time: how many samples count as one."""

import numpy as np
import pytest
from scipy.signal import lfilter

from gyrotest.analysis.correlation import correlation_time
from gyrotest.errors import InsufficientDataError


def test_white_noise_remembers_nothing():
    noise = np.random.default_rng(1).normal(size=100_000)
    assert correlation_time(noise) == pytest.approx(1.0, abs=0.05)


@pytest.mark.parametrize("memory", [0.5, 0.9, 0.98])
def test_a_first_order_process_has_its_textbook_value(memory):
    """τ = (1 + a)/(1 − a)."""
    noise = lfilter([1.0], [1.0, -memory], np.random.default_rng(2).normal(size=400_000))
    assert correlation_time(noise) == pytest.approx((1 + memory) / (1 - memory), rel=0.1)


def test_samples_that_oppose_each_other_do_not_count_for_more():
    assert correlation_time(np.tile([1.0, -1.0], 500)) == 1.0
    assert correlation_time(np.full(100, 3.0)) == 1.0


def test_too_few_values_are_refused():
    with pytest.raises(InsufficientDataError, match="3 samples are too few"):
        correlation_time(np.arange(3.0))
