"""The rms of residuals: its value, and intervals that hold whether there is a residual or not."""

import numpy as np
import pytest

from gyrotest.analysis.residuals import root_mean_square
from gyrotest.errors import InsufficientDataError


def test_the_rms_of_exact_residuals_is_exact() -> None:
    found = root_mean_square([3.0, -4.0], covariance=np.zeros((2, 2)))
    assert found.value == found.lower_95 == found.upper_95 == pytest.approx(np.sqrt(12.5))
    assert found.error == 0.0


@pytest.mark.parametrize("size", [0.0, 1.0, 30.0])
@pytest.mark.parametrize("common", [0.0, 4.0])
def test_the_interval_holds_the_true_rms(size: float, common: float) -> None:
    """Errors of each residual and common ones, beneath, beside and far below the residuals."""
    random = np.random.default_rng(5)
    truth = size * np.linspace(-1.0, 1.0, 8)
    shape = np.linspace(-1.0, 1.0, 8)
    covariance = np.eye(8) + common * np.outer(shape, shape)
    root = np.linalg.cholesky(covariance)
    true_rms = np.sqrt(np.mean(truth**2))
    held = 0
    for _ in range(1000):
        found = root_mean_square(truth + root @ random.standard_normal(8), covariance=covariance)
        held += found.lower_95 <= true_rms <= found.upper_95
    assert held >= 940


@pytest.mark.parametrize("values", [[], [1.0, np.inf]])
def test_nothing_has_no_rms(values: list[float]) -> None:
    with pytest.raises(InsufficientDataError):
        root_mean_square(values, covariance=np.zeros((len(values), len(values))))
