"""A noise model: its curve is the sum of its terms, and each term carries where it rules."""

import numpy as np
import pytest

from gyrotest.analysis.noise import NoiseModel, identify_noise
from gyrotest.analysis.noise_model import TauRange, carried_range
from tests.unit.analysis.generator import gyro_noise


@pytest.fixture(scope="module")
def model() -> NoiseModel:
    rate = gyro_noise(
        36_000, angle_random_walk=1.0, bias_instability=0.1, rate_random_walk=0.002, seed=4
    )
    return identify_noise(rate, sample_rate_hz=2.0)


FACTORS = np.array([1, 7, 100, 4000])


def test_the_curve_is_the_root_sum_of_squares_of_its_components(model: NoiseModel) -> None:
    components = model.components_dps(FACTORS)
    assert components.shape == (5, 4)
    curve = np.sqrt(np.sum(components**2, axis=0))
    np.testing.assert_allclose(model.allan_deviation_dps(FACTORS), curve, rtol=1e-12)


def test_each_component_has_its_slope(model: NoiseModel) -> None:
    components = model.components_dps(np.array([10, 1000]))
    slopes = [float(np.log10(two / one) / 2.0) for one, two in components if one > 0.0]
    allowed = np.array([-1.0, -0.5, 0.0, 0.5, 1.0])
    assert all(np.abs(allowed - one).min() < 1e-9 for one in slopes)
    white = model.components_dps(np.array([10, 1000]))[1]
    assert white[0] / white[1] == pytest.approx(10.0)


def test_the_squares_are_those_of_the_terms(model: NoiseModel) -> None:
    assert model.squares.tolist() == [one.value**2 for one in model.terms]
    prudent = model.prudent_squares
    assert prudent[3] > model.squares[3]
    assert prudent[[0, 1, 2, 4]].tolist() == model.squares[[0, 1, 2, 4]].tolist()


def test_the_covariance_is_symmetric_and_read_only(model: NoiseModel) -> None:
    covariance = model.covariance
    assert covariance.shape == (5, 5)
    np.testing.assert_allclose(covariance, covariance.T, rtol=1e-9)
    assert (np.diag(covariance)[:4] > 0.0).all()
    assert not covariance.flags.writeable


def test_angle_random_walk_carries_the_short_times_and_flicker_the_middle(model: NoiseModel) -> None:
    white, flicker = model.angle_random_walk.carries, model.bias_instability_coefficient.carries
    assert white is not None
    assert white.first_s == 0.5
    assert flicker is not None
    assert white.first_s < flicker.first_s <= white.last_s * 4.0 < flicker.last_s * 4.0


def test_what_was_fitted_begins_at_a_sample_and_ends_at_half_the_record(model: NoiseModel) -> None:
    assert model.first_tau_s == 0.5
    assert model.last_tau_s == pytest.approx(9000.0, rel=0.01)


def test_a_term_carries_where_it_has_a_third() -> None:
    tau_s = np.array([1.0, 2.0, 5.0, 10.0])
    assert carried_range(tau_s, np.array([0.1, 0.4, 0.5, 0.2])) == TauRange(first_s=2.0, last_s=5.0)
    assert carried_range(tau_s, np.array([0.1, 0.3, 0.2, 0.0])) is None
