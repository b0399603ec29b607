"""A polynomial through correlated neighbours: its covariance, its misfit, and what a low degree does."""

import numpy as np
import pytest

from gyrotest.analysis.band_polynomial import BandPolynomial, Estimates, fit_band_polynomial
from gyrotest.errors import InsufficientDataError

LINES = np.arange(20, 201)
FILTER = np.array([0.5, 1.0, 0.5]) / np.sqrt(1.5)
CORRELATION = np.array([1.0, 2 / 3, 1 / 6, 0.0])
ERROR = 0.01 * (1.0 + LINES / 100.0)
PLACES = np.array([20.0, 47.3, 110.0, 200.0])


def truth(x: np.ndarray) -> np.ndarray:
    return 3.0 - 0.02 * x + 1e-4 * x**2


def estimates(
    seed: int, *, left_out: slice | None = None, common: np.ndarray | None = None, bend: float = 0.0
) -> Estimates:
    random = np.random.default_rng(seed)
    noise = np.convolve(random.normal(size=LINES.size + 2), FILTER, mode="valid")
    y = truth(LINES) + bend * np.sin(LINES / 20.0) + ERROR * noise
    shared = np.zeros((LINES.size, 0)) if common is None else common
    y = y + shared @ random.normal(size=shared.shape[1])
    kept = np.delete(np.arange(LINES.size), left_out or slice(0))
    return Estimates(
        x=LINES[kept].astype(float),
        y=y[kept],
        error=ERROR[kept],
        line=LINES[kept],
        correlation=CORRELATION,
        averages=np.inf,
        common=shared[kept],
    )


def fit(given: Estimates, degree: int = 2) -> BandPolynomial:
    return fit_band_polynomial(given, low=20.0, high=200.0, degree=degree)


def scores(found: list[BandPolynomial], derivative: int = 0) -> np.ndarray:
    rows = found[0].rows(PLACES, derivative=derivative)
    slope = -0.02 + 2e-4 * PLACES if derivative else truth(PLACES)
    return np.array(
        [(one.value(PLACES, derivative=derivative) - slope) / one.uncertainty(rows) for one in found]
    )


def test_a_polynomial_is_found_exactly() -> None:
    given = estimates(1)
    exact = Estimates(
        x=given.x,
        y=truth(given.x),
        error=given.error,
        line=given.line,
        correlation=given.correlation,
        averages=np.inf,
        common=given.common,
    )
    found = fit(exact, degree=4)
    np.testing.assert_allclose(found.value(PLACES), truth(PLACES), rtol=1e-12)
    np.testing.assert_allclose(found.value(PLACES, derivative=1), -0.02 + 2e-4 * PLACES, rtol=1e-9)
    assert (found.residual_rms, found.lack_rms) == pytest.approx((0.0, 0.0), abs=1e-12)
    assert not found.lacking


@pytest.mark.parametrize("left_out", [None, slice(60, 75), slice(0, None, 3)])
@pytest.mark.parametrize("derivative", [0, 1])
def test_scores_are_standard_although_neighbours_are_correlated(
    left_out: slice | None, derivative: int
) -> None:
    z = scores([fit(estimates(seed, left_out=left_out)) for seed in range(300)], derivative)
    assert np.all(np.abs(z.mean(axis=0)) < 0.2)
    assert np.all((z.std(axis=0) > 0.88) & (z.std(axis=0) < 1.12))


def test_taking_neighbours_for_independent_would_promise_too_much() -> None:
    given = estimates(1)
    rows = fit(given).rows(PLACES)
    alone = Estimates(
        x=given.x,
        y=given.y,
        error=given.error,
        line=given.line,
        correlation=np.array([1.0]),
        averages=np.inf,
        common=given.common,
    )
    ratio = fit(given).uncertainty(rows) / fit(alone).uncertainty(rows)
    np.testing.assert_allclose(ratio, np.sqrt(1.0 + 2.0 * CORRELATION[1:].sum()), rtol=0.05)


def test_what_all_lines_have_in_common_stays_in_the_uncertainty() -> None:
    common = np.column_stack((np.full(LINES.size, 0.05), 0.02 * LINES / 100.0))
    z = scores([fit(estimates(seed, common=common)) for seed in range(300)])
    assert np.all((z.std(axis=0) > 0.9) & (z.std(axis=0) < 1.1))


def test_the_misfit_is_one_and_its_probability_even_where_the_model_holds() -> None:
    found = [fit(estimates(seed, left_out=slice(40, 50))) for seed in range(300)]
    assert np.mean([one.misfit for one in found]) == pytest.approx(1.0, abs=0.02)
    for probability in ([one.fit_probability for one in found], [one.lack_probability for one in found]):
        ranks = np.histogram(probability, bins=4, range=(0.0, 1.0))[0] / 300
        np.testing.assert_allclose(ranks, 0.25, atol=0.08)


def test_a_degree_that_is_too_low_is_found_and_widens_the_uncertainty() -> None:
    given = estimates(4, bend=0.03)
    found, enough = fit(given, degree=2), fit(given, degree=12)
    assert found.lacking
    assert found.fit_probability < 1e-3
    assert not enough.lacking
    rows = found.rows(LINES)
    beside = found.value(LINES) - truth(LINES) - 0.03 * np.sin(LINES / 20.0)
    assert np.std(beside) > 5.0 * np.median(found.random(rows))
    assert np.sqrt(np.mean((beside / found.uncertainty(rows)) ** 2)) < 2.0
    assert found.lack_rms == pytest.approx(np.std(beside), rel=0.5)


def test_too_few_lines_for_the_degree_are_refused() -> None:
    given = estimates(1, left_out=slice(7, None))
    assert fit(given, degree=2).coefficients.size == 3
    with pytest.raises(InsufficientDataError, match=r"7 lines in the band; .*degree 3 needs 8: lower"):
        fit(given, degree=3)
