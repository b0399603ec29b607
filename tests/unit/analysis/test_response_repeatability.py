"""Repeatability of the response: 3σ per frequency, and an interval of the largest that holds."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from gyrotest.analysis.frequency_response import h1
from gyrotest.analysis.response_curve import ResponseCurve, fit_response
from gyrotest.analysis.response_repeatability import response_repeatability
from gyrotest.errors import InsufficientDataError
from tests.unit.analysis.vibration import Truth, Vibration

DEGREE = 5
RUNS = 3


@cache
def quiet() -> ResponseCurve:
    """A run almost without noise."""
    spectra = Vibration(reference=0.0, output=1e-8).spectra(1, duration_s=60.0)
    return fit_response(h1(spectra), degree=DEGREE, coherence_floor=0.5)


def moved(gain: np.ndarray, phase_deg: float = 0.0) -> ResponseCurve:
    """The quiet run with Chebyshev terms added to the logarithm of its gain, and a phase."""
    curve = quiet()
    terms = np.pad(gain, (0, curve.log_gain.coefficients.size - gain.size))
    turned = curve.phase.coefficients + phase_deg * np.eye(curve.phase.coefficients.size)[0]
    return replace(
        curve,
        log_gain=replace(curve.log_gain, coefficients=curve.log_gain.coefficients + terms),
        phase=replace(curve.phase, coefficients=turned),
    )


def test_it_is_three_sample_deviations_at_each_frequency() -> None:
    changes = np.array([-0.001, 0.0, 0.002])
    found = response_repeatability([moved(np.array([c]), phase_deg=100.0 * c) for c in changes])
    expected = 3.0 * changes.std(ddof=1)
    np.testing.assert_allclose(found.amplitude_percent, 100.0 * expected, rtol=2e-3)
    np.testing.assert_allclose(found.phase_deg, 100.0 * expected, rtol=1e-6)
    assert found.runs == RUNS
    assert found.phase.value == pytest.approx(100.0 * expected)


def test_the_largest_is_found_where_it_is() -> None:
    tilts = (-0.002, 0.001, 0.001)
    found = response_repeatability([moved(np.array([t, t])) for t in tilts])
    assert found.amplitude.at_hz == pytest.approx(100.0)
    assert found.amplitude.value == pytest.approx(found.amplitude_percent.max())
    assert found.amplitude_percent[0] == pytest.approx(0.0, abs=1e-9)


def test_frequencies_may_be_asked_for() -> None:
    places = np.array([6.0, 60.0])
    found = response_repeatability([quiet(), quiet()], frequency_hz=places)
    np.testing.assert_array_equal(found.frequency_hz, places)
    assert found.amplitude.value == 0.0


def test_a_whole_turn_between_runs_is_no_spread() -> None:
    found = response_repeatability([quiet(), moved(np.zeros(1), phase_deg=360.0)])
    assert found.phase.value == pytest.approx(0.0, abs=1e-9)


@pytest.mark.parametrize("shape", [(1.0,), (0.5, 0.5), (0.2, 0.2, 0.2, 0.2, 0.2)])
def test_the_interval_holds_the_largest_spread_whatever_its_shape(shape: tuple[float, ...]) -> None:
    """Spread that is the same everywhere, that is at one end, and that is many independent terms."""
    sigma = 0.004
    independent = len(shape) > 2
    grid = np.polynomial.chebyshev.chebvander(np.linspace(-1.0, 1.0, 201), len(shape) - 1) * shape
    true = (
        300.0 * sigma * (np.linalg.norm(grid, axis=1) if independent else np.abs(grid.sum(axis=1))).max()
    )
    below = above = 0
    for seed in range(400):
        random = np.random.default_rng((seed, 6))
        size = (RUNS, len(shape)) if independent else (RUNS, 1)
        found = response_repeatability([moved(sigma * one * shape) for one in random.normal(size=size)])
        below += true < found.amplitude.lower_95
        above += true > found.amplitude.upper_95
    assert below / 400 <= 0.03
    assert above / 400 <= 0.04


def test_noise_alone_leaves_an_interval_that_begins_at_nothing() -> None:
    held, ratios = 0, []
    for seed in range(40):
        runs = [Vibration().spectra((seed, run), duration_s=24.0) for run in range(RUNS)]
        curves = [fit_response(h1(one), degree=DEGREE, coherence_floor=0.5) for one in runs]
        found = response_repeatability(curves)
        held += found.amplitude.lower_95 == 0.0
        ratios.append(found.amplitude.value / found.amplitude.noise)
    assert held >= 37
    assert 0.7 < np.mean(ratios) < 2.0


def test_one_run_is_refused() -> None:
    with pytest.raises(InsufficientDataError, match="1 run has no spread"):
        response_repeatability([quiet()])


def test_runs_without_a_common_band_are_refused() -> None:
    spectra = Vibration(truth=Truth(), reference=0.0, output=0.01).spectra(1, duration_s=60.0)
    whole = h1(spectra)
    low = np.where(whole.frequency_hz < 40.0, whole.coherence, 0.0)
    high = np.where(whole.frequency_hz > 60.0, whole.coherence, 0.0)
    curves = [
        fit_response(replace(whole, coherence=one), degree=DEGREE, coherence_floor=0.5)
        for one in (low, high)
    ]
    with pytest.raises(InsufficientDataError, match="no band with enough coherence in common"):
        response_repeatability(curves)
