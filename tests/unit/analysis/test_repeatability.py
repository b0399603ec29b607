"""The spread over repeats: the worked example, and intervals that hold the truth beneath the noise."""

import numpy as np
import pytest

from gyrotest.analysis.repeatability import repeatability
from gyrotest.errors import InsufficientDataError

EXAMPLE_DPS = [0.18789, 0.17844, 0.16965, 0.18459, 0.19401]


def test_the_worked_example() -> None:
    found = repeatability(EXAMPLE_DPS)
    assert found.mean == pytest.approx(0.182916, abs=1e-9)
    assert found.deviation == pytest.approx(0.00930915, abs=5e-9)
    assert found.mean_uncertainty == pytest.approx(0.00930915 / np.sqrt(5), rel=1e-6)
    # chi-square quantiles of four degrees of freedom: 11.1433 and 0.484419
    assert found.lower_95 == pytest.approx(0.00930915 * np.sqrt(4 / 11.1433), rel=1e-5)
    assert found.upper_95 == pytest.approx(0.00930915 * np.sqrt(4 / 0.484419), rel=1e-5)


def test_the_values_own_noise_lowers_the_lower_end_only() -> None:
    plain, noisy = repeatability(EXAMPLE_DPS), repeatability(EXAMPLE_DPS, uncertainties=0.004)
    assert noisy.deviation == plain.deviation
    assert noisy.upper_95 == plain.upper_95
    assert noisy.lower_95 == pytest.approx(np.sqrt(plain.lower_95**2 - 0.004**2))
    assert repeatability(EXAMPLE_DPS, uncertainties=0.02).lower_95 == 0.0


@pytest.mark.parametrize("noise", [0.0, 0.5, 1.0, 3.0])
def test_intervals_hold_the_spread_of_the_quantity_itself(noise: float) -> None:
    """Whatever the noise of each value: at least 93 % of 4000 units of seven cycles."""
    random = np.random.default_rng(7)
    held = 0
    for _ in range(4000):
        values = random.standard_normal(7) + noise * random.standard_normal(7)
        found = repeatability(values, uncertainties=noise)
        held += found.lower_95 <= 1.0 <= found.upper_95
    assert held / 4000 >= 0.94 if noise else 0.94 <= held / 4000 <= 0.96


@pytest.mark.parametrize("values", [[], [1.0], [1.0, np.nan, 2.0]])
def test_too_little_is_refused(values: list[float]) -> None:
    with pytest.raises(InsufficientDataError):
        repeatability(values)
