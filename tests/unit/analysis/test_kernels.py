"""The compiled kernels against their plain definitions."""

from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from gyrotest.analysis.angle import angle, checked_rate
from gyrotest.analysis.curve import default_factors
from gyrotest.analysis.kernels.chains import octave_chains, overlapping_variances
from gyrotest.errors import InsufficientDataError
from tests.unit.analysis.generator import gyro_noise

records = st.lists(st.floats(-100.0, 100.0), min_size=2, max_size=90).filter(
    lambda values: max(values) - min(values) > 1e-3
)


def plain_variance(rate: np.ndarray, m: int) -> float:
    """The definition, in long doubles."""
    exact = rate.astype(np.longdouble)
    theta = np.concatenate(([0.0], np.cumsum(exact - exact.mean())))
    second = theta[2 * m :] - 2.0 * theta[m:-m] + theta[: -2 * m]
    return float(np.mean(second**2) / (2.0 * m * m))


@pytest.mark.parametrize("size", [2, 3, 8, 36, 37, 997, 8191, 40_000])
@pytest.mark.parametrize(
    "coefficients",
    [{"angle_random_walk": 1.0}, {"bias_instability": 1.0}, {"rate_random_walk": 1.0}],
    ids=["white", "flicker", "walk"],
)
def test_variances_equal_their_definition(size: int, coefficients: dict[str, float]) -> None:
    rate = gyro_noise(size, **coefficients) + 2.5
    factors = np.unique(np.linspace(1, size // 2, 25).astype(np.int64))
    found = overlapping_variances(angle(rate), factors)
    np.testing.assert_allclose(found, [plain_variance(rate, int(m)) for m in factors], rtol=1e-12)


@settings(max_examples=60, deadline=None)
@given(values=records, data=st.data())
def test_any_factors_of_any_record_give_their_definition(
    values: list[float], data: st.DataObject
) -> None:
    rate = np.array(values)
    chosen = data.draw(st.sets(st.integers(1, rate.size // 2), min_size=1))
    factors = np.array(sorted(chosen), dtype=np.int64)
    found = overlapping_variances(angle(rate), factors)
    expected = [plain_variance(rate, int(m)) for m in factors]
    np.testing.assert_allclose(found, expected, rtol=1e-9, atol=1e-20)


@settings(max_examples=40, deadline=None)
@given(values=records, scale=st.floats(0.1, 1000.0), offset=st.floats(-1e3, 1e3))
def test_scale_offset_and_direction_of_time(values: list[float], scale: float, offset: float) -> None:
    rate = np.array(values)
    factors = np.arange(1, rate.size // 2 + 1, dtype=np.int64)
    plain = overlapping_variances(angle(rate), factors)
    for changed in (scale * rate + offset, (scale * rate)[::-1]):
        other = overlapping_variances(angle(changed), factors)
        np.testing.assert_allclose(other, scale**2 * plain, rtol=1e-6, atol=1e-9 * scale**2)


def test_a_drift_that_carries_the_angle_far_away_costs_no_digits() -> None:
    rate = 0.5 * np.arange(100_001.0)  # every angle is a whole number of halves
    factors = default_factors(rate.size)
    np.testing.assert_allclose(
        overlapping_variances(angle(rate), factors), 0.125 * factors**2.0, rtol=1e-14
    )


@pytest.mark.parametrize("size", [*range(2, 20), 4096, 4097, 10_001])
def test_the_angle_is_the_running_sum_less_the_mean(size: int) -> None:
    rate = np.random.default_rng(size).normal(5.0, 1.0, size)
    expected = np.concatenate(([0.0], np.cumsum(rate - rate.mean())))
    np.testing.assert_allclose(angle(rate), expected, atol=1e-10)


@pytest.mark.parametrize("place", [0, 1, 1023, 1024, 6001])
@pytest.mark.parametrize("value", [float("nan"), float("inf"), float("-inf")])
def test_a_sample_that_is_no_number_is_named(place: int, value: float) -> None:
    rate = np.random.default_rng(1).normal(size=6002)
    rate[place] = value
    with pytest.raises(InsufficientDataError, match=rf"sample {place} is {value} \(1 of 6002"):
        checked_rate(rate)


def test_samples_that_cannot_be_summed_are_refused() -> None:
    with pytest.raises(InsufficientDataError, match=r"reach 1.7e\+308"):
        angle([1.7e308, -1.7e308, 1.0])


def test_records_of_other_types_and_layouts_are_taken() -> None:
    rate = np.random.default_rng(1).normal(size=(100, 2))
    np.testing.assert_array_equal(angle(rate[:, 0]), angle(rate[:, 0].copy()))
    whole = np.array([1, 5, 2, 8])
    np.testing.assert_array_equal(angle(whole), angle(whole.astype(float)))
    frozen = rate[:, 1].copy()
    frozen.setflags(write=False)
    np.testing.assert_array_equal(angle(frozen), angle(rate[:, 1]))


def test_each_factor_is_in_one_chain() -> None:
    factors = default_factors(9_000_000)
    chains = octave_chains(factors)
    members = [
        first << octave
        for first, octaves in zip(chains.first, chains.octaves, strict=True)
        for octave in range(octaves)
    ]
    np.testing.assert_array_equal(np.array(members)[chains.place], factors)
    assert factors.size >= 55
    assert {1, 10, 100, 1_000_000} <= set(factors.tolist())


def test_several_threads_may_compute_at_once() -> None:
    theta = angle(gyro_noise(200_000, angle_random_walk=1.0))
    factors = default_factors(theta.size - 1)
    alone = overlapping_variances(theta, factors)
    with ThreadPoolExecutor(4) as pool:
        together = list(pool.map(lambda _: overlapping_variances(theta, factors), range(8)))
    for one in together:
        np.testing.assert_array_equal(one, alone)
