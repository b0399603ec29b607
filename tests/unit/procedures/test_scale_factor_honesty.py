"""The truth of many units, each with its own table, settings and meter, lies where the results say."""

import dataclasses
from dataclasses import dataclass

import numpy as np
import pytest
from numpy.typing import NDArray

from gyrotest.analysis.scale_factor import StepFit, fit_steps
from gyrotest.procedures.scale_factor import ScaleFactor, ScaleFactorParameters
from gyrotest.records.result import Result
from gyrotest.units import Quantity
from tests.unit.analysis.generator import DPH
from tests.unit.procedures.bench import by_name
from tests.unit.procedures.turntable import (
    QUIET,
    Unit,
    plan_of,
    samples_of_turns,
    table_case,
    table_context,
    table_output,
)

UNITS = 200
RATES = ScaleFactorParameters().signed_rates_dps


@dataclass(frozen=True, kw_only=True)
class Population:
    """What the units of a run have in common."""

    sign: float = 1.0
    cubic_ppm: float = 300.0
    asymmetry_ppm: float = 100.0
    noise: tuple[tuple[str, float], ...] = tuple(QUIET.items())
    seed: int = 0

    def unit(self, number: int) -> Unit:
        """Draw a unit, and a bench within its stated accuracies."""
        random = np.random.default_rng((self.seed, number))
        return Unit(
            scale_factor=self.sign * 0.05 * (1.0 + 0.005 * random.standard_normal()),
            bias_dps=0.3 * random.standard_normal(),
            cubic_ppm=self.cubic_ppm * random.standard_normal(),
            asymmetry_ppm=self.asymmetry_ppm * random.standard_normal(),
            table_gain=random.uniform(-20e-6, 20e-6),
            setting_dps={one: random.uniform(-5e-4, 5e-4) for one in RATES},
            meter_gain=random.uniform(-35e-6, 35e-6),
            meter_offset=random.uniform(-50e-6, 50e-6),
            noise=dict(self.noise),
        )


@dataclass(frozen=True, kw_only=True)
class Recovered:
    """Scores of scale factor and bias (n,), and how often the intervals contain the truth."""

    scale_factor: NDArray[np.float64]
    bias: NDArray[np.float64]
    nonlinearity: float
    asymmetry: float


def noise_free(unit: Unit) -> StepFit:
    """The same definitions on the response without noise."""
    rates = np.array(RATES)
    return fit_steps(
        rates_dps=rates,
        outputs=unit.response(rates),
        times_s=np.arange(rates.size, dtype=float),
        rest_outputs=np.zeros(1),
        rest_times_s=np.zeros(1),
    )


def score(found: Result, truth: float) -> float:
    return ((found.value or 0.0) - truth) / (
        (found.expanded_uncertainty or 0.0) / (found.coverage_factor or 1.0)
    )


def contains(found: Result, truth: float) -> bool:
    return (found.lower_95 or 0.0) <= truth <= (found.upper_95 or 0.0)


def recovered(population: Population) -> Recovered:
    plan = plan_of(table_case())
    nominal = Quantity(50.0 * population.sign, "mV/(deg/s)")
    context = dataclasses.replace(table_context(plan), output=table_output(scale_factor=nominal))
    rows = []
    for number in range(UNITS):
        unit = population.unit(number)
        samples = samples_of_turns(unit, plan, seed=1000 * population.seed + number)
        found, truth = by_name(ScaleFactor().reduce(samples, context).results), noise_free(unit)
        slope = abs(truth.scale_factor.value)
        assert truth.asymmetry is not None
        rows.append(
            (
                score(found["scale_factor"], 1e3 * truth.scale_factor.value),
                score(found["bias"], unit.bias_dps + truth.bias.value),
                contains(found["nonlinearity"], 1e6 * np.abs(truth.residual).max() / slope / 100.0),
                contains(found["asymmetry"], 1e6 * abs(truth.asymmetry.value)),
            )
        )
    columns = np.array(rows, dtype=float).T
    return Recovered(
        scale_factor=columns[0],
        bias=columns[1],
        nonlinearity=float(columns[2].mean()),
        asymmetry=float(columns[3].mean()),
    )


@pytest.mark.slow
@pytest.mark.parametrize(
    "population",
    [
        Population(seed=1),
        Population(seed=2, sign=-1.0),
        Population(seed=3, cubic_ppm=0.0, asymmetry_ppm=0.0),
        Population(seed=4, noise=(("angle_random_walk", 0.002), ("bias_instability", 60 * DPH))),
    ],
    ids=["bent", "inverted", "straight", "flickering"],
)
def test_truth_is_recovered_as_often_as_promised(population: Population) -> None:
    found = recovered(population)
    for scores in (found.scale_factor, found.bias):
        assert abs(scores.mean()) <= 0.25
        assert 0.75 <= scores.std(ddof=1) <= 1.25
    assert found.nonlinearity >= 0.93
    assert found.asymmetry >= 0.93
