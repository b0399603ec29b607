"""Spectra against `scipy.signal`, where it computes the same thing."""

import numpy as np
import pytest
from scipy.signal import csd, detrend, get_window, welch

from gyrotest.analysis.cross_spectra import CrossSpectra, Spectra
from gyrotest.analysis.taper import taper

RATE_HZ = 1000.0


def record(samples: int = 30_000) -> tuple[np.ndarray, np.ndarray]:
    random = np.random.default_rng(11)
    angle = np.cumsum(random.normal(size=samples)) / RATE_HZ + 40.0
    output = np.gradient(angle) * RATE_HZ + random.normal(size=samples) + 1e-3 * np.arange(samples)
    return angle, output


def ours(angle: np.ndarray, output: np.ndarray, segment: int, window: str = "hann") -> Spectra:
    made = CrossSpectra(rate_hz=RATE_HZ, low_hz=5.0, high_hz=200.0, segment=segment, window=window)
    for part in np.array_split(np.arange(angle.size), 23):
        made.push(angle[part], output[part])
    return made.spectra()


def segments_of(signal: np.ndarray, segment: int) -> list[np.ndarray]:
    hop = segment - segment // 2
    return [detrend(signal[k : k + segment]) for k in range(0, signal.size - segment + 1, hop)]


def rate_of(angle: np.ndarray) -> np.ndarray:
    """The derivative of a segment, line by line."""
    lines = np.fft.rfftfreq(angle.size, 1.0 / RATE_HZ)
    return np.fft.irfft(2j * np.pi * lines * np.fft.rfft(angle), angle.size)


@pytest.mark.parametrize("segment", [4000, 4001, 1538])
@pytest.mark.parametrize("window", ["hann", "blackman"])
def test_the_output_s_spectrum_is_welch_s(segment: int, window: str) -> None:
    angle, output = record()
    found = ours(angle, output, segment, window)
    _, expected = welch(output, RATE_HZ, window=window, nperseg=segment, detrend="linear")
    lines = np.rint(found.frequency_hz * segment / RATE_HZ).astype(int)
    np.testing.assert_allclose(found.output, expected[lines], rtol=1e-10)


@pytest.mark.parametrize("segment", [4000, 4001])
def test_the_rate_s_spectrum_and_the_cross_spectrum_are_those_of_the_differentiated_segments(
    segment: int,
) -> None:
    angle, output = record()
    found = ours(angle, output, segment)
    rates = [rate_of(one) for one in segments_of(angle, segment)]
    outputs = segments_of(output, segment)
    lines = np.rint(found.frequency_hz * segment / RATE_HZ).astype(int)
    plain = {"fs": RATE_HZ, "nperseg": segment, "detrend": False}
    reference = np.mean([welch(one, **plain)[1] for one in rates], axis=0)[lines]
    cross = np.mean([csd(x, y, **plain)[1] for x, y in zip(rates, outputs, strict=True)], axis=0)[lines]
    np.testing.assert_allclose(found.reference, reference, rtol=1e-10)
    np.testing.assert_allclose(found.cross, cross, rtol=1e-10)


def test_long_segments_give_what_the_angle_s_own_spectrum_gives() -> None:
    angle, output = record(200_000)
    found = ours(angle, output, 40_000)
    lines = np.rint(found.frequency_hz * found.segment_s).astype(int)
    options = {"fs": RATE_HZ, "nperseg": 40_000, "detrend": "linear"}
    turn = 2.0 * np.pi * found.frequency_hz
    np.testing.assert_allclose(found.reference, turn**2 * welch(angle, **options)[1][lines], rtol=0.03)
    expected = -1j * turn * csd(angle, output, **options)[1][lines]
    assert np.median(np.abs(found.cross / expected - 1.0)) < 1e-3


@pytest.mark.parametrize("samples", [4000, 4001])
@pytest.mark.parametrize("window", ["hann", "blackman"])
def test_a_taper_has_the_lines_of_scipy_s_window(samples: int, window: str) -> None:
    found = taper(window, samples)
    shape = get_window(window, samples)
    lines = np.fft.fft(shape).real / samples
    np.testing.assert_allclose(
        np.roll(lines, found.reach)[: found.kernel.size], found.kernel, atol=1e-15
    )
    assert found.power == pytest.approx(np.mean(shape**2), rel=1e-12)
