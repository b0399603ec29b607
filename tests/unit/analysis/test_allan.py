"""Allan deviation: known answers, properties, refusals."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from gyrotest.analysis.allan import (
    allan_deviation,
    default_factors,
    log_spaced_factors,
    overlapping_allan_deviation,
)
from gyrotest.errors import InsufficientDataError
from tests.unit.analysis.generator import gyro_noise

records = st.lists(st.floats(-100.0, 100.0), min_size=9, max_size=60).filter(
    lambda values: max(values) - min(values) > 1e-3
)


def plain_overlapping(rate: np.ndarray, m: int) -> float:
    """The definition, over all pairs of adjacent group means."""
    means = [rate[k : k + m].mean() for k in range(rate.size - m + 1)]
    squares = [(means[k + m] - means[k]) ** 2 for k in range(rate.size - 2 * m + 1)]
    return float(np.sqrt(np.mean(squares) / 2.0))


def plain_classic(rate: np.ndarray, m: int) -> float:
    groups = rate[: rate.size // m * m].reshape(-1, m).mean(axis=1)
    return float(np.sqrt(np.mean(np.diff(groups) ** 2) / 2.0))


@pytest.mark.parametrize("size", [36, 37, 101, 20001])
def test_the_overlapping_estimator_equals_its_definition(size: int) -> None:
    rate = gyro_noise(size, angle_random_walk=1.0, rate_random_walk=0.1) + 1e4
    curve = overlapping_allan_deviation(rate, sample_rate_hz=4.0, averaging_factors=[1, 3, size // 2])
    expected = [plain_overlapping(rate - 1e4, int(m)) for m in curve.averaging_factor]
    np.testing.assert_allclose(curve.deviation_dps, expected, rtol=1e-9)
    np.testing.assert_allclose(curve.tau_s, curve.averaging_factor / 4.0)
    assert curve.n_differences.tolist() == [size - 1, size - 5, size - 2 * (size // 2) + 1]


@pytest.mark.parametrize("size", [36, 37, 101, 20001])
def test_the_classic_estimator_drops_the_tail_and_divides_by_the_differences(size: int) -> None:
    rate = gyro_noise(size, angle_random_walk=1.0)
    curve = allan_deviation(rate, sample_rate_hz=1.0, averaging_factors=[1, 5, 17])
    expected = [plain_classic(rate, int(m)) for m in curve.averaging_factor]
    np.testing.assert_allclose(curve.deviation_dps, expected, rtol=1e-9)
    assert curve.n_differences.tolist() == [size // m - 1 for m in (1, 5, 17)]


def test_white_rate_noise_gives_minus_half_slope() -> None:
    rate = gyro_noise(200_000, angle_random_walk=0.01)
    curve = overlapping_allan_deviation(rate, sample_rate_hz=1.0, averaging_factors=[1, 10, 100])
    np.testing.assert_allclose(curve.deviation_dps * np.sqrt(curve.tau_s), 0.01, rtol=0.05)


def test_a_rate_ramp_gives_slope_one() -> None:
    rate = 0.5 * np.arange(1000.0)
    curve = overlapping_allan_deviation(rate, sample_rate_hz=1.0)
    np.testing.assert_allclose(curve.deviation_dps, 0.5 * curve.tau_s / np.sqrt(2.0), rtol=1e-9)


@settings(max_examples=40, deadline=None)
@given(values=records, scale=st.floats(0.1, 1000.0), offset=st.floats(-1e3, 1e3))
def test_scale_passes_through_and_offset_and_direction_of_time_do_not_matter(
    values: list[float], scale: float, offset: float
) -> None:
    rate = np.array(values)
    curve = overlapping_allan_deviation(rate, sample_rate_hz=1.0)
    for changed in (scale * rate + offset, (scale * rate)[::-1]):
        other = overlapping_allan_deviation(changed, sample_rate_hz=1.0)
        np.testing.assert_allclose(
            other.deviation_dps, scale * curve.deviation_dps, rtol=1e-6, atol=1e-6 * scale
        )


def test_a_large_offset_costs_no_digits() -> None:
    rate = gyro_noise(300_000, angle_random_walk=1e-4)
    plain = overlapping_allan_deviation(rate, sample_rate_hz=1.0)
    offset = overlapping_allan_deviation(rate + 2.5, sample_rate_hz=1.0)
    np.testing.assert_allclose(offset.deviation_dps, plain.deviation_dps, rtol=1e-9)


def test_default_factors_are_ten_a_decade_up_to_a_ninth() -> None:
    factors = default_factors(9000)
    assert factors[0] == 1
    assert factors[-1] == 1000
    assert np.all(np.diff(factors) > 0)
    assert np.count_nonzero((factors >= 100) & (factors < 1000)) == 10
    assert log_spaced_factors(7, per_decade=10).tolist() == [1, 2, 3, 4, 5, 6, 7]


def test_bounds_enclose_the_deviation_and_widen_with_confidence() -> None:
    curve = overlapping_allan_deviation(gyro_noise(900, angle_random_walk=1.0), sample_rate_hz=1.0)
    wide = curve.bounds_dps(0.95)
    assert np.all(wide.lower < curve.lower_dps)
    assert np.all(curve.lower_dps < curve.deviation_dps)
    assert np.all(curve.deviation_dps < curve.upper_dps)
    assert np.all(curve.upper_dps < wide.upper)


def test_the_record_is_read_only_and_part_of_a_curve_can_be_taken() -> None:
    curve = overlapping_allan_deviation(gyro_noise(900, angle_random_walk=1.0), sample_rate_hz=1.0)
    with pytest.raises(ValueError, match="read-only"):
        curve.deviation_dps[0] = 0.0
    part = curve.at(np.array([1, 100]))
    assert part.averaging_factor.tolist() == [1, 100]
    assert part.deviation_dps[1] == curve.deviation_dps[-1]


@pytest.mark.parametrize(
    ("values", "message"),
    [
        ([], "has 0 samples"),
        ([1.0], "has 1 samples"),
        ([1.0, 2.0, 3.0, 4.0], "at least 9 groups"),
        ([3.0] * 20, "all 20 samples are 3"),
        ([1.0, 2.0] * 9 + [float("nan"), float("inf")], r"sample 18 is nan \(2 of 20"),
        ([1.0, float("-inf")] + [0.0] * 9, "sample 1 is -inf"),
    ],
)
def test_too_little_or_unusable_data_is_refused(values: list[float], message: str) -> None:
    for estimator in (overlapping_allan_deviation, allan_deviation):
        with pytest.raises(InsufficientDataError, match=message):
            estimator(values, sample_rate_hz=1.0)


def test_two_samples_are_right_and_more_than_there_are_is_refused() -> None:
    curve = overlapping_allan_deviation([1.0, 3.0], sample_rate_hz=1.0, averaging_factors=[1])
    assert curve.deviation_dps[0] == pytest.approx(np.sqrt(2.0))
    with pytest.raises(InsufficientDataError, match="averaging 2 samples needs at least 4"):
        overlapping_allan_deviation([1.0, 3.0, 2.0], sample_rate_hz=1.0, averaging_factors=[2])
    with pytest.raises(ValueError, match="positive"):
        overlapping_allan_deviation([1.0, 3.0], sample_rate_hz=1.0, averaging_factors=[0])
