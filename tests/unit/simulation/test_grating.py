"""A simulated grating's signals, with and without their faults."""

import math

import numpy as np
import pytest

from gyrotest.simulation.grating import (
    AngleError,
    Grating,
    GratingFigures,
    draw_angle_error,
    draw_grating,
)

PERFECT = GratingFigures(
    amplitude_v=1.0, offset=0.0, mismatch=0.0, quadrature_deg=0.0, harmonic=0.0, ripple=0.0
)
ANGLES_DEG = np.linspace(-3.0, 3.0, 20_001)


def drawn(figures: GratingFigures, lines: int = 900, seed: int = 1) -> Grating:
    return draw_grating(lines, figures, np.random.default_rng(seed))


def decoded_deg(grating: Grating, angle_deg: np.ndarray) -> np.ndarray:
    phase = np.unwrap(np.arctan2(grating.sine_v(angle_deg), grating.cosine_v(angle_deg)))
    return np.degrees(phase - phase[0]) / grating.lines


def test_without_faults_the_phase_is_the_angle_times_the_lines() -> None:
    found = decoded_deg(drawn(PERFECT), ANGLES_DEG)
    assert found == pytest.approx(ANGLES_DEG - ANGLES_DEG[0], abs=1e-9)


def test_the_sine_leads_when_the_angle_grows() -> None:
    grating = drawn(PERFECT)
    quarter_deg = 90.0 / grating.lines
    assert grating.cosine_v(ANGLES_DEG + quarter_deg) == pytest.approx(
        -grating.sine_v(ANGLES_DEG), abs=1e-9
    )


@pytest.mark.parametrize("seed", range(20))
def test_the_faults_stay_within_what_is_said_of_them(seed: int) -> None:
    figures = GratingFigures(ripple=0.0, harmonic=0.0)
    grating = drawn(figures, seed=seed)
    sine, cosine = grating.sine_v(ANGLES_DEG), grating.cosine_v(ANGLES_DEG)
    assert abs(sine.max() + sine.min()) / 2 <= 0.02 + 1e-6
    assert abs(cosine.max() + cosine.min()) / 2 <= 0.02 + 1e-6
    assert abs(np.ptp(cosine) / np.ptp(sine) - 1.0) <= 0.02 + 1e-6
    product = 2.0 * np.mean((sine - sine.mean()) * (cosine - cosine.mean()))
    assert abs(math.degrees(product)) <= 1.05


def test_the_third_harmonic_has_its_share() -> None:
    grating = drawn(GratingFigures(offset=0.0, ripple=0.0, harmonic=0.01, mismatch=0.0))
    turn = np.arange(3600) / 3600 * 360.0 / grating.lines
    lines = np.abs(np.fft.rfft(grating.sine_v(turn))) / 1800
    assert lines[1] == pytest.approx(1.0)
    assert lines[3] == pytest.approx(abs(grating.harmonic))


@pytest.mark.parametrize("seed", range(20))
def test_an_encoder_errs_around_a_turn_and_never_beyond_its_accuracy(seed: int) -> None:
    error = draw_angle_error(0.01, np.random.default_rng(seed))
    turn = np.linspace(0.0, 360.0, 721)
    found = error.read_deg(turn) - turn
    assert np.abs(found).max() <= 0.01
    assert found[0] == pytest.approx(found[-1])
    assert np.abs(found[:360] + found[360:-1]).max() < 1e-9


def test_an_encoder_without_error_reads_the_angle() -> None:
    assert AngleError().read_deg(ANGLES_DEG) is ANGLES_DEG
