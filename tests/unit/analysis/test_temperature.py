"""Temperature sensitivity of a bias: the definition, the line, and uncertainties that hold."""

import numpy as np
import pytest

from gyrotest.analysis.temperature import temperature_line, temperature_sensitivity
from gyrotest.errors import InsufficientDataError

TEMPERATURES = np.array([23.0, -40.0, 0.0, 60.0, 85.0])
NOTHING = np.zeros((5, 5))


def test_the_sensitivity_is_the_greatest_change_for_its_distance_from_the_room() -> None:
    bias = np.array([10.0, 10.0 + 63.0, 10.0 - 46.0, 10.0 + 37.0, 10.0 - 62.0])
    found = temperature_sensitivity(
        TEMPERATURES, bias, room=0, bias_covariance=NOTHING, setting_uncertainty_c=0.0
    )
    assert (found.value, found.worst) == (pytest.approx(2.0), 2)
    assert (found.change, found.distance_c) == (pytest.approx(-46.0), pytest.approx(-23.0))


def test_the_line_is_that_of_least_squares() -> None:
    bias = 5.0 + 0.3 * TEMPERATURES + np.array([0.0, 1.0, -2.0, 0.5, -0.5])
    found = temperature_line(
        TEMPERATURES, bias, room=0, bias_covariance=NOTHING, setting_uncertainty_c=0.0
    )
    slope, intercept = np.polyfit(TEMPERATURES, bias, 1)
    assert found.slope == pytest.approx(slope)
    assert found.at_room == pytest.approx(intercept + slope * 23.0)
    assert found.departure == pytest.approx(np.abs(bias - intercept - slope * TEMPERATURES).max())


def test_uncertainties_hold() -> None:
    """Biases with noise of which a part is common to neighbours, temperatures each with an error."""
    random = np.random.default_rng(3)
    covariance = 0.8 * np.eye(5) + 0.2
    root = np.linalg.cholesky(covariance)
    ratio_z, slope_z = [], []
    for _ in range(2000):
        read = TEMPERATURES + 0.5 * random.standard_normal(5)
        bias = 0.5 * (TEMPERATURES - 23.0) + root @ random.standard_normal(5)
        bias[4] += 30.0  # so that one set point is the worst whatever the noise
        given = {"room": 0, "bias_covariance": covariance, "setting_uncertainty_c": 0.5}
        found = temperature_sensitivity(read, bias, **given)
        assert found.worst == 4
        uncertainty = np.hypot(found.by_bias[-1], found.by_setting[-1])
        ratio_z.append((found.value - (0.5 + 30.0 / 62.0)) / uncertainty)
        line = temperature_line(read, bias, **given)
        truth = np.polyfit(TEMPERATURES, 0.5 * TEMPERATURES + np.eye(5)[4] * 30.0, 1)[0]
        slope_z.append((line.slope - truth) / np.hypot(line.by_bias, line.by_setting))
    for z in (ratio_z, slope_z):
        assert abs(np.mean(z)) < 0.1
        assert 0.9 < np.std(z) < 1.1


@pytest.mark.parametrize(
    ("temperatures", "bias"),
    [([23.0], [1.0]), ([23.0, 23.0], [1.0, 2.0]), ([23.0, 60.0], [1.0, np.nan])],
)
def test_too_little_is_refused(temperatures: list[float], bias: list[float]) -> None:
    nothing = np.zeros((len(bias), len(bias)))
    for method in (temperature_sensitivity, temperature_line):
        with pytest.raises(InsufficientDataError):
            method(temperatures, bias, room=0, bias_covariance=nothing, setting_uncertainty_c=0.0)
