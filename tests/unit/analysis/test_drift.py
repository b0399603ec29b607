"""Drift: courses told from a random walk, their shapes and their share of the Allan variances."""

import numpy as np
import pytest

from gyrotest.analysis.allan import overlapping_allan_deviation
from gyrotest.analysis.drift import Course, courses
from gyrotest.analysis.noise import Drift, DriftKind, identify_noise
from gyrotest.analysis.noise_terms import Grid
from gyrotest.analysis.slow_modes import SlowModes, slow_modes
from tests.unit.analysis.generator import gyro_noise

SAMPLES = 7200
SHARE = np.arange(SAMPLES) / SAMPLES  # of the record's length
GRID = Grid(interval_s=1.0, aperture_s=1.0)


@pytest.fixture(scope="module")
def modes() -> SlowModes:
    return slow_modes(SHARE, GRID)


def plain(course: Course, samples: int) -> np.ndarray:
    """The course itself as means over the intervals of a record."""
    edges = np.linspace(0.0, 1.0, samples + 1)
    if course.constant is None:
        return (edges[1:] + edges[:-1]) / 2.0
    return -np.diff(np.exp(-edges / course.constant)) * course.constant * samples


def noise(seed: int, **more: float) -> np.ndarray:
    truth = {"angle_random_walk": 1.0, "bias_instability": 0.02} | more
    return gyro_noise(SAMPLES, seed=seed, **truth)


def drifts(course: np.ndarray, records: int = 8, **more: float) -> list[Drift | None]:
    return [identify_noise(noise(s, **more) + course, sample_rate_hz=1.0).drift for s in range(records)]


def test_the_courses_are_a_line_and_exponentials_of_ever_longer_time_constants(modes: SlowModes) -> None:
    linear, *curved = courses(modes)
    assert linear.kind is DriftKind.LINEAR
    assert linear.constant is None
    assert all(one.kind is DriftKind.EXPONENTIAL for one in curved)
    constants = [one.constant or 0.0 for one in curved]
    assert constants == sorted(constants)
    assert constants[0] < 0.05 < 1.0 < constants[-1]


@pytest.mark.parametrize("which", [0, 1, 5, -1])
def test_a_courses_modes_are_those_of_the_course(modes: SlowModes, which: int) -> None:
    course = courses(modes)[which]
    used = 7200 // (4 * 256) * modes.blocks
    expected = slow_modes(plain(course, used), GRID)
    assert expected.blocks == modes.blocks
    scale = np.abs(expected.mode_dps).max()
    np.testing.assert_allclose(course.modes, expected.mode_dps, atol=1e-9 * scale)


@pytest.mark.parametrize("which", [0, 1, 5, -1])
def test_a_courses_share_of_the_allan_variances_is_its_own(modes: SlowModes, which: int) -> None:
    course = courses(modes)[which]
    factors = [1, 4, 50, 500, 800]
    alone = overlapping_allan_deviation(
        plain(course, SAMPLES), sample_rate_hz=1.0, averaging_factors=factors
    )
    share = course.allan_variances(np.array(factors) / SAMPLES)
    np.testing.assert_allclose(share, alone.deviation_dps**2, rtol=1e-2)


@pytest.mark.parametrize("which", [0, 1, 5, -1])
def test_the_change_is_from_begin_to_end(modes: SlowModes, which: int) -> None:
    course = courses(modes)[which]
    shape = plain(course, 1_000_000)
    assert course.change == pytest.approx(shape[-1] - shape[0], rel=1e-3)


@pytest.mark.parametrize("change", [0.6, -3.0])
def test_a_linear_drift_is_recognised_and_its_change_found(change: float) -> None:
    found = drifts(change * SHARE)
    kinds = [one.kind for one in found if one is not None]
    assert len(kinds) == len(found)
    assert kinds.count(DriftKind.LINEAR) >= len(found) - 2
    z = [
        (one.change_dps - change) / one.standard_uncertainty_dps
        for one in found
        if one is not None and one.kind is DriftKind.LINEAR
    ]
    assert abs(np.mean(z)) < 1.2
    assert max(np.abs(z)) < 4.0


@pytest.mark.parametrize("constant", [0.05, 0.2])
def test_an_exponential_drift_is_recognised_with_its_time_constant(constant: float) -> None:
    found = drifts(2.0 * np.exp(-SHARE / constant))
    assert all(one is not None and one.kind is DriftKind.EXPONENTIAL for one in found)
    constants = [one.time_constant_s or 0.0 for one in found if one is not None]
    assert np.median(constants) == pytest.approx(constant * SAMPLES, rel=0.25)
    changes = [one.change_dps for one in found if one is not None]
    assert np.median(changes) == pytest.approx(2.0 * np.expm1(-1.0 / constant), rel=0.15)


def test_noise_and_a_random_walk_are_no_drift() -> None:
    still = drifts(np.zeros(SAMPLES), records=15)
    assert sum(one is not None for one in still) <= 1
    walking = drifts(np.zeros(SAMPLES), records=15, rate_random_walk=0.02)
    assert sum(one is not None for one in walking) <= 1


@pytest.mark.parametrize(
    "course", [0.6 * SHARE, 3.0 * SHARE, 2.0 * np.exp(-SHARE / 0.1), 2.0 * np.exp(-SHARE / 0.5)]
)
def test_under_a_drift_no_random_walk_is_resolved(course: np.ndarray) -> None:
    walks = [identify_noise(noise(s) + course, sample_rate_hz=1.0).rate_random_walk for s in range(8)]
    assert sum(one.resolved for one in walks) <= 1
    assert all(one.upper_95 > 0.0 for one in walks)


def test_a_linear_drift_is_the_rate_ramp() -> None:
    model = identify_noise(noise(1) - 3.0 * SHARE, sample_rate_hz=1.0)
    assert model.drift is not None
    assert model.rate_ramp.resolved
    assert model.rate_ramp.value == pytest.approx(-model.drift.change_dps / SAMPLES, rel=0.05)
    assert model.rate_ramp.lower_95 < 3.0 / SAMPLES < model.rate_ramp.upper_95


def test_the_limit_of_a_ramp_that_is_not_there_holds_one_too_small_to_see() -> None:
    small = 0.05 / SAMPLES
    models = [identify_noise(noise(s) + 0.05 * SHARE, sample_rate_hz=1.0) for s in range(12)]
    assert sum(one.rate_ramp.upper_95 >= small for one in models) >= 11
