"""Degrees of freedom against the scatter of simulated variances, and what the bounds cover."""

from functools import cache

import numpy as np
import pytest

from gyrotest.analysis.allan import FLAT, overlapping_allan_deviation
from gyrotest.analysis.angle import angle
from gyrotest.analysis.edf import Variance, allan_edf
from gyrotest.analysis.kernels.chains import overlapping_variances
from gyrotest.analysis.noise_type import NoiseType
from gyrotest.analysis.variances import (
    classic_variances,
    hadamard_variances,
    modified_variances,
    total_variances,
)
from tests.unit.analysis.generator import gyro_noise

SAMPLES = 512
FACTORS = np.array([8, 40, 130])
COEFFICIENTS = {
    NoiseType.ANGLE_RANDOM_WALK: {"angle_random_walk": 1.0},
    NoiseType.BIAS_INSTABILITY: {"bias_instability": 1.0},
    NoiseType.RATE_RANDOM_WALK: {"rate_random_walk": 1.0},
}
ESTIMATORS = {
    "overlapping": (overlapping_variances, Variance.ALLAN, None),
    "classic": (classic_variances, Variance.ALLAN, 1),
    "modified": (modified_variances, Variance.MODIFIED, None),
    "hadamard": (hadamard_variances, Variance.HADAMARD, None),
    "total": (total_variances, Variance.TOTAL, None),
}


@cache
def records(kind: NoiseType) -> np.ndarray:
    if kind is NoiseType.QUANTIZATION:
        return np.diff(np.random.default_rng(1).standard_normal((500, SAMPLES + 1)))
    return np.array([gyro_noise(SAMPLES, seed=seed, **COEFFICIENTS[kind]) for seed in range(500)])


def scattered_edf(kind: NoiseType, estimator: str) -> np.ndarray:
    """Twice the squared mean over the variance."""
    compute = ESTIMATORS[estimator][0]
    variances = np.array([compute(angle(rate), FACTORS) for rate in records(kind)])
    return 2.0 * variances.mean(axis=0) ** 2 / variances.var(axis=0, ddof=1)


@pytest.mark.parametrize("kind", [*COEFFICIENTS, NoiseType.QUANTIZATION])
@pytest.mark.parametrize("estimator", ["overlapping", "classic", "modified", "hadamard"])
def test_edf_is_twice_the_squared_mean_over_the_variance(kind: NoiseType, estimator: str) -> None:
    _, variance, strides = ESTIMATORS[estimator]
    edf = allan_edf(SAMPLES + 1, FACTORS, kind, variance=variance, strides=strides)
    np.testing.assert_allclose(edf, scattered_edf(kind, estimator), rtol=0.25)


@pytest.mark.parametrize("kind", list(COEFFICIENTS))
def test_a_total_variance_has_the_published_degrees_of_freedom(kind: NoiseType) -> None:
    edf = allan_edf(SAMPLES + 1, FACTORS, kind, variance=Variance.TOTAL)
    np.testing.assert_allclose(edf, scattered_edf(kind, "total"), rtol=0.25)


def test_a_total_variance_of_white_angle_noise_is_not_given_more_than_it_has() -> None:
    edf = allan_edf(SAMPLES + 1, FACTORS, NoiseType.QUANTIZATION, variance=Variance.TOTAL)
    assert np.all(edf < scattered_edf(NoiseType.QUANTIZATION, "total"))


@pytest.mark.parametrize("kind", list(NoiseType))
@pytest.mark.parametrize("variance", list(Variance))
@pytest.mark.parametrize("points", [10_001, 301, 10])
def test_edf_is_at_least_a_half_and_falls_with_averaging(
    kind: NoiseType, variance: Variance, points: int
) -> None:
    longest = (points - 1) // (3 if variance in (Variance.MODIFIED, Variance.HADAMARD) else 2)
    factors = np.unique(np.geomspace(1, longest, 12).astype(int))
    edf = allan_edf(points, factors, kind, variance=variance)
    assert np.all(edf >= 0.5)
    assert np.all(np.diff(edf) < 0.02 * edf[:-1])


@pytest.mark.parametrize("kind", list(NoiseType))
@pytest.mark.parametrize(
    ("variance", "points"), [(Variance.ALLAN, 201), (Variance.MODIFIED, 300), (Variance.HADAMARD, 301)]
)
def test_one_difference_has_one_degree_of_freedom(
    kind: NoiseType, variance: Variance, points: int
) -> None:
    assert float(allan_edf(points, 100, kind, variance=variance)) == pytest.approx(1.0, rel=1e-12)


def test_the_modified_and_the_overlapping_one_are_the_same_at_single_samples() -> None:
    for kind in NoiseType:
        modified = allan_edf(500, 1, kind, variance=Variance.MODIFIED)
        assert modified == pytest.approx(allan_edf(500, 1, kind), rel=1e-12)


@pytest.mark.parametrize("m", [82, 84, 86, 90])
@pytest.mark.parametrize("kind", list(NoiseType))
def test_the_integral_takes_over_from_the_sum_without_a_step(kind: NoiseType, m: int) -> None:
    """The sum has at most 256 terms, three an averaging factor: beyond m = 85 it is an integral."""
    curve = allan_edf(30 * m + 1, [m, m + 2, m + 4], kind) / 30.0
    assert curve[1] == pytest.approx((curve[0] + curve[2]) / 2.0, rel=2e-3)


def test_strides_may_be_any_number_and_types_differ_by_axis() -> None:
    types = np.array([[0, -1], [-2, -2]], dtype=np.int8)
    edf = allan_edf(1001, [100, 50], types, strides=[100 / 6, 16.0])
    assert edf.shape == (2, 2)
    assert edf[1, 0] == float(allan_edf(1001, 100, -2, strides=100 / 6))
    assert edf[0, 1] == float(allan_edf(1001, 50, -1, strides=16))
    full = allan_edf(1001, [100, 50], types)
    np.testing.assert_allclose(edf, full, rtol=0.03)


def test_a_factor_that_leaves_no_difference_is_refused() -> None:
    with pytest.raises(ValueError, match="averaging factor 51 needs 103 angle points, there are 101"):
        allan_edf(101, [50, 51], NoiseType.ANGLE_RANDOM_WALK)


@pytest.mark.parametrize("kind", list(COEFFICIENTS))
def test_the_bounds_cover_the_truth_as_often_as_they_say(kind: NoiseType) -> None:
    factors = [16, 40]
    curve = overlapping_allan_deviation(
        records(kind), sample_rate_hz=1.0, averaging_factors=[1, 2, 4, 8, *factors]
    ).at(factors)
    truth = {
        NoiseType.ANGLE_RANDOM_WALK: 1.0 / np.sqrt(curve.tau_s),
        NoiseType.BIAS_INSTABILITY: np.full(2, FLAT),
        NoiseType.RATE_RANDOM_WALK: np.sqrt(curve.tau_s / 3.0),
    }[kind]
    for confidence in (0.6827, 0.95):
        bounds = curve.bounds_dps(confidence)
        covered = np.mean((bounds.lower < truth) & (truth < bounds.upper), axis=0)
        np.testing.assert_allclose(covered, confidence, atol=0.06)
