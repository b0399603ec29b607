"""Goodness of fit: chance is called chance, a misfit a misfit."""

import numpy as np

from gyrotest.analysis.goodness import Goodness, goodness
from gyrotest.analysis.likelihood import Likelihood, Solution

COUNT = 256


def solved(modes: np.ndarray, variances: np.ndarray) -> Solution:
    """White noise: modes of variance 2, and three Allan variances of 10 % uncertainty."""
    zeros = np.zeros((COUNT, 1))
    tau = np.array([1.0, 2.0, 4.0])
    likelihood = Likelihood(
        variances=variances,
        columns=np.column_stack((3.0 / tau**2, 1.0 / tau, np.full(3, 0.44), tau / 3.0)),
        precision=np.diag((0.1 / tau) ** -2.0),
        modes=modes,
        mode_variance=np.hstack((zeros, zeros + 2.0, zeros, zeros)),
    )
    return Solution(likelihood=likelihood, state=likelihood.minimise(np.array([0.0, 1.0, 0, 0]), (1,)))


def drawn(seed: int) -> tuple[np.ndarray, np.ndarray]:
    random = np.random.default_rng(seed)
    modes = np.sqrt(2.0) * random.standard_normal(COUNT)
    return modes, (1.0 + 0.1 * random.standard_normal(3)) / np.array([1.0, 2.0, 4.0])


def test_of_records_that_the_model_describes_the_probability_is_evenly_spread() -> None:
    found = [goodness(solved(*drawn(seed))) for seed in range(400)]
    probabilities = np.sort([one.probability for one in found])
    assert np.abs(probabilities - np.linspace(0.0, 1.0, 400)).max() < 0.12
    assert sum(one.widening > 1.0 for one in found) <= 2
    assert all(one.freedom == 3 + 7 - 1 for one in found)


def test_allan_variances_that_contradict_the_modes_are_a_misfit() -> None:
    modes, variances = drawn(1)
    found = goodness(solved(modes, variances * np.array([0.3, 0.3, 1.0])))
    assert found.probability < 1e-6
    assert found.widening == found.misfit > 3.0


def test_slow_modes_that_stand_out_are_a_misfit() -> None:
    modes, variances = drawn(1)
    modes[:8] *= 5.0
    assert goodness(solved(modes, variances)).probability < 1e-6


def test_a_misfit_by_chance_does_not_widen() -> None:
    assert Goodness(chi_square=20.0, freedom=10, probability=0.03).widening == 1.0
    assert Goodness(chi_square=60.0, freedom=10, probability=1e-8).widening == 6.0
    assert Goodness(chi_square=0.1, freedom=10, probability=1.0).widening == 1.0


def test_few_modes_are_one_band() -> None:
    modes, variances = drawn(1)
    solution = solved(modes, variances)
    few = Likelihood(
        variances=variances,
        columns=solution.likelihood.columns,
        precision=solution.likelihood.precision,
        modes=modes[:5],
        mode_variance=solution.likelihood.mode_variance[:5],
    )
    found = goodness(Solution(likelihood=few, state=solution.state))
    assert found.freedom == 3 + 1 - 1
