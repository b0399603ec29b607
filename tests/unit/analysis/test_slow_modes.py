"""Slow modes: their variance under each noise is what is stated, and they are independent."""

import numpy as np
import pytest
from scipy.fft import dct

from gyrotest.analysis.noise_terms import Grid
from gyrotest.analysis.slow_modes import MOST_MODES, mode_count, slow_modes

GRID = Grid(interval_s=0.5, aperture_s=0.5)
SAMPLES = 400


def transform(samples: int) -> np.ndarray:
    """The modes as a matrix (m, n) on the samples, found column by column of unit impulses."""
    return np.column_stack([slow_modes(one, GRID).mode_dps for one in np.eye(samples)])


@pytest.fixture(scope="module")
def matrix() -> np.ndarray:
    return transform(SAMPLES)


@pytest.fixture(scope="module")
def stated() -> np.ndarray:
    return slow_modes(np.arange(float(SAMPLES)), GRID).variance


def test_modes_of_white_noise_have_exactly_the_stated_covariance(
    matrix: np.ndarray, stated: np.ndarray
) -> None:
    covariance = matrix @ matrix.T / GRID.interval_s
    np.testing.assert_allclose(covariance, np.diag(stated[:, 1]), atol=1e-12)


def test_modes_of_a_random_walk_are_uncorrelated_and_have_the_stated_variance(
    matrix: np.ndarray, stated: np.ndarray
) -> None:
    """The walk's means over the intervals: covariance min(s, t), less a sixth of an interval."""
    count, p = SAMPLES, GRID.interval_s
    begin = np.arange(count)
    walk = p * (np.minimum.outer(begin, begin) + 0.5 - np.eye(count) / 6.0)
    covariance = matrix @ walk @ matrix.T
    np.testing.assert_allclose(np.diag(covariance), stated[:, 3], rtol=1e-9)
    scale = np.sqrt(np.outer(stated[:, 3], stated[:, 3]))
    np.testing.assert_allclose(covariance / scale, np.eye(len(stated)), atol=1e-9)


def test_modes_of_flicker_noise_are_nearly_uncorrelated(matrix: np.ndarray, stated: np.ndarray) -> None:
    """Covariance −ln|t|/π of momentary values, averaged over intervals; a constant in it drops out."""
    t = np.arange(SAMPLES) * GRID.interval_s
    a = GRID.interval_s

    def twice(x: np.ndarray) -> np.ndarray:
        return 0.5 * x**2 * np.log(np.maximum(np.abs(x), 1e-300)) - 0.75 * x**2

    lag = -(twice(t + a) - 2.0 * twice(t) + twice(t - a)) / (np.pi * a**2)
    place = np.arange(SAMPLES)
    covariance = matrix @ lag[np.abs(np.subtract.outer(place, place))] @ matrix.T
    ratio = np.diag(covariance) / stated[:, 2]
    assert ratio == pytest.approx(1.0, abs=0.03)
    assert ratio[1:] == pytest.approx(1.0, abs=0.006)
    spread = np.sqrt(np.diag(covariance))
    correlation = covariance / np.outer(spread, spread) - np.eye(len(spread))
    assert np.abs(correlation).max() < 0.13


def test_modes_of_quantization_noise_have_nearly_the_stated_variance() -> None:
    """Differences of white angle noise; the ends of the record add what no mode of it knows."""
    matrix = transform(SAMPLES)
    differences = np.diff(np.eye(SAMPLES + 1), axis=0) / GRID.interval_s
    variance = np.diag(matrix @ differences @ differences.T @ matrix.T)
    stated = slow_modes(np.arange(float(SAMPLES)), GRID).variance[:, 0]
    assert variance[-1] == pytest.approx(stated[-1], rel=0.1)


def test_modes_are_the_cosine_transform_of_the_block_means() -> None:
    rate = np.random.default_rng(1).standard_normal(10_007)
    modes = slow_modes(rate, GRID)
    size = 10_007 // 1024
    means = rate[: 10_007 // size * size].reshape(-1, size).mean(axis=1)
    assert modes.blocks == means.size
    assert modes.duration_s == pytest.approx(means.size * size * GRID.interval_s)
    np.testing.assert_allclose(modes.mode_dps, dct(means, norm="ortho")[1:257], atol=1e-12)
    assert modes.of_course(means) == pytest.approx(modes.mode_dps)


def test_an_offset_is_no_mode() -> None:
    rate = np.random.default_rng(1).standard_normal(4096)
    with_offset = slow_modes(rate + 1e6, GRID).mode_dps
    np.testing.assert_allclose(with_offset, slow_modes(rate, GRID).mode_dps, atol=1e-7)


def test_a_record_backwards_has_the_same_modes_but_for_signs() -> None:
    rate = np.random.default_rng(1).standard_normal(4096)
    found = slow_modes(rate[::-1], GRID).mode_dps
    np.testing.assert_allclose(np.abs(found), np.abs(slow_modes(rate, GRID).mode_dps), atol=1e-12)


@pytest.mark.parametrize(
    ("samples", "modes"), [(1, 1), (36, 9), (1000, 250), (1024, MOST_MODES), (10**7, MOST_MODES)]
)
def test_a_quarter_of_the_samples_are_modes_and_at_most_256(samples: int, modes: int) -> None:
    assert mode_count(samples) == modes


def test_the_fastest_modes_can_be_left_out() -> None:
    modes = slow_modes(np.random.default_rng(1).standard_normal(4096), GRID)
    fewer = modes.slowest(64)
    assert fewer.mode_dps.tolist() == modes.mode_dps[:64].tolist()
    assert fewer.variance.shape == (64, 4)
    assert fewer.first_tau_s == pytest.approx(4.0 * modes.first_tau_s)
