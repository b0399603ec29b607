"""The likelihood of a record: its minimum is a general optimiser's, its information the curvature."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import minimize

from gyrotest.analysis.likelihood import TERMS, Likelihood, Solution

ALL = tuple(range(TERMS))
TRUTH = np.array([0.3, 1.0, 0.4, 0.02])
TAU = np.array([1.0, 2.0, 4.0, 8.0, 16.0])
FREQUENCY = np.arange(1, 33) / 640.0


def problem(seed: int = 0, truth: np.ndarray = TRUTH, *, drift: float = 0.0) -> Likelihood:
    """Independent Allan variances of 10 % uncertainty and 32 modes."""
    random = np.random.default_rng(seed)
    columns = np.column_stack((3.0 / TAU**2, 1.0 / TAU, np.full(5, 0.44), TAU / 3.0))
    spectra = np.column_stack(
        (
            8.0 * np.sin(np.pi * FREQUENCY) ** 2,
            np.full(32, 2.0),
            1 / (np.pi * FREQUENCY),
            0.05 / FREQUENCY**2,
        )
    )
    expected = columns @ truth
    course = FREQUENCY**-2.0 * (np.arange(32) % 2 == 0)
    return Likelihood(
        variances=expected * (1.0 + 0.1 * random.standard_normal(5)),
        columns=columns,
        precision=np.diag((0.1 * expected) ** -2.0),
        modes=np.sqrt(spectra @ truth) * random.standard_normal(32) + drift * course,
        mode_variance=spectra,
        course=None if drift == 0.0 else course,
    )


@pytest.mark.parametrize("seed", range(12))
def test_the_minimum_is_a_general_optimisers(seed: int) -> None:
    likelihood = problem(seed)
    found = likelihood.minimise(np.ones(TERMS), ALL)
    oracle = min(
        minimize(
            lambda squares: likelihood.state(squares).deviance,
            start,
            bounds=[(0.0, None)] * TERMS,
            method="L-BFGS-B",
        ).fun
        for start in (found.squares + 1e-3, TRUTH)
    )
    assert found.deviance <= oracle + 1e-3
    assert (found.squares >= 0.0).all()


@pytest.mark.parametrize("start", [1e-6, 1.0, 1e6])
def test_the_start_does_not_matter(start: float) -> None:
    likelihood = problem(3)
    found = likelihood.minimise(start * np.ones(TERMS), ALL)
    assert found.deviance == pytest.approx(likelihood.minimise(TRUTH, ALL).deviance, abs=1e-3)


def test_a_start_that_leaves_the_modes_no_variance_is_mended() -> None:
    likelihood = problem(3)
    assert likelihood.state(np.zeros(TERMS)).deviance == np.inf
    found = likelihood.minimise(np.zeros(TERMS), ALL)
    assert found.deviance == pytest.approx(likelihood.minimise(TRUTH, ALL).deviance, abs=1e-3)


def test_only_of_a_filtered_record_the_first_term_may_be_negative() -> None:
    missing = np.array([-0.1, 1.0, 0.4, 0.02])
    likelihood = replace(problem(), variances=problem().columns @ missing)
    assert likelihood.minimise(TRUTH, ALL).squares[0] == 0.0
    filtered = replace(likelihood, filtered=True).minimise(TRUTH, ALL)
    assert filtered.squares[0] < 0.0
    assert (filtered.squares[1:] >= 0.0).all()
    assert filtered.deviance < likelihood.minimise(TRUTH, ALL).deviance


def test_terms_that_are_not_free_stay_as_they_are() -> None:
    found = problem().minimise(np.array([0.0, 1.0, 0.7, 0.02]), (1, 3))
    assert found.squares[[0, 2]].tolist() == [0.0, 0.7]


def test_a_solution_without_a_term_is_less_likely_and_has_none_of_it() -> None:
    likelihood = problem()
    whole = Solution(likelihood=likelihood, state=likelihood.minimise(TRUTH, ALL))
    for which in ALL:
        fewer = whole.without(which)
        assert fewer.state.squares[which] == 0.0
        assert fewer.state.deviance >= whole.state.deviance - 1e-3


def test_the_information_is_the_mean_curvature_of_half_the_deviance() -> None:
    information = problem().information(TRUTH)
    step = 1e-3 * TRUTH
    curvature = np.zeros((TERMS, TERMS))
    records = [problem(seed) for seed in range(300)]
    for a in ALL:
        for b in ALL:
            moves = [
                (
                    sign_a * sign_b,
                    TRUTH + sign_a * step * np.eye(TERMS)[a] + sign_b * step * np.eye(TERMS)[b],
                )
                for sign_a in (1, -1)
                for sign_b in (1, -1)
            ]
            total = sum(
                sign * np.mean([one.state(squares).deviance for one in records])
                for sign, squares in moves
            )
            curvature[a, b] = total / (4.0 * step[a] * step[b]) / 2.0
    scale = np.sqrt(np.outer(np.diag(information), np.diag(information)))
    np.testing.assert_allclose(curvature / scale, information / scale, atol=0.12)


def test_the_inverse_information_is_the_scatter_of_the_estimates() -> None:
    """Of two terms far from 0: estimates that cannot be negative scatter less."""
    truth = np.array([0.0, 1.0, 0.0, 0.3])
    free = [1, 3]
    found = np.array([problem(seed, truth).minimise(truth, (1, 3)).squares for seed in range(400)])
    assert found[:, free].mean(axis=0) == pytest.approx(truth[free], rel=0.03)
    stated = np.sqrt(np.diag(np.linalg.inv(problem(0, truth).information(truth)[np.ix_(free, free)])))
    assert found[:, free].std(axis=0) == pytest.approx(stated, rel=0.12)
    assert np.diag(problem(0, TRUTH).covariance(TRUTH)) == pytest.approx(
        np.diag(np.linalg.inv(problem(0, TRUTH).information(TRUTH))), rel=1e-6
    )


def test_a_drifts_amplitude_is_recovered_within_its_uncertainty() -> None:
    z = []
    for seed in range(100):
        likelihood = problem(seed, drift=0.5)
        assert likelihood.course is not None
        variance = likelihood.mode_variance @ TRUTH
        sigma = float(np.sum(likelihood.course**2 / variance)) ** -0.5
        z.append((likelihood.amplitude(variance) - 0.5) / sigma)
    assert abs(np.mean(z)) < 0.3
    assert np.std(z) == pytest.approx(1.0, abs=0.2)


def test_a_held_amplitude_stays_and_costs_its_square() -> None:
    likelihood = problem(drift=0.5)
    assert likelihood.course is not None
    free = likelihood.state(TRUTH)
    sigma = float(np.sum(likelihood.course**2 / (likelihood.mode_variance @ TRUTH))) ** -0.5
    held = replace(likelihood, held=free.drift + 2.0 * sigma).state(TRUTH)
    assert held.drift == pytest.approx(free.drift + 2.0 * sigma)
    assert held.deviance - free.deviance == pytest.approx(4.0)


@given(st.floats(1e-12, 1e12))
@settings(max_examples=25, deadline=None)
def test_the_unit_is_free(scale: float) -> None:
    unit = problem(2)
    scaled = replace(
        unit,
        variances=unit.variances * scale,
        precision=unit.precision / scale**2,
        modes=unit.modes * scale**0.5,
    )
    wanted = unit.minimise(TRUTH, ALL).squares
    found = scaled.minimise(TRUTH * scale, ALL).squares
    np.testing.assert_allclose(found / scale, wanted, rtol=1e-6, atol=1e-9)
