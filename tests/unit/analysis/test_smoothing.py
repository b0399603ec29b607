"""Bias stability by smoothing: its value, and an interval that holds the truth."""

import numpy as np
import pytest

from gyrotest.analysis.noise import identify_noise
from gyrotest.analysis.smoothing import smoothed_deviation, smoothed_edf
from gyrotest.errors import InsufficientDataError
from tests.unit.analysis.generator import DPH, gyro_noise

TRUTH = {"angle_random_walk": 30 * DPH, "bias_instability": 8 * DPH, "rate_random_walk": 0.2 * DPH}


def expected_variance(count: int, covariance: np.ndarray) -> float:
    centre = np.eye(count) - 1.0 / count
    return float(np.trace(centre @ covariance) / (count - 1))


def exact_edf(covariance: np.ndarray) -> float:
    count = covariance.shape[0]
    centre = np.eye(count) - 1.0 / count
    inner = centre @ covariance @ centre
    return float(np.trace(inner) ** 2 / np.sum(inner * inner))


def test_the_value_is_the_sample_deviation_of_the_averages() -> None:
    rate = gyro_noise(107, angle_random_walk=1.0)
    model = identify_noise(rate, sample_rate_hz=2.0)
    found = smoothed_deviation(rate, samples_per_average=10, model=model)
    averages = [rate[k : k + 10].mean() for k in range(0, 100, 10)]
    assert found.deviation_dps == pytest.approx(np.std(averages, ddof=1))
    assert (found.averages, found.smoothing_s) == (10, 5.0)


@pytest.mark.parametrize("count", [2, 7, 36, 400])
def test_white_averages_have_one_less_degree_of_freedom_than_averages(count: int) -> None:
    edf = smoothed_edf(count, smoothing_s=10.0, squares=np.array([0.0, 1.0, 0.0, 0.0, 0.0]))
    assert edf == pytest.approx(count - 1)


@pytest.mark.parametrize("count", [7, 36, 200])
def test_a_random_walk_has_its_exact_degrees_of_freedom(count: int) -> None:
    step = np.arange(count)
    walk = np.minimum(step[:, None], step[None, :]) * 10.0
    walk += 10.0 * (1 / 2 - np.eye(count) / 6)  # averaged over the steps
    edf = smoothed_edf(count, smoothing_s=10.0, squares=np.array([0.0, 0.0, 0.0, 1.0, 0.0]))
    assert edf == pytest.approx(exact_edf(walk), rel=0.05)


def test_a_very_long_record_is_thinned_without_harm() -> None:
    squares = np.array([0.0, 1.0, 0.01, 1e-9, 0.0])
    count = 50_000
    modes = np.arange(1, count)
    from gyrotest.analysis.noise_terms import Grid, spectrum_columns

    power = spectrum_columns(modes / (2.0 * count), Grid(interval_s=1.0, aperture_s=1.0)) @ squares
    full = power.sum() ** 2 / (power**2).sum()
    assert smoothed_edf(count, smoothing_s=1.0, squares=squares) == pytest.approx(full, rel=1e-3)


def test_intervals_hold_the_expected_deviation() -> None:
    runs = [gyro_noise(3600, seed=seed, since_power_on_s=600.0, **TRUTH) for seed in range(60)]
    models = [identify_noise(run, sample_rate_hz=1.0) for run in runs[:30]]
    for factor in (1, 10, 100):
        spreads = [np.var(run.reshape(-1, factor).mean(axis=1), ddof=1) for run in runs]
        truth = np.sqrt(np.mean(spreads))
        found = [
            smoothed_deviation(run, samples_per_average=factor, model=model)
            for run, model in zip(runs[:30], models, strict=True)
        ]
        assert sum(one.lower_95_dps <= truth <= one.upper_95_dps for one in found) >= 26


def test_fewer_than_two_averages_are_refused() -> None:
    rate = gyro_noise(100, angle_random_walk=1.0)
    model = identify_noise(rate, sample_rate_hz=1.0)
    with pytest.raises(InsufficientDataError, match="give 1 averages"):
        smoothed_deviation(rate, samples_per_average=60, model=model)
