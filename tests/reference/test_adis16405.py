"""A real ADIS16405 at rest (100 Hz, 10,000 s): independent values at their printed digits."""

from pathlib import Path

import numpy as np
import pytest

from gyrotest.analysis.allan import overlapping_allan_deviation
from gyrotest.analysis.noise import identify_noise, spectral_lines
from gyrotest.procedures.static import Static, StaticParameters
from gyrotest.records.plan import Context, Reduction
from gyrotest.records.recording import Samples, Sampling
from gyrotest.records.spec import Case, Output, OutputKind
from gyrotest.units import Quantity

AXES = {
    "x": (0, "0.351262", ["157.12", "63.89", "39.94"], ["0.0417836", "0.0137139", "0.00816336"]),
    "y": (1, "-0.427151", ["166.28", "74.86", "48.58"], ["0.0435577", "0.0151309", "0.00828626"]),
    "z": (2, "-0.285648", ["160.48", "86.60", "69.82"], ["0.0392371", "0.0133167", "0.00837470"]),
}


def rates(folder: Path, axis: str) -> np.ndarray:
    archive = np.load(folder / "adis16405-static" / "gyro_lsb.npz")
    return archive["gyro_lsb"][:, AXES[axis][0]] * float(archive["lsb_dps"])


def reduced(rate: np.ndarray) -> Reduction:
    case = Case(procedure="static", duration=Quantity(10000.0, "s"), interval=Quantity(10.0, "ms"))
    context = Context(
        case_name="static",
        case=case,
        parameters=StaticParameters(),
        output=Output(kind=OutputKind.RATE),
        datasheet={},
        accuracy=None,
        site=None,
    )
    sampling = Sampling(interval_s=0.01, aperture_s=0.01, unit="deg/s")
    flags = np.zeros(rate.size, dtype=np.uint8)
    return Static().reduce(Samples(sampling=sampling, values=rate[:, None], flags=flags), context)


@pytest.mark.parametrize("axis", list(AXES))
def test_bias_and_bias_stability_of_each_axis(real_data: Path, axis: str) -> None:
    _, bias, stabilities, _ = AXES[axis]
    results = {one.name: one.value or 0.0 for one in reduced(rates(real_data, axis)).results}
    assert f"{results['bias']:.6f}" == bias
    found = [f"{results[f'bias_stability_{name}']:.2f}" for name in ("1s", "10s", "100s")]
    assert found == stabilities


@pytest.mark.parametrize("axis", list(AXES))
def test_the_overlapping_allan_deviation_of_each_axis(real_data: Path, axis: str) -> None:
    curve = overlapping_allan_deviation(
        rates(real_data, axis), sample_rate_hz=100.0, averaging_factors=[100, 1000, 10000]
    )
    found = [f"{one:#.6g}" for one in curve.deviation_dps]
    assert found == AXES[axis][3]


def test_the_sensors_filter_is_kept_out_of_the_angle_random_walk(real_data: Path) -> None:
    rate = rates(real_data, "x")
    results = {one.name: one for one in reduced(rate).results}
    naive = 60.0 * 0.1 * float(np.sqrt(np.mean(np.diff(rate) ** 2) / 2.0))
    found = results["angle_random_walk"].value
    assert found == pytest.approx(0.0417836 * 60.0, rel=0.03)
    assert naive < 0.8 * 2.45


def test_the_sources_formula_gives_the_same_stability(real_data: Path) -> None:
    """With 50 mV/(°/s) its program computes 3600/50 · std(data in mV)."""
    rate = rates(real_data, "x")[:100_000]
    millivolts = rate.reshape(-1, 100).mean(axis=1) * 50.0
    results = {one.name: one.value for one in reduced(rate).results}
    expected = 3600.0 / 50.0 * np.std(millivolts, ddof=1)
    assert results["bias_stability_1s"] == pytest.approx(expected, rel=1e-12)


def test_the_z_axiss_line_near_20_hz_is_found_and_the_y_axis_has_none(real_data: Path) -> None:
    (line,) = spectral_lines(rates(real_data, "z"), sample_rate_hz=100.0)
    assert line.line.frequency_hz == pytest.approx(19.72, abs=0.02)
    assert line.line.amplitude_dps == pytest.approx(0.333, rel=0.05)
    assert spectral_lines(rates(real_data, "y"), sample_rate_hz=100.0) == ()


@pytest.mark.parametrize("axis", list(AXES))
def test_the_noise_is_taken_from_beyond_the_sensors_filter(real_data: Path, axis: str) -> None:
    """At 1 s the Allan deviation is nearly all angle random walk; at 0.01 s it is filtered, of z it rings."""
    model = identify_noise(rates(real_data, axis), sample_rate_hz=100.0)
    assert model.first_tau_s >= 0.1
    walk, flicker = model.angle_random_walk, model.bias_instability_coefficient
    at_1_s = float(AXES[axis][3][0])
    assert walk.resolved
    assert walk.value == pytest.approx((at_1_s**2 - 0.4413 * flicker.value**2) ** 0.5, rel=0.02)
    assert walk.standard_uncertainty < 0.01 * walk.value
    assert flicker.resolved
    assert 0.6643 * flicker.value == pytest.approx(float(AXES[axis][3][2]), rel=0.3)
    assert not model.quantization_noise.resolved
    assert model.fit_probability > 0.01
