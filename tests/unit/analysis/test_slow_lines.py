"""Slow lines: a slow cycle is found, taken out, and leaves the noise what it is."""

import numpy as np
import pytest

from gyrotest.analysis.noise import NoiseModel, identify_noise
from gyrotest.analysis.noise_terms import Grid
from gyrotest.analysis.slow_lines import take_slow_lines
from gyrotest.analysis.slow_modes import slow_modes
from tests.unit.analysis.generator import gyro_noise

SAMPLES = 7200
TIME_S = np.arange(SAMPLES)


def noise(seed: int, **more: float) -> np.ndarray:
    return gyro_noise(SAMPLES, angle_random_walk=1.0, bias_instability=0.1, seed=seed, **more)


def identified(seed: int, amplitude: float, frequency_hz: float) -> NoiseModel:
    cycle = amplitude * np.sin(2.0 * np.pi * frequency_hz * TIME_S + seed)
    return identify_noise(noise(seed) + cycle, sample_rate_hz=1.0)


@pytest.mark.parametrize(("amplitude", "frequency_hz"), [(0.5, 0.003), (2.0, 0.0011), (0.6, 0.0101)])
def test_a_slow_cycle_is_found_with_its_frequency_and_amplitude(
    amplitude: float, frequency_hz: float
) -> None:
    for seed in range(4):
        (line,) = identified(seed, amplitude, frequency_hz).lines
        assert line.frequency_hz == pytest.approx(frequency_hz, abs=0.2 / SAMPLES)
        assert abs(line.amplitude_dps - amplitude) < 4.0 * line.standard_uncertainty_dps


def test_a_slow_cycle_leaves_the_angle_random_walk_what_it_is() -> None:
    walks = [identified(seed, 0.5, 0.003).angle_random_walk for seed in range(20)]
    assert all(one.resolved for one in walks)
    assert np.mean([one.value for one in walks]) == pytest.approx(1.0, abs=0.01)
    assert sum(one.lower_95 <= 1.0 <= one.upper_95 for one in walks) >= 17


@pytest.mark.parametrize("walk", [0.0, 0.05])
def test_noise_alone_has_no_slow_lines(walk: float) -> None:
    found = [
        identify_noise(noise(seed, rate_random_walk=walk), sample_rate_hz=1.0).lines
        for seed in range(25)
    ]
    assert sum(map(len, found)) <= 1


def test_a_strong_ramp_is_no_line() -> None:
    model = identify_noise(noise(1) + 20.0 * TIME_S / SAMPLES, sample_rate_hz=1.0)
    assert model.lines == ()
    assert model.drift is not None


def test_two_cycles_are_told_apart() -> None:
    rate = (
        noise(3)
        + 0.8 * np.sin(2.0 * np.pi * 0.002 * TIME_S)
        + 0.6 * np.cos(2.0 * np.pi * 0.005 * TIME_S)
    )
    found = sorted(one.frequency_hz for one in identify_noise(rate, sample_rate_hz=1.0).lines)
    assert found == pytest.approx([0.002, 0.005], abs=0.2 / SAMPLES)


def test_what_is_taken_out_of_the_modes_is_the_cycle() -> None:
    plain = noise(5)
    grid = Grid(interval_s=1.0, aperture_s=1.0)
    modes = slow_modes(plain + np.sin(2.0 * np.pi * 0.004 * TIME_S), grid)
    cleaned, lines = take_slow_lines(modes, np.zeros(modes.mode_dps.size))
    assert len(lines) == 1
    left = cleaned.mode_dps - slow_modes(plain, grid).mode_dps
    assert np.sum(left**2) < 0.01 * np.sum((modes.mode_dps - cleaned.mode_dps) ** 2)


def test_few_modes_have_no_lines() -> None:
    modes = slow_modes(noise(1)[:120], Grid(interval_s=1.0, aperture_s=1.0))
    cleaned, lines = take_slow_lines(modes, np.zeros(modes.mode_dps.size))
    assert lines == ()
    assert cleaned.mode_dps.tolist() == modes.mode_dps.tolist()
