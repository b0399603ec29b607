"""Least squares among noise that wanders: known answers, honest uncertainties, refusals."""

import numpy as np
import pytest
from numpy.typing import NDArray

from gyrotest.analysis.wandering_fit import Spans, WanderingFit, wandering_fit
from gyrotest.errors import InsufficientDataError
from gyrotest.simulation.noise import NoiseDensities, RateNoise
from gyrotest.simulation.streams import Normals

PASSES, SPANS_EACH, SPAN_S, PAUSE_S = 6, 14, 4.0, 3.0
MEMS = NoiseDensities(
    angle_random_walk_dps_sqrt_s=0.5 / 60.0,
    bias_instability_dps=8.0 / 3600.0,
    rate_random_walk_dps_per_sqrt_s=3.0 / 3600.0 / 60.0,
    bandwidth_hz=50.0,
)


def begins() -> NDArray[np.float64]:
    each = SPAN_S * np.arange(SPANS_EACH)
    return np.concatenate([each + k * (SPANS_EACH * SPAN_S + PAUSE_S) for k in range(PASSES)])


def design() -> NDArray[np.float64]:
    there = np.radians(360.0 * (np.arange(SPANS_EACH) + 0.5) / SPANS_EACH)
    angle = np.concatenate([there if k % 2 == 0 else 2.0 * np.pi - there for k in range(PASSES)])
    rate = np.repeat([6.0, -6.0] * (PASSES // 2), SPANS_EACH)
    return np.column_stack((np.ones(angle.size), -np.sin(angle), np.cos(angle), rate))


def noise(seed: int, densities: NoiseDensities = MEMS) -> NDArray[np.float64]:
    drawn = RateNoise(
        densities, Normals(np.random.default_rng(seed)), since_power_on_s=600.0, start_s=0.0
    )
    return np.concatenate(
        [drawn.means(one, SPAN_S, SPAN_S, SPANS_EACH) for one in begins()[::SPANS_EACH]]
    )


def fitted(values: NDArray[np.float64]) -> WanderingFit:
    spans = Spans(begins_s=begins(), durations_s=np.full(values.size, SPAN_S))
    return wandering_fit(values, design(), spans, since_s=600.0)


def test_coefficients_are_recovered_and_the_weights_give_them() -> None:
    truth = np.array([0.2, 0.05, -0.03, 0.004])
    values = design() @ truth + 1e-3 * noise(5)
    found = fitted(values)
    assert found.coefficients == pytest.approx(truth, abs=1e-5)
    assert found.weights @ values == pytest.approx(found.coefficients)
    assert found.weights @ design() == pytest.approx(np.eye(4), abs=1e-9)
    assert found.residuals == pytest.approx(values - design() @ found.coefficients)


def test_noise_of_flicker_and_walk_is_covered_by_the_uncertainty() -> None:
    """s/√n of the residuals would give deviations of z of 1.5 and more for what turns slowly."""
    functionals = np.eye(4)[1:]
    z = np.array(
        [
            [one @ found.coefficients / found.variance(one).value ** 0.5 for one in functionals]
            for found in (fitted(noise(seed)) for seed in range(50))
        ]
    )
    assert np.abs(z.mean(axis=0)).max() < 0.3
    assert z.std(axis=0, ddof=1) == pytest.approx(1.0, abs=0.25)


def test_of_white_noise_alone_the_uncertainty_is_that_of_ordinary_least_squares() -> None:
    deviation = 0.01
    ordinary = deviation * np.sqrt(np.diag(np.linalg.inv(design().T @ design())))
    found = [
        fitted(np.random.default_rng(seed).normal(0.0, deviation, PASSES * SPANS_EACH))
        for seed in range(16)
    ]
    mean = np.mean([[one.variance(row).value for row in np.eye(4)[1:]] for one in found], axis=0)
    assert np.sqrt(mean) == pytest.approx(ordinary[1:], rel=0.15)


def test_more_wander_makes_the_uncertainty_larger_and_less_certain() -> None:
    wild = NoiseDensities(
        angle_random_walk_dps_sqrt_s=0.5 / 60.0,
        bias_instability_dps=80.0 / 3600.0,
        rate_random_walk_dps_per_sqrt_s=0.0,
        bandwidth_hz=50.0,
    )
    calm, wandering = fitted(noise(3)), fitted(noise(3, wild))
    along = np.array([0.0, 1.0, 0.0, 0.0])
    assert wandering.variance(along).value > 10.0 * calm.variance(along).value
    assert wandering.squares[1] == pytest.approx((80.0 / 3600.0) ** 2, rel=0.6)


def test_columns_that_depend_on_each_other_are_refused() -> None:
    columns = design()
    columns[:, 3] = 2.0 * columns[:, 0]
    spans = Spans(begins_s=begins(), durations_s=np.full(begins().size, SPAN_S))
    with pytest.raises(InsufficientDataError, match="depend on each other"):
        wandering_fit(noise(1), columns, spans)


def test_too_few_values_and_values_without_noise_are_refused() -> None:
    few = Spans(begins_s=begins()[:6], durations_s=np.full(6, SPAN_S))
    with pytest.raises(InsufficientDataError, match="6 values for 4 coefficients; at least 8"):
        wandering_fit(noise(1)[:6], design()[:6], few)
    with pytest.raises(InsufficientDataError, match="without any noise"):
        fitted(np.zeros(begins().size))
