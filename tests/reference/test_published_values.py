"""Published values: the 1000-point set of NIST SP 1065 (section 12.4), its 10-point set, Stable32."""

import numpy as np
import pytest

from gyrotest.analysis.allan import (
    allan_deviation,
    hadamard_deviation,
    modified_allan_deviation,
    overlapping_allan_deviation,
    total_deviation,
)
from gyrotest.analysis.edf import allan_edf
from gyrotest.analysis.noise_type import NoiseType

TEN_FREQUENCIES = [892.0, 809.0, 823.0, 798.0, 671.0, 644.0, 883.0, 903.0, 677.0]


def thousand_frequencies() -> np.ndarray:
    number, values = 1234567890, []
    for _ in range(1000):
        values.append(number / 2147483647)
        number = 16807 * number % 2147483647
    return np.array(values)


def test_the_generator_gives_the_published_numbers() -> None:
    first = thousand_frequencies()[1:4] * 2147483647
    np.testing.assert_allclose(first, [395529916, 1209410747, 633705974], rtol=1e-12)


@pytest.mark.parametrize(
    ("estimator", "published"),
    [
        (allan_deviation, [2.922319e-01, 9.965736e-02, 3.897804e-02]),
        (overlapping_allan_deviation, [2.922319e-01, 9.159953e-02, 3.241343e-02]),
        (modified_allan_deviation, [2.922319e-01, 6.172376e-02, 2.170921e-02]),
        (hadamard_deviation, [2.943883e-01, 9.581083e-02, 3.237638e-02]),
        (total_deviation, [2.922319e-01, 9.134743e-02, 3.406530e-02]),
    ],
)
def test_the_thousand_point_set_at_its_published_digits(estimator, published: list[float]) -> None:
    curve = estimator(thousand_frequencies(), sample_rate_hz=1.0, averaging_factors=[1, 10, 100])
    assert [f"{one:.6e}" for one in curve.deviation_dps] == [f"{one:.6e}" for one in published]


@pytest.mark.parametrize(
    ("estimator", "published"),
    [
        (allan_deviation, [91.22945, 115.8082]),
        (overlapping_allan_deviation, [91.22945, 85.95287]),
        (modified_allan_deviation, [91.22945, 74.78849]),
        (hadamard_deviation, [70.80607, 85.61487]),
        (total_deviation, [91.22945, 93.90379]),
    ],
)
def test_the_ten_point_set_at_its_published_digits(estimator, published: list[float]) -> None:
    curve = estimator(TEN_FREQUENCIES, sample_rate_hz=1.0, averaging_factors=[1, 2])
    assert [f"{one:.7g}" for one in curve.deviation_dps] == [f"{one:.7g}" for one in published]


def test_time_deviation_follows_from_the_modified_one_at_its_published_digits() -> None:
    curve = modified_allan_deviation(
        thousand_frequencies(), sample_rate_hz=1.0, averaging_factors=[1, 10, 100]
    )
    time = curve.tau_s / np.sqrt(3.0) * curve.deviation_dps
    assert [f"{one:.6e}" for one in time] == ["1.687202e-01", "3.563623e-01", "1.253382e+00"]


@pytest.mark.parametrize(
    ("m", "lower", "deviation", "upper"),
    [
        (1, 2.8515e-01, 2.922319e-01, 2.9987e-01),
        (64, 3.1755e-02, 3.6237e-02, 4.3377e-02),
        (128, 2.3045e-02, 2.7674e-02, 3.7027e-02),
    ],
)
def test_intervals_are_those_of_stable32(m: int, lower: float, deviation: float, upper: float) -> None:
    curve = overlapping_allan_deviation(
        thousand_frequencies(), sample_rate_hz=1.0, averaging_factors=[m]
    )
    bounds = curve.bounds_dps(0.683)
    assert curve.deviation_dps[0] == pytest.approx(deviation, rel=5e-5)
    assert bounds.lower[0] == pytest.approx(lower, rel=5e-4)
    assert bounds.upper[0] == pytest.approx(upper, rel=5e-4)


def test_the_degrees_of_freedom_behind_those_intervals() -> None:
    edf = allan_edf(1001, [1, 64, 128], NoiseType.ANGLE_RANDOM_WALK)
    np.testing.assert_allclose(edf, [782.03, 21.24, 9.55], rtol=5e-4)
