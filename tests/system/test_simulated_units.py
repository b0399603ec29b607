"""What simulated units show of the whole chain: verdicts, and the truth recovered honestly.

Each unit has its own turn-on bias, scale-factor error and noise, and its own meter errors.
"""

import math
import statistics
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from gyrotest.records.result import JudgedResult, Verdict
from gyrotest.records.run import Attempt, RunRecord
from gyrotest.units import conversion_factor

from .units import run_units

pytestmark = [pytest.mark.slow]
UNITS = [str(4000 + 37 * number) for number in range(30)]
DPH = 1 / 3600


@pytest.fixture(scope="module")
def nominal(tmp_path_factory: pytest.TempPathFactory) -> list[RunRecord]:
    return list(run_units(tmp_path_factory.mktemp("nominal"), UNITS))


def _values(
    records: list[RunRecord], name: str, pick: Callable[[JudgedResult, Attempt], float]
) -> list[float]:
    found = []
    for record in records:
        for item in record.items:
            attempt = item.last
            if attempt is not None and item.plan.repeat is not None:
                found += [pick(one, attempt) for one in attempt.results if one.name == name]
    return found


class TestNominal:
    def test_at_least_nineteen_of_twenty_pass(self, nominal: list[RunRecord]) -> None:
        verdicts = [record.verdict for record in nominal[:20]]
        assert verdicts.count(Verdict.PASS) >= 19
        assert all(record.simulated for record in nominal)

    def test_bias_is_within_its_stated_uncertainty(self, nominal: list[RunRecord]) -> None:
        def z(result: JudgedResult, attempt: Attempt) -> float:
            assert result.value is not None
            assert result.expanded_uncertainty is not None
            assert result.coverage_factor is not None
            to_dps = conversion_factor(result.unit, "deg/s")
            standard = result.expanded_uncertainty / result.coverage_factor
            return (result.value * to_dps - attempt.truth["bias_dps"]) / (standard * to_dps)

        _assert_honest(_values(nominal, "bias", z))

    def test_angle_random_walk_is_within_its_stated_uncertainty(self, nominal: list[RunRecord]) -> None:
        def z(result: JudgedResult, attempt: Attempt) -> float:
            assert result.value is not None
            assert result.lower_95 is not None
            assert result.upper_95 is not None
            to = conversion_factor(result.unit, "deg/s**0.5")
            standard = (result.upper_95 - result.lower_95) / (2 * 1.96)
            return (result.value * to - attempt.truth["angle_random_walk_dps_sqrt_s"]) / (standard * to)

        _assert_honest(_values(nominal, "angle_random_walk", z))

    @pytest.mark.parametrize("smoothing_s", [1, 10, 100])
    def test_intervals_of_bias_stability_hold_the_truth(
        self, nominal: list[RunRecord], smoothing_s: int
    ) -> None:
        def inside(result: JudgedResult, attempt: Attempt) -> float:
            assert result.lower_95 is not None
            assert result.upper_95 is not None
            to_dps = conversion_factor(result.unit, "deg/s")
            truth = _true_stability_dps(attempt, smoothing_s)
            return float(result.lower_95 * to_dps <= truth <= result.upper_95 * to_dps)

        held = _values(nominal, f"bias_stability_{smoothing_s}s", inside)
        first_repeats = held[::3]
        assert len(first_repeats) == 30
        assert sum(first_repeats) >= 26
        assert sum(held) / len(held) >= 26 / 30

    @pytest.mark.parametrize(
        ("name", "truth", "unit"),
        [
            ("bias_instability_coefficient", "bias_instability_coefficient_dps", "deg/s"),
            ("rate_random_walk", "rate_random_walk_dps_per_sqrt_s", "deg/s**1.5"),
        ],
    )
    def test_intervals_of_the_fitted_coefficients_hold_the_truth(
        self, nominal: list[RunRecord], name: str, truth: str, unit: str
    ) -> None:
        def inside(result: JudgedResult, attempt: Attempt) -> float:
            assert result.lower_95 is not None
            assert result.upper_95 is not None
            to = conversion_factor(result.unit, unit)
            return float(result.lower_95 * to <= attempt.truth[truth] <= result.upper_95 * to)

        held = _values(nominal, name, inside)
        assert len(held) == 90
        assert sum(held) >= 80


def _assert_honest(z: list[float]) -> None:
    """The first repeat of each of 30 units alone, and all of them."""
    for values in (z[::3], z):
        assert len(values) >= 30
        assert abs(statistics.mean(values)) <= 0.55
        assert 0.65 <= statistics.stdev(values) <= 1.4


def _true_stability_dps(attempt: Attempt, smoothing_s: int) -> float:
    """√E(σ_T²): the n-sample variance of the noise, n/(n−1)·(V(T) − V(nT)), and the drift's own variance."""
    assert attempt.recording is not None
    truth, sampling = attempt.truth, attempt.recording.header.sampling
    n = attempt.recording.samples * sampling.interval_s / smoothing_s
    white = truth["angle_random_walk_dps_sqrt_s"] ** 2 / (sampling.duty * smoothing_s)
    flicker = truth["bias_instability_coefficient_dps"] ** 2 * math.log(n) / math.pi * n / (n - 1)
    walk = truth["rate_random_walk_dps_per_sqrt_s"] ** 2 * smoothing_s * n / 6
    return math.sqrt(white + flicker + walk + _drift_variance(attempt, smoothing_s))


def _drift_variance(attempt: Attempt, smoothing_s: int) -> float:
    """The warm-up drift, 0.05 °/s·exp(−t/4 min), smoothed; its amplitude at the record's start from its mean."""
    assert attempt.recording is not None
    duration_s = attempt.recording.samples * attempt.recording.header.sampling.interval_s
    time_s = np.arange(0.5, duration_s)
    shape = np.exp(-time_s / 240.0)
    drift = attempt.truth["mean_drift_dps"] * shape / shape.mean()
    return float(drift.reshape(-1, smoothing_s).mean(axis=1).var(ddof=1))


@pytest.mark.parametrize("scenario", ["out-of-limits", "dead-output"])
def test_no_unit_passes_that_should_not(tmp_path: Path, scenario: str) -> None:
    records = list(run_units(tmp_path, UNITS[:20], scenario=scenario))
    verdicts = {record.verdict for record in records}
    assert verdicts == {Verdict.FAIL if scenario == "out-of-limits" else Verdict.INCOMPLETE}


def test_a_dead_output_is_an_error_that_names_the_meter(tmp_path: Path) -> None:
    (record,) = run_units(tmp_path, ["4711"], scenario="dead-output")
    assert any("not distinguishable from the meter" in one for one in record.missing)
