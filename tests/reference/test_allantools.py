"""Allan deviations against allantools, to 1e-10 relative."""

import numpy as np
import pytest

from gyrotest.analysis.allan import allan_deviation, overlapping_allan_deviation
from tests.unit.analysis.generator import gyro_noise

allantools = pytest.importorskip("allantools")

RECORDS = {
    "white": {"angle_random_walk": 1.0},
    "flicker": {"bias_instability": 1.0},
    "walk": {"rate_random_walk": 1.0},
}


@pytest.mark.parametrize("noise", list(RECORDS))
@pytest.mark.parametrize("size", [8, 997, 1000, 30_001])
def test_both_estimators_equal_allantools(noise: str, size: int) -> None:
    rate = gyro_noise(size, **RECORDS[noise])
    factors = [m for m in (1, 2, 3, 10, 111, 3000) if 3 * m <= size]
    taus = np.array(factors) / 5.0
    for ours, theirs in (
        (overlapping_allan_deviation, allantools.oadev),
        (allan_deviation, allantools.adev),
    ):
        expected = theirs(rate, rate=5.0, data_type="freq", taus=taus)[1]
        found = ours(rate, sample_rate_hz=5.0, averaging_factors=factors)
        np.testing.assert_allclose(found.deviation_dps, expected, rtol=1e-10)
