"""Spectral lines: the density is Welch's, a sine comes out as itself, and noise has none."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.signal import lfilter, welch

from gyrotest.analysis.allan import overlapping_allan_deviation
from gyrotest.analysis.noise import spectral_lines
from gyrotest.analysis.noise_terms import Grid
from gyrotest.analysis.spectral_lines import spectrum

RATE_HZ = 100.0
TIME_S = np.arange(60_000) / RATE_HZ


def white(samples: int = 60_000, seed: int = 1) -> np.ndarray:
    return np.random.default_rng(seed).standard_normal(samples)


@pytest.mark.parametrize("samples", [1088, 10_007, 200_000])
def test_the_density_is_scipys(samples: int) -> None:
    rate = white(samples) + 5.0
    found = spectrum(rate, sample_rate_hz=RATE_HZ)
    assert found is not None
    size = 2 * (found.density.size - 1)
    frequency_hz, density = welch(
        rate, RATE_HZ, window="hann", nperseg=size, noverlap=size // 2, detrend="constant"
    )
    np.testing.assert_allclose(found.frequency_hz, frequency_hz)
    # Where scipy counts what has no mirror image once, this counts it twice: nobody looks there.
    np.testing.assert_allclose(found.density[1:-1], density[1:-1], rtol=1e-9)


def test_the_degrees_of_freedom_of_the_density_are_those_of_white_noise() -> None:
    densities = []
    for seed in range(40):
        found = spectrum(white(10_000, seed), sample_rate_hz=RATE_HZ)
        assert found is not None
        densities.append(found.density[5:-5])
    scatter = np.var(densities, axis=0, ddof=1).mean() / np.mean(densities) ** 2
    assert 2.0 / found.freedom == pytest.approx(scatter, rel=0.1)


def test_a_record_too_short_for_a_spectrum_has_no_lines() -> None:
    assert spectrum(white(1000), sample_rate_hz=RATE_HZ) is None
    assert spectral_lines(np.sin(np.arange(1000.0)), sample_rate_hz=RATE_HZ) == ()


@pytest.mark.parametrize("frequency_hz", [19.7, 37.0, 49.93])
@pytest.mark.parametrize("amplitude", [0.2, 3.0])
def test_a_sine_comes_out_as_itself(frequency_hz: float, amplitude: float) -> None:
    rate = white() + amplitude * np.sin(2.0 * np.pi * frequency_hz * TIME_S + 0.3)
    found = spectral_lines(rate, sample_rate_hz=RATE_HZ)
    assert len(found) == 1
    line = found[0].line
    assert line.frequency_hz == pytest.approx(frequency_hz, abs=0.03)
    assert abs(line.amplitude_dps - amplitude) < 3.0 * line.standard_uncertainty_dps
    assert line.standard_uncertainty_dps < 0.15 * amplitude


def test_a_sines_share_of_the_allan_variances_is_its_own() -> None:
    sine = 0.5 * np.sin(2.0 * np.pi * 12.3 * TIME_S)
    (found,) = spectral_lines(white() + sine, sample_rate_hz=RATE_HZ)
    factors = np.array([1, 2, 3, 6, 10])
    alone = overlapping_allan_deviation(
        sine, sample_rate_hz=RATE_HZ, averaging_factors=factors.tolist()
    ).deviation_dps
    share = found.allan_variances(factors, Grid(interval_s=0.01, aperture_s=0.01))
    np.testing.assert_allclose(share, alone**2, rtol=0.1)


def test_two_lines_are_two() -> None:
    rate = white() + np.sin(2.0 * np.pi * 20.0 * TIME_S) + 0.5 * np.sin(2.0 * np.pi * 41.0 * TIME_S)
    found = [one.line.frequency_hz for one in spectral_lines(rate, sample_rate_hz=RATE_HZ)]
    assert sorted(found) == pytest.approx([20.0, 41.0], abs=0.05)


def test_a_wide_resonance_is_a_line() -> None:
    pole = 0.99 * np.exp(2j * np.pi * 0.2)
    ringing = lfilter([0.05], [1.0, -2.0 * pole.real, abs(pole) ** 2], white(200_000, 7))
    found = spectral_lines(white(200_000) + ringing, sample_rate_hz=RATE_HZ)
    assert found
    strongest = max(found, key=lambda one: one.power.sum()).line
    assert strongest.frequency_hz == pytest.approx(20.0, abs=0.5)
    power = sum(float(one.power.sum()) for one in found)
    assert power == pytest.approx(np.var(ringing), rel=0.25)


@pytest.mark.parametrize("kind", ["white", "walk", "flicker", "quantization", "quantised"])
def test_noise_has_no_lines(kind: str) -> None:
    """A false alarm a thousand records of white noise is allowed; here are 100."""
    found = 0
    for seed in range(100):
        rate = white(5000, seed)
        if kind == "walk":
            rate = np.cumsum(rate)
        elif kind == "flicker":
            rate = np.cumsum(rate) * 0.02 + rate
        elif kind == "quantization":
            rate = np.diff(rate)
        elif kind == "quantised":
            rate = np.round(rate)
        found += len(spectral_lines(rate, sample_rate_hz=RATE_HZ))
    assert found <= 2


@given(st.floats(1e-9, 1e9), st.floats(0.01, 1e4), st.floats(-1e3, 1e3))
@settings(max_examples=20, deadline=None)
def test_lines_keep_to_the_units(scale: float, rate_hz: float, offset: float) -> None:
    rate = white(20_000) + np.sin(0.2 * np.pi * np.arange(20_000))
    (unit,) = spectral_lines(rate, sample_rate_hz=1.0)
    (found,) = spectral_lines(scale * (rate + offset), sample_rate_hz=rate_hz)
    assert found.line.frequency_hz == pytest.approx(unit.line.frequency_hz * rate_hz)
    assert found.line.amplitude_dps == pytest.approx(unit.line.amplitude_dps * scale, rel=1e-6)
