"""The line of an output over a moving reference: what it is, and how well it is known."""

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.signal import lfilter

from gyrotest.analysis.reference_fit import ReferenceFit, delay_s, reference_fit
from gyrotest.errors import InsufficientDataError

SLOPE, LEVEL = -0.87, 3.0
TRIALS = 120


def drive(samples: int, rng: np.random.Generator) -> NDArray[np.float64]:
    phase = rng.uniform(0.0, 2.0 * np.pi)
    return 50.0 * np.sin(2.0 * np.pi * 0.25 * np.arange(samples) / 100.0 + phase)


def test_it_is_least_squares():
    rng = np.random.default_rng(3)
    reference = drive(3000, rng)
    output = SLOPE * reference + LEVEL + rng.normal(size=3000)
    fit = reference_fit(output, reference)
    slope, level = np.polyfit(reference, output, 1)
    assert (fit.slope, fit.intercept) == (
        pytest.approx(slope, rel=1e-12),
        pytest.approx(level, rel=1e-9),
    )
    np.testing.assert_allclose(fit.residuals, output - slope * reference - level, atol=1e-9)
    assert fit.rms == pytest.approx(np.sqrt(np.sum(fit.residuals**2) / 2998), rel=1e-12)
    assert not fit.residuals.flags.writeable


def noise(kind: str, reference: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
    white = rng.normal(size=reference.size)
    if kind == "correlated":
        return np.asarray(lfilter([1.0], [1.0, -0.9], white))
    if kind == "in proportion":
        return np.asarray(white * np.abs(reference) / 20.0 + 0.1 * rng.normal(size=reference.size))
    return white + (0.05 * np.cumsum(white) if kind == "walking" else 0.0)


@pytest.mark.parametrize("kind", ["white", "correlated", "walking", "in proportion"])
@pytest.mark.parametrize("at_rest", [False, True])
def test_the_truth_lies_as_far_off_as_the_uncertainty_says(kind, at_rest):
    """Noise of which a count of samples would know nothing; and a reference that moves late only."""
    far = []
    for seed in range(TRIALS):
        rng = np.random.default_rng(seed)
        reference = drive(3000, rng)
        if at_rest:
            reference[:1000] = 0.0
        fit = reference_fit(SLOPE * reference + LEVEL + noise(kind, reference, rng), reference)
        far.append((fit.slope - SLOPE) / fit.slope_uncertainty)
    assert abs(np.mean(far)) <= 0.3
    assert 0.65 <= np.std(far) <= 1.4


def test_the_intercept_is_as_uncertain_as_it_says():
    far = []
    for seed in range(TRIALS):
        rng = np.random.default_rng(seed)
        reference = drive(3000, rng) + 20.0
        fit = reference_fit(SLOPE * reference + LEVEL + noise("correlated", reference, rng), reference)
        far.append((fit.intercept - LEVEL) / fit.intercept_uncertainty)
    assert 0.65 <= np.std(far) <= 1.4


def fitted(shift: int) -> tuple[ReferenceFit, NDArray[np.float64]]:
    rng = np.random.default_rng(5)
    reference = drive(6001, rng)
    output = SLOPE * np.roll(reference, shift) + 0.05 * rng.normal(size=6001)
    inside = slice(10, -10)
    return reference_fit(output[inside], reference[inside]), reference[inside]


@pytest.mark.parametrize("shift", [-3, 0, 1, 5])
def test_a_delay_is_found_with_its_sign(shift):
    fit, reference = fitted(shift)
    places = np.arange(reference.size)
    found = delay_s(fit, reference, places, interval_s=0.01)
    assert found == pytest.approx(0.01 * shift, abs=2e-4)
    gapped = np.where(places < 2000, places, places + 700)
    assert delay_s(fit, reference, gapped, interval_s=0.01) == pytest.approx(found, abs=1e-4)


def test_a_reference_that_never_moves_in_a_row_tells_of_no_delay():
    fit, reference = fitted(0)
    assert delay_s(fit, reference, 2 * np.arange(reference.size), interval_s=0.01) is None


def test_what_gives_no_line_is_refused():
    with pytest.raises(InsufficientDataError, match="63 samples are left for the line; 64 are needed"):
        reference_fit(np.arange(63.0), np.arange(63.0))
    with pytest.raises(
        InsufficientDataError, match="reference does not move: all 100 samples are 5 °/s"
    ):
        reference_fit(np.arange(100.0), np.full(100, 5.0))
