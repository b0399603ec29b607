"""Bounds along a profile: known crossings found, an edge at 0 respected."""

import math
from collections.abc import Callable

import pytest
from hypothesis import given
from hypothesis import strategies as st

from gyrotest.analysis.interval import NORMAL_95
from gyrotest.analysis.profile import (
    NORMAL_95_DEVIANCE,
    ONE_SIGMA_DEVIANCE,
    lower_bound,
    upper_bound,
)

# The search ends within 0.02 of the root of the excess deviance: a fiftieth of a standard uncertainty.
CLOSE = 0.021


def parabola(value: float, sigma: float) -> Callable[[float], float]:
    return lambda at: ((at - value) / sigma) ** 2


def test_the_deviance_of_95_percent_is_the_normal_quantile_squared() -> None:
    assert pytest.approx(NORMAL_95**2) == NORMAL_95_DEVIANCE


@given(
    st.floats(1e-9, 1e9), st.floats(0.01, 0.3), st.sampled_from([ONE_SIGMA_DEVIANCE, NORMAL_95_DEVIANCE])
)
def test_bounds_of_a_parabola_are_its_crossings(value: float, relative: float, deviance: float) -> None:
    sigma = relative * value
    excess = parabola(value, sigma)
    reach = sigma * math.sqrt(deviance)
    upper = upper_bound(excess, value=value, sigma=sigma, deviance=deviance)
    lower = lower_bound(excess, value=value, sigma=sigma, deviance=deviance)
    assert upper == pytest.approx(value + reach, abs=CLOSE * sigma)
    assert lower == pytest.approx(value - reach, abs=CLOSE * sigma)


@pytest.mark.parametrize("guess", [0.02, 0.1, 1.0, 10.0, 50.0])
def test_a_wrong_guess_of_the_uncertainty_does_no_harm(guess: float) -> None:
    excess = parabola(100.0, 1.0)
    upper = upper_bound(excess, value=100.0, sigma=guess, deviance=NORMAL_95_DEVIANCE)
    assert upper == pytest.approx(101.96, abs=CLOSE)
    lower = lower_bound(excess, value=100.0, sigma=guess, deviance=NORMAL_95_DEVIANCE)
    assert lower == pytest.approx(98.04, abs=CLOSE)


def test_where_0_is_likely_enough_the_lower_bound_is_0() -> None:
    excess = parabola(1.0, 0.6)
    assert lower_bound(excess, value=1.0, sigma=0.6, deviance=NORMAL_95_DEVIANCE) == 0.0
    assert lower_bound(excess, value=1.0, sigma=0.6, deviance=ONE_SIGMA_DEVIANCE) > 0.0


def test_a_value_at_the_edge_has_a_limit() -> None:
    """Below the edge the deviance would go on falling: it rises linearly as well."""

    def excess(at: float) -> float:
        return at**2 + 2.0 * at

    assert lower_bound(excess, value=0.0, sigma=1.0, deviance=NORMAL_95_DEVIANCE) == 0.0
    upper = upper_bound(excess, value=0.0, sigma=1.0, deviance=NORMAL_95_DEVIANCE)
    assert excess(upper) == pytest.approx(NORMAL_95_DEVIANCE, rel=0.03)


def test_bounds_of_a_skewed_profile_are_its_crossings() -> None:
    """A chi-square variance of 20 degrees of freedom: 20·(s²/σ² − 1 − ln s²/σ²)."""

    def excess(at: float) -> float:
        return 20.0 * (1.0 / at - 1.0 + math.log(at)) if at > 0.0 else math.inf

    upper = upper_bound(excess, value=1.0, sigma=0.316, deviance=NORMAL_95_DEVIANCE)
    lower = lower_bound(excess, value=1.0, sigma=0.316, deviance=NORMAL_95_DEVIANCE)
    assert math.sqrt(excess(upper)) == pytest.approx(NORMAL_95, abs=CLOSE)
    assert math.sqrt(excess(lower)) == pytest.approx(NORMAL_95, abs=CLOSE)
    assert upper - 1.0 > 1.5 * (1.0 - lower)
