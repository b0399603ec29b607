"""Every estimator against allantools, to 1e-10 relative."""

import numpy as np
import pytest

from gyrotest.analysis.allan import (
    allan_deviation,
    hadamard_deviation,
    modified_allan_deviation,
    overlapping_allan_deviation,
    total_deviation,
)
from tests.unit.analysis.generator import gyro_noise

allantools = pytest.importorskip("allantools")

RECORDS = {
    "white": {"angle_random_walk": 1.0},
    "flicker": {"bias_instability": 1.0},
    "walk": {"rate_random_walk": 1.0},
}
ESTIMATORS = [
    (overlapping_allan_deviation, "oadev"),
    (allan_deviation, "adev"),
    (modified_allan_deviation, "mdev"),
    (hadamard_deviation, "ohdev"),
    (total_deviation, "totdev"),
]


@pytest.mark.parametrize(("estimator", "theirs"), ESTIMATORS, ids=[name for _, name in ESTIMATORS])
@pytest.mark.parametrize("noise", list(RECORDS))
@pytest.mark.parametrize("size", [8, 997, 1000, 1001, 9001])
def test_every_estimator_equals_allantools(estimator, theirs: str, noise: str, size: int) -> None:
    rate = gyro_noise(size, **RECORDS[noise])
    factors = [m for m in (1, 2, 3, 10, 111, 3000) if 3 * m <= size]
    expected = getattr(allantools, theirs)(
        rate, rate=5.0, data_type="freq", taus=np.array(factors) / 5.0
    )
    found = estimator(rate, sample_rate_hz=5.0, averaging_factors=factors)
    np.testing.assert_allclose(found.tau_s, expected[0])
    np.testing.assert_allclose(found.deviation_dps, expected[1], rtol=1e-10)


def test_the_modified_estimator_keeps_its_digits_on_a_long_walk() -> None:
    """There allantools loses them (7e-10), so that extended precision is the judge."""
    rate = gyro_noise(30_001, rate_random_walk=1.0)
    found = modified_allan_deviation(rate, sample_rate_hz=1.0, averaging_factors=[1, 3, 111])
    exact = rate.astype(np.longdouble)
    theta = np.concatenate(([0.0], np.cumsum(exact - exact.mean())))
    for m, deviation in zip((1, 3, 111), found.deviation_dps, strict=True):
        second = theta[2 * m :] - 2 * theta[m:-m] + theta[: -2 * m]
        summed = np.concatenate(([0.0], np.cumsum(second)))
        expected = np.sqrt(np.mean((summed[m:] - summed[:-m]) ** 2) / (2.0 * m**4))
        assert deviation == pytest.approx(float(expected), rel=1e-12)
