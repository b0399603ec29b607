"""Noise identification: truths recovered with honest uncertainties; what spoils a record."""

import numpy as np
import pytest

from gyrotest.analysis.allan import overlapping_allan_deviation
from gyrotest.analysis.noise import NoiseModel, fitted_factors, identify_noise
from gyrotest.analysis.noise_terms import Grid, allan_columns, allan_response, spectrum_columns
from gyrotest.errors import InsufficientDataError
from tests.unit.analysis.generator import DPH, gyro_noise


def identified(seed: int, samples: int = 3600, **truth: float) -> NoiseModel:
    return identify_noise(gyro_noise(samples, seed=seed, **truth), sample_rate_hz=1.0)


def test_angle_random_walk_and_bias_instability_are_recovered_within_their_uncertainty() -> None:
    truth = {"angle_random_walk": 30 * DPH, "bias_instability": 8 * DPH, "rate_random_walk": 0.05 * DPH}
    models = [identified(seed, **truth) for seed in range(60)]
    walks = [model.angle_random_walk for model in models]
    z = [(one.value - truth["angle_random_walk"]) / one.standard_uncertainty for one in walks]
    assert abs(np.mean(z)) < 0.4
    assert 0.75 < np.std(z, ddof=1) < 1.3
    flickers = [model.bias_instability_coefficient for model in models]
    covered = [one.lower_95 <= truth["bias_instability"] <= one.upper_95 for one in flickers]
    assert sum(covered) >= 53
    assert all(one.resolved for one in walks)


def test_an_unresolved_term_has_an_upper_limit_that_holds() -> None:
    models = [identified(seed, angle_random_walk=30 * DPH) for seed in range(40)]
    walks = [model.rate_random_walk for model in models]
    assert all(one.upper_95 > 0.0 for one in walks)
    assert sum(one.resolved for one in walks) <= 4
    assert all(one.lower_95 == 0.0 for one in walks if not one.resolved)


def test_a_strong_rate_random_walk_is_resolved() -> None:
    model = identified(3, samples=36_000, angle_random_walk=30 * DPH, rate_random_walk=5 * DPH)
    walk = model.rate_random_walk
    assert walk.resolved
    assert walk.lower_95 < 5 * DPH < walk.upper_95


def test_dead_time_inflates_the_apparent_walk_only() -> None:
    fine = gyro_noise(6 * 36_000, interval_s=1 / 6, angle_random_walk=30 * DPH, seed=5)
    coarse = fine.reshape(-1, 6)[:, 0]
    model = identify_noise(coarse, sample_rate_hz=1.0, duty=1 / 6)
    assert model.angle_random_walk.value == pytest.approx(30 * DPH * np.sqrt(6.0), rel=0.02)


def test_a_low_pass_filter_is_kept_out_of_the_fit() -> None:
    found = []
    for seed in range(6):
        fine = gyro_noise(200_000, interval_s=0.01, angle_random_walk=0.04, seed=seed)
        filtered = np.convolve(fine, np.ones(5) / 5.0, mode="valid")
        model = identify_noise(filtered, sample_rate_hz=100.0)
        assert model.first_tau_s > 0.05
        found.append(model.angle_random_walk.value)
    # At the shortest time the filter leaves 0.008.
    assert np.mean(found) == pytest.approx(0.04, rel=0.03)


def test_a_curve_at_hand_gives_the_same_model() -> None:
    rate = gyro_noise(3600, angle_random_walk=1.0, bias_instability=0.3)
    wanted = np.union1d(fitted_factors(3600), [7, 77])
    curve = overlapping_allan_deviation(rate, sample_rate_hz=1.0, averaging_factors=wanted.tolist())
    given = identify_noise(rate, sample_rate_hz=1.0, deviation=curve)
    assert given.squares.tolist() == identify_noise(rate, sample_rate_hz=1.0).squares.tolist()


def test_the_fitted_curve_runs_through_the_points() -> None:
    rate = gyro_noise(36_000, angle_random_walk=1.0, bias_instability=0.3)
    model = identify_noise(rate, sample_rate_hz=1.0)
    curve = overlapping_allan_deviation(rate, sample_rate_hz=1.0, averaging_factors=[1, 10, 100])
    fitted = model.allan_deviation_dps(curve.averaging_factor)
    np.testing.assert_allclose(fitted, curve.deviation_dps, rtol=0.1)
    assert model.misfit < 3.0


@pytest.mark.parametrize("duty", [1.0, 0.6, 0.2])
def test_each_allan_variance_is_its_spectrum_under_the_response(duty: float) -> None:
    grid = Grid(interval_s=0.5, aperture_s=0.5 * duty)
    factors = np.array([1, 2, 5, 30])
    edges = np.geomspace(1e-6, 1.0, 40_001)
    middle = np.sqrt(edges[1:] * edges[:-1])
    response = allan_response(middle, factors, grid) * np.diff(edges)
    expected = response @ spectrum_columns(middle, grid)
    columns = allan_columns(factors, grid)
    np.testing.assert_allclose(columns[:, :2], expected[:, :2], rtol=2e-3)
    np.testing.assert_allclose(columns[:, 2:4], expected[:, 2:4], rtol=2e-2)


@pytest.mark.parametrize("samples", [2, 35])
def test_a_short_record_is_refused(samples: int) -> None:
    with pytest.raises(InsufficientDataError, match=f"has {samples} samples; a noise model needs"):
        identify_noise(np.arange(float(samples)), sample_rate_hz=1.0)


def test_the_shortest_record_is_enough() -> None:
    assert identified(1, samples=36, angle_random_walk=1.0).angle_random_walk.upper_95 > 0.5
