"""Sine fits: exact on exact sines, the numbers of an independent least squares, the scatter of the bound."""

import math

import numpy as np
import pytest
from scipy.optimize import curve_fit

from gyrotest.analysis.sine_fit import (
    SineFit,
    SineSums,
    four_parameter_fit,
    spectral_peak_hz,
    three_parameter_fit,
)
from gyrotest.errors import InsufficientDataError

INTERVAL_S = 1e-3
FREQUENCY_HZ = 17.3


def record(
    samples: int = 2000, noise: float = 0.0, seed: int = 1, frequency_hz: float = FREQUENCY_HZ
) -> np.ndarray:
    time_s = np.arange(samples) * INTERVAL_S
    clean = 1.3 * np.sin(2.0 * np.pi * frequency_hz * time_s) - 0.4 * np.cos(
        2.0 * np.pi * frequency_hz * time_s
    )
    noisy: np.ndarray = 2.5 + clean + noise * np.random.default_rng(seed).normal(size=samples)
    return noisy


def at_first_sample(fit: SineFit) -> complex:
    return complex(fit.phasor * np.exp(-2j * np.pi * fit.frequency_hz * fit.at_s))


def test_an_exact_sine_is_found_exactly() -> None:
    fit = three_parameter_fit(record(), frequency_hz=FREQUENCY_HZ, interval_s=INTERVAL_S)
    assert (fit.sine, fit.cosine, fit.offset) == pytest.approx((1.3, -0.4, 2.5), abs=1e-12)
    assert fit.amplitude == pytest.approx(math.hypot(1.3, 0.4))
    assert fit.residual_rms < 1e-7
    assert (fit.samples, fit.degrees_of_freedom) == (2000, 1997)


def test_a_cosine_has_the_phase_zero_and_a_sine_lags_by_a_quarter() -> None:
    time_s = np.arange(1000) * INTERVAL_S
    wave = 2.0 * np.pi * 10.0 * time_s
    for values, phase_deg in (
        (np.cos(wave), 0.0),
        (np.sin(wave), -90.0),
        (np.cos(wave - 0.5), -28.6478897),
    ):
        fit = three_parameter_fit(values, frequency_hz=10.0, interval_s=INTERVAL_S)
        assert fit.phase_deg == pytest.approx(phase_deg, abs=1e-6)


def test_three_parameters_are_those_of_an_independent_least_squares() -> None:
    values, time_s = record(noise=0.3), np.arange(2000) * INTERVAL_S
    wave = 2.0 * np.pi * FREQUENCY_HZ * time_s
    design = np.stack((np.sin(wave), np.cos(wave), np.ones(2000)), axis=1)
    solution, squares, _, _ = np.linalg.lstsq(design, values, rcond=None)
    fit = three_parameter_fit(values, frequency_hz=FREQUENCY_HZ, interval_s=INTERVAL_S)
    assert (fit.sine, fit.cosine, fit.offset) == pytest.approx(tuple(solution), rel=1e-10)
    covariance = squares[0] / 1997 * np.linalg.inv(design.T @ design)
    np.testing.assert_allclose(fit.covariance, covariance, rtol=1e-8, atol=1e-12)
    assert fit.residual_rms == pytest.approx(math.sqrt(squares[0] / 2000))


def test_four_parameters_are_those_of_an_independent_least_squares() -> None:
    values, time_s = record(noise=0.2), (np.arange(2000) - 999.5) * INTERVAL_S

    def model(time: np.ndarray, sine: float, cosine: float, offset: float, hz: float) -> np.ndarray:
        wave = 2.0 * np.pi * hz * time
        modelled: np.ndarray = sine * np.sin(wave) + cosine * np.cos(wave) + offset
        return modelled

    fit = four_parameter_fit(values, interval_s=INTERVAL_S)
    start = (fit.sine * 1.1, fit.cosine, fit.offset, 17.25)
    solution, covariance = curve_fit(model, time_s, values, p0=start, xtol=1e-14, ftol=1e-14)
    assert (fit.sine, fit.cosine, fit.offset) == pytest.approx(tuple(solution[:3]), rel=1e-6)
    assert fit.frequency_hz == pytest.approx(solution[3], rel=1e-9)
    assert fit.frequency_uncertainty_hz == pytest.approx(math.sqrt(covariance[3, 3]), rel=1e-4)
    np.testing.assert_allclose(np.diag(fit.covariance), np.diag(covariance)[:3], rtol=1e-4)


@pytest.mark.parametrize("frequency_hz", [3.1, 17.3, 101.7, 333.4])
def test_an_exact_frequency_is_found_without_a_start(frequency_hz: float) -> None:
    values = record(frequency_hz=frequency_hz)
    fit = four_parameter_fit(values, interval_s=INTERVAL_S)
    assert fit.frequency_hz == pytest.approx(frequency_hz, rel=1e-12)
    assert at_first_sample(fit) == pytest.approx(complex(-0.4, -1.3), abs=1e-10)


def test_a_given_start_within_half_a_line_leads_to_the_sine() -> None:
    for start_hz in (FREQUENCY_HZ - 0.24, FREQUENCY_HZ + 0.24):
        fit = four_parameter_fit(record(), interval_s=INTERVAL_S, frequency_hz=start_hz)
        assert fit.frequency_hz == pytest.approx(FREQUENCY_HZ, rel=1e-12)


def test_values_that_stream_by_give_what_they_give_at_once() -> None:
    values = record(noise=0.1)
    sums = SineSums(FREQUENCY_HZ, INTERVAL_S)
    for begin in (0, 3, 10, 999):
        sums.push(values[begin : {0: 3, 3: 10, 10: 999, 999: 2000}[begin]])
    whole = three_parameter_fit(values, frequency_hz=FREQUENCY_HZ, interval_s=INTERVAL_S)
    assert sums.fit().phasor == pytest.approx(whole.phasor, rel=1e-10)
    assert sums.fit().residual_rms == pytest.approx(whole.residual_rms, rel=1e-8)


def test_samples_that_are_missing_shift_what_follows() -> None:
    values = record()
    sums = SineSums(FREQUENCY_HZ, INTERVAL_S)
    sums.push(values[:700])
    sums.push(values[900:], missing=200)
    fit = sums.fit()
    assert (fit.sine, fit.cosine) == pytest.approx((1.3, -0.4), abs=1e-10)
    assert fit.samples == 1800


def test_the_scatter_over_seeds_is_the_bound_and_what_the_fit_says() -> None:
    samples, sigma, amplitude = 1000, 0.2, math.hypot(1.3, 0.4)
    fits = [
        four_parameter_fit(record(samples, noise=sigma, seed=seed), interval_s=INTERVAL_S)
        for seed in range(200)
    ]
    # Cramér–Rao: var A = 2σ²/N, var ω = 24σ²/(A²N³T²), the phase in the middle 2σ²/(A²N)
    bound_hz = math.sqrt(24.0 * sigma**2 / (amplitude**2 * samples**3)) / (2.0 * np.pi * INTERVAL_S)
    bound = math.sqrt(2.0 * sigma**2 / samples)
    true_deg = np.degrees(np.angle((-0.4 - 1.3j) * np.exp(2j * np.pi * FREQUENCY_HZ * fits[0].at_s)))
    phases = np.array([(one.phase_deg - true_deg + 180.0) % 360.0 - 180.0 for one in fits])
    for scatter, expected, stated in (
        (
            np.std([one.frequency_hz for one in fits], ddof=1),
            bound_hz,
            [one.frequency_uncertainty_hz for one in fits],
        ),
        (
            np.std([one.amplitude for one in fits], ddof=1),
            bound,
            [one.amplitude_uncertainty for one in fits],
        ),
        (phases.std(ddof=1), np.degrees(bound / amplitude), [one.phase_uncertainty_deg for one in fits]),
    ):
        assert 0.88 < scatter / expected < 1.12
        assert np.mean(np.array(stated, dtype=float)) == pytest.approx(expected, rel=0.02)
    assert abs(phases.mean()) < 4.0 * np.degrees(bound / amplitude) / math.sqrt(200)


def test_the_peak_of_a_spectrum_lies_between_its_lines() -> None:
    assert spectral_peak_hz(record(noise=0.1), INTERVAL_S) == pytest.approx(FREQUENCY_HZ, abs=0.05)


def test_too_little_or_nothing_of_a_sine_is_refused() -> None:
    with pytest.raises(InsufficientDataError, match="7 samples are too few"):
        three_parameter_fit(record(7), frequency_hz=FREQUENCY_HZ, interval_s=INTERVAL_S)
    with pytest.raises(InsufficientDataError, match="7 samples are too few"):
        four_parameter_fit(record(7), interval_s=INTERVAL_S)
    with pytest.raises(InsufficientDataError, match="no period"):
        three_parameter_fit(record(20), frequency_hz=0.5, interval_s=INTERVAL_S)
    with pytest.raises(InsufficientDataError, match="constant"):
        four_parameter_fit(np.full(500, 2.5), interval_s=INTERVAL_S)
