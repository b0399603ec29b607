"""Noise terms: their Allan variances and spectra agree with each other and with what is published."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from gyrotest.analysis.noise_terms import (
    FLICKER,
    Grid,
    allan_columns,
    allan_response,
    momentary_flicker_excess,
    momentary_walk_excess,
    spectrum_columns,
)

FACTORS = np.array([1, 2, 5, 30])
FULL = Grid(interval_s=0.5, aperture_s=0.5)
SPARSE = Grid(interval_s=0.5, aperture_s=0.1)


def integrated(grid: Grid) -> np.ndarray:
    """Each Allan variance as the spectrum under its response, (k, 5)."""
    edges = np.geomspace(1e-6, 0.5 / grid.interval_s, 40_001)
    middle = np.sqrt(edges[1:] * edges[:-1])
    return (allan_response(middle, FACTORS, grid) * np.diff(edges)) @ spectrum_columns(middle, grid)


@pytest.mark.parametrize("duty", [1.0, 0.6, 0.2, 0.01])
def test_each_allan_variance_is_its_spectrum_under_the_response(duty: float) -> None:
    grid = Grid(interval_s=0.5, aperture_s=0.5 * duty)
    columns, expected = allan_columns(FACTORS, grid), integrated(grid)
    np.testing.assert_allclose(columns[:, :2], expected[:, :2], rtol=2e-3)
    np.testing.assert_allclose(columns[:, 2:4], expected[:, 2:4], rtol=2e-2)


def test_where_samples_fill_their_interval_the_columns_are_ieee_952s() -> None:
    tau = FACTORS * 0.5
    expected = (3 / tau**2, 1 / tau, np.full(4, 2 * np.log(2) / np.pi), tau / 3, tau**2 / 2)
    np.testing.assert_allclose(allan_columns(FACTORS, FULL), np.column_stack(expected), rtol=1e-14)
    assert pytest.approx(0.6642824702679600) == FLICKER**0.5


def test_a_walk_read_at_instants_has_the_sum_formulas_allan_variance() -> None:
    """K²τ/3·(1 + 1/(2m²)): a discrete random walk, worked out from its covariance."""
    momentary = Grid(interval_s=0.5, aperture_s=1e-9)
    for m in (1, 2, 5):
        contrast = np.append(np.full(m, -1.0), np.ones(m)) / m
        steps = np.cumsum(contrast[::-1])[::-1][1:]
        variance = 0.5 * float(steps @ steps) * momentary.interval_s
        found = allan_columns(np.array([m]), momentary)[0, 3]
        assert found == pytest.approx(variance, rel=1e-8)
        full = allan_columns(np.array([m]), FULL)[0, 3]
        assert full + momentary_walk_excess(np.array([m]), FULL)[0] == pytest.approx(variance)


def test_momentary_flicker_raises_the_shortest_allan_variance_by_kasdins_share() -> None:
    """Kasdin's process in its covariance, against the spectrum of means plus the excess."""
    edges = np.geomspace(1e-7, 1.0, 60_001)
    middle, width = np.sqrt(edges[1:] * edges[:-1]), np.diff(edges)
    response = allan_response(middle, np.array([1, 4]), FULL) * width
    excess = response @ momentary_flicker_excess(middle, FULL)
    # (1 − z⁻¹)·(1 − z⁻¹)^(−1/2): half the variance of the first difference is 2/π.
    assert FLICKER + excess[0] == pytest.approx(2.0 / np.pi, rel=2e-3)
    assert excess[1] < 0.1 * FLICKER


def test_nothing_is_momentary_where_dead_time_is_known() -> None:
    assert not momentary_flicker_excess(np.array([0.1, 0.9]), SPARSE).any()
    assert not momentary_walk_excess(FACTORS, SPARSE).any()


@given(st.floats(1e-4, 1e4), st.floats(0.05, 1.0))
@settings(max_examples=30, deadline=None)
def test_the_unit_of_time_is_free(interval_s: float, duty: float) -> None:
    """Q² goes as 1/time², N² as 1/time, B² not at all, K² as time, R² as time²."""
    unit = allan_columns(FACTORS, Grid(interval_s=1.0, aperture_s=duty))
    found = allan_columns(FACTORS, Grid(interval_s=interval_s, aperture_s=duty * interval_s))
    powers = interval_s ** np.array([-2.0, -1.0, 0.0, 1.0, 2.0])
    np.testing.assert_allclose(found, unit * powers, rtol=1e-6)
