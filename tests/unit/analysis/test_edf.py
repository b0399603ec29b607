"""Degrees of freedom against the scatter of simulated Allan variances."""

import numpy as np
import pytest

from gyrotest.analysis.allan import allan_deviation, overlapping_allan_deviation
from gyrotest.analysis.edf import allan_edf
from gyrotest.analysis.noise_type import NoiseType
from tests.unit.analysis.generator import gyro_noise


@pytest.mark.parametrize(
    ("kind", "coefficients"),
    [
        (NoiseType.ANGLE_RANDOM_WALK, {"angle_random_walk": 1.0}),
        (NoiseType.BIAS_INSTABILITY, {"bias_instability": 1.0}),
        (NoiseType.RATE_RANDOM_WALK, {"rate_random_walk": 1.0}),
    ],
)
@pytest.mark.parametrize(("m", "overlapping"), [(8, True), (40, True), (8, False)])
def test_edf_is_twice_the_squared_mean_over_the_variance(
    kind: NoiseType, coefficients: dict[str, float], m: int, overlapping: bool
) -> None:
    estimator = overlapping_allan_deviation if overlapping else allan_deviation
    variances = np.array(
        [
            estimator(
                gyro_noise(512, seed=seed, **coefficients), sample_rate_hz=1.0, averaging_factors=[m]
            ).deviation_dps[0]
            ** 2
            for seed in range(400)
        ]
    )
    scatter = 2.0 * variances.mean() ** 2 / variances.var(ddof=1)
    assert allan_edf(513, m, kind, strides=None if overlapping else 1) == pytest.approx(
        scatter, rel=0.25
    )


@pytest.mark.parametrize("kind", list(NoiseType))
@pytest.mark.parametrize("overlapping", [True, False])
def test_edf_is_positive_and_falls_with_averaging(kind: NoiseType, overlapping: bool) -> None:
    edf = [
        allan_edf(10_001, m, kind, strides=None if overlapping else 1)
        for m in (1, 10, 100, 1000, 3000, 5000)
    ]
    assert all(one > 0.5 for one in edf)
    # White angle noise apart, fewer independent groups are left.
    assert edf[-1] < edf[2]
