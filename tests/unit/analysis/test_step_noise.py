"""The noise of step means: what short steps tell of how far their means lie apart."""

import numpy as np
import pytest

from gyrotest.analysis.noise_terms import FLICKER, Grid
from gyrotest.analysis.step_noise import LikeSteps, StepNoise, mean_covariances, step_noise
from gyrotest.errors import InsufficientDataError
from tests.unit.analysis.generator import gyro_noise

GRID = Grid(interval_s=0.1, aperture_s=0.1)
BEGINS = 15.0 * np.arange(12)
LENGTHS = np.full(12, 10.0)


def cut(noise: np.ndarray) -> list[np.ndarray]:
    return [noise[int(10 * begin) : int(10 * begin) + 100] for begin in BEGINS]


def found_in(noise: np.ndarray) -> tuple[StepNoise, np.ndarray]:
    steps = cut(noise)
    means = np.array([one.mean() for one in steps])
    ends = [0, 11]
    like = LikeSteps(means=means[ends], begins_s=BEGINS[ends], durations_s=LENGTHS[ends])
    return step_noise(steps, GRID, like=like), means


def test_white_noise_is_found_and_means_are_independent() -> None:
    squares = [
        found_in(gyro_noise(1800, interval_s=0.1, angle_random_walk=0.01, seed=seed))[0].squares[1]
        for seed in range(20)
    ]
    assert np.mean(squares) == pytest.approx(1e-4, rel=0.1)
    white = mean_covariances(BEGINS, LENGTHS)[1]
    assert white == pytest.approx(np.eye(12) / 10.0)


def test_the_mean_of_one_step_has_the_allan_variance_that_a_mean_is_given() -> None:
    q, n, b, k = mean_covariances(np.zeros(1), np.full(1, 10.0), since_s=50.0)[:, 0, 0]
    assert (q, n, b) == pytest.approx((0.03, 0.1, FLICKER))
    assert k == pytest.approx(10.0 / 3.0 + 50.0)


@pytest.mark.parametrize(
    "noise",
    [
        {"angle_random_walk": 0.01},
        {"angle_random_walk": 0.005, "bias_instability": 0.01},
        {"angle_random_walk": 0.005, "bias_instability": 0.002, "rate_random_walk": 0.0003},
    ],
)
def test_differences_of_means_spread_as_predicted(noise: dict[str, float]) -> None:
    weights = np.resize((1.0, -1.0), 12) / 12.0
    scores = []
    for seed in range(60):
        found, means = found_in(gyro_noise(1800, interval_s=0.1, seed=seed, **noise))
        per_square = np.einsum("i,kij,j->k", weights, mean_covariances(BEGINS, LENGTHS), weights)
        scores.append(float(weights @ means) / np.sqrt(found.variance(per_square).value))
    assert 0.6 < np.std(scores) < 1.3


def test_flicker_between_steps_is_not_understated_by_independence() -> None:
    noise = gyro_noise(1800, interval_s=0.1, angle_random_walk=0.001, bias_instability=0.01, seed=5)
    found, means = found_in(noise)
    naive = np.mean([one.std(ddof=1) for one in cut(noise)]) / np.sqrt(100.0)
    assert means.std(ddof=1) > 3.0 * naive
    assert np.sqrt(found.of_mean(10.0).value) > 3.0 * naive


@pytest.mark.parametrize(
    ("steps", "message"),
    [
        ([np.zeros(7)], "at least 8"),
        ([np.ones(100), np.zeros(100)], "all the same"),
        ([], "a step of 0 samples"),
    ],
)
def test_too_little_is_refused(steps: list[np.ndarray], message: str) -> None:
    with pytest.raises(InsufficientDataError, match=message):
        step_noise(steps, GRID)
