"""The error within a line: found from smooth motion, corrected, and what is left of it told."""

import dataclasses

import numpy as np
import pytest

from gyrotest.analysis.encoder import Decoder, Ellipse, EllipseFit
from gyrotest.analysis.line_error import SEGMENT, LineError, find_line_error

RATE_HZ, LINES, LINE_DEG = 10_000.0, 9000, 0.04


def moving(frequencies_hz: tuple[float, ...], rms_dps: float = 8.0) -> np.ndarray:
    time_s = np.arange(50_000) / RATE_HZ
    parts = [
        rms_dps * np.sqrt(2.0) / (2.0 * np.pi * one) * np.sin(2.0 * np.pi * one * time_s + 1.0)
        for one in frequencies_hz
    ]
    return np.concatenate(parts)


def phases(frequencies_hz: tuple[float, ...], rms_dps: float = 8.0, seed: int = 1) -> np.ndarray:
    true = np.deg2rad(moving(frequencies_hz, rms_dps)) * LINES + 0.3
    error = 2e-3 * np.sin(2.0 * true) + 4e-4 * np.cos(true) - 1e-4 * np.cos(3.0 * true)
    noisy = true + error + 3e-4 * np.random.default_rng(seed).normal(size=true.size)
    wrapped: np.ndarray = (noisy + np.pi) % (2.0 * np.pi) - np.pi
    return wrapped[: true.size // SEGMENT * SEGMENT].reshape(-1, SEGMENT)


def test_the_harmonics_of_a_line_are_found_within_their_uncertainty() -> None:
    found = find_line_error(phases((5.0, 10.0, 20.0, 80.0)))
    assert found is not None
    assert found.cosines == pytest.approx((4e-4, 0.0, -1e-4, 0.0), abs=3e-5)
    assert found.sines == pytest.approx((0.0, 2e-3, 0.0, 0.0), abs=3e-5)
    assert found.uncertainty < 5e-5


def test_too_little_motion_does_not_tell() -> None:
    assert find_line_error(phases((80.0, 100.0))) is None
    assert find_line_error(phases((5.0, 10.0), rms_dps=0.5)) is None
    assert find_line_error(np.zeros((0, SEGMENT))) is None


def test_an_error_is_what_its_harmonics_say() -> None:
    error = LineError(cosines=(1.0, 2.0, 3.0, 4.0), sines=(0.5, 0.0, -1.0, 2.0), uncertainty=0.0)
    phase = np.linspace(-3.0, 3.0, 40)
    expected = sum(
        c * np.cos(k * phase) + s * np.sin(k * phase)
        for k, (c, s) in enumerate(zip(error.cosines, error.sines, strict=True), start=1)
    )
    np.testing.assert_allclose(error.at(np.sin(phase), np.cos(phase)), expected, atol=1e-12)


def test_a_third_harmonic_hides_in_the_ellipse_and_is_corrected_all_the_same() -> None:
    true_deg = moving((5.0, 10.0, 20.0, 80.0))
    phase = np.deg2rad(true_deg) * LINES
    sine = np.sin(phase) + 1e-3 * np.sin(3.0 * phase)
    cosine = np.cos(phase) + 1e-3 * np.cos(3.0 * phase)
    fit = EllipseFit()
    for begin in range(0, sine.size, 10_000):
        fit.push(sine[begin : begin + 10_000], cosine[begin : begin + 10_000])
    ellipse = fit.fit()
    assert ellipse.harmonics < 1e-5  # the points lie on an ellipse
    assert ellipse.sine_amplitude == pytest.approx(1.0 - 1e-3, abs=1e-5)
    assert ellipse.line_error is not None
    uncorrected = worst(ellipse, with_error=False, signals=(sine, cosine), true_deg=true_deg)
    corrected = worst(ellipse, with_error=True, signals=(sine, cosine), true_deg=true_deg)
    assert uncorrected == pytest.approx(2e-3 / (2.0 * np.pi), rel=0.05)
    assert corrected < 0.02 * uncorrected


def worst(
    ellipse: Ellipse, *, with_error: bool, signals: tuple[np.ndarray, np.ndarray], true_deg: np.ndarray
) -> float:
    """The largest error of the decoded angle, in lines."""
    used = ellipse if with_error else dataclasses.replace(ellipse, line_error=None)
    decoder = Decoder(used, lines=LINES, rate_hz=RATE_HZ)
    part = slice(0, 50_000)  # of one motion: between two the table leaps
    error = (decoder.push(*(one[part] for one in signals)) - true_deg[part]) / LINE_DEG
    error -= np.rint(np.median(error))
    return float(np.abs(error - error.mean()).max())
