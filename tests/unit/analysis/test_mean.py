"""The mean's uncertainty against simulated truth."""

import numpy as np
import pytest

from gyrotest.analysis.mean import mean_uncertainty
from gyrotest.analysis.noise import identify_noise
from tests.unit.analysis.generator import DPH, gyro_noise


@pytest.mark.parametrize("since_s", [0.0, 600.0, 7800.0])
def test_the_mean_departs_from_the_bias_as_its_uncertainty_says(since_s: float) -> None:
    truth = {"angle_random_walk": 30 * DPH, "bias_instability": 8 * DPH, "rate_random_walk": 0.05 * DPH}
    z = []
    for seed in range(60):
        rate = gyro_noise(3600, seed=seed, since_power_on_s=since_s, **truth)
        model = identify_noise(rate, sample_rate_hz=1.0)
        found = mean_uncertainty(model, duration_s=3600.0, since_power_on_s=since_s)
        z.append(rate.mean() / found.standard_uncertainty_dps)
    assert abs(np.mean(z)) < 0.4
    # On the prudent side: an hour's record cannot exclude a walk that is not there.
    assert 0.55 < np.std(z, ddof=1) < 1.4


def test_a_wandering_mean_is_less_certain_than_its_samples_suggest() -> None:
    rate = gyro_noise(3600, angle_random_walk=30 * DPH, bias_instability=8 * DPH)
    model = identify_noise(rate, sample_rate_hz=1.0)
    found = mean_uncertainty(model, duration_s=3600.0)
    assert found.standard_uncertainty_dps > 5.0 * rate.std(ddof=1) / np.sqrt(rate.size)
    later = mean_uncertainty(model, duration_s=3600.0, since_power_on_s=7200.0)
    assert later.standard_uncertainty_dps >= found.standard_uncertainty_dps


def test_a_drift_spreads_the_mean() -> None:
    rate = gyro_noise(3600, angle_random_walk=30 * DPH, bias_instability=8 * DPH)
    drifting = rate - 0.5 * np.linspace(0.0, 1.0, rate.size)
    still, moved = (
        mean_uncertainty(identify_noise(one, sample_rate_hz=1.0), duration_s=3600.0)
        for one in (rate, drifting)
    )
    spread = np.sqrt(moved.standard_uncertainty_dps**2 - still.standard_uncertainty_dps**2)
    assert spread == pytest.approx(0.5 / np.sqrt(12.0), rel=0.05)
