"""The response to a sine of the table: exact where it must be, honest where noise acts, refused where unfit."""

import numpy as np
import pytest
from scipy.signal import bilinear, lfilter

from gyrotest.analysis.sine_envelope import fit_envelope
from gyrotest.analysis.sine_fit import three_parameter_fit
from gyrotest.analysis.sine_response import SineResponse, steady_response, swept_response
from gyrotest.errors import InsufficientDataError

INTERVAL_S = 2.5e-4
NATURAL_HZ, DAMPING, DELAY_S, SCALE = 90.0, 0.6, 7.3e-4, 0.05
PEAK_DPS = 14.0


def true_ratio(frequency_hz: float, delay_s: float = DELAY_S) -> complex:
    s = 1j * frequency_hz / NATURAL_HZ
    lag = np.exp(-2j * np.pi * frequency_hz * delay_s)
    return complex(SCALE * lag / (1.0 + 2.0 * DAMPING * s + s * s))


def steady(
    frequency_hz: float, ratio: complex, *, samples: int = 20_000, seed: int | None = None
) -> dict[str, np.ndarray]:
    wave = 2.0 * np.pi * frequency_hz * np.arange(samples) * INTERVAL_S + 0.8
    angle_deg = 0.01 + PEAK_DPS / (2.0 * np.pi * frequency_hz) * np.sin(wave)
    output = 0.2 + PEAK_DPS * abs(ratio) * np.cos(wave + np.angle(ratio))
    if seed is not None:
        rng = np.random.default_rng(seed)
        angle_deg = angle_deg + 2e-6 * rng.normal(size=samples)
        # noise that has passed the gyro's own band: far from white at the sampling rate
        output = output + lfilter([0.05], [1.0, -0.95], 0.02 * rng.normal(size=samples))
    return {"angle_deg": angle_deg, "output": output}


def response(frequency_hz: float, asked_hz: float | None = None, **changes: int) -> SineResponse:
    ratio = true_ratio(frequency_hz)
    return steady_response(
        **steady(frequency_hz, ratio, **changes),
        interval_s=INTERVAL_S,
        frequency_hz=asked_hz or frequency_hz,
    )


@pytest.mark.parametrize("frequency_hz", [5.0, 19.87, 50.0, 100.3])
def test_gain_and_phase_are_exact_without_noise(frequency_hz: float) -> None:
    found = response(frequency_hz)
    assert found.ratio == pytest.approx(true_ratio(frequency_hz), rel=1e-9)
    assert found.frequency_hz == pytest.approx(frequency_hz, rel=1e-10)
    assert found.rate_dps == pytest.approx(PEAK_DPS, rel=1e-9)


@pytest.mark.parametrize("delay_s", [1e-4, 3.217e-3])
def test_a_known_delay_gives_the_exact_phase(delay_s: float) -> None:
    for frequency_hz in (5.0, 40.0, 80.0):
        ratio = SCALE * np.exp(-2j * np.pi * frequency_hz * delay_s)
        found = steady_response(
            **steady(frequency_hz, ratio), interval_s=INTERVAL_S, frequency_hz=frequency_hz
        )
        expected_deg = (-360.0 * frequency_hz * delay_s + 180.0) % 360.0 - 180.0
        assert found.phase_deg == pytest.approx(expected_deg, abs=1e-7)
        assert found.gain == pytest.approx(SCALE, rel=1e-9)


def test_a_drive_that_is_off_by_parts_in_a_thousand_is_found() -> None:
    found = response(20.013, asked_hz=20.0)
    assert found.frequency_hz == pytest.approx(20.013, rel=1e-9)
    assert found.ratio == pytest.approx(true_ratio(20.013), rel=1e-9)


def test_scatter_under_coloured_noise_is_what_the_response_says() -> None:
    frequency_hz, errors, stated = 20.0, [], []
    for seed in range(200):
        found = response(frequency_hz, samples=8000, seed=seed)
        errors.append(found.ratio / true_ratio(frequency_hz) - 1.0)
        stated.append(found.relative_uncertainty)
    z = np.array(errors) / np.array(stated)
    for part in (z.real, z.imag):
        assert abs(part.mean()) < 4.0 / np.sqrt(200)
        assert 0.85 < part.std(ddof=1) < 1.2
    assert found.degrees_of_freedom == 32.0


def test_noise_as_if_white_would_have_been_told_too_small() -> None:
    values = steady(20.0, true_ratio(20.0), samples=8000, seed=3)["output"]
    fit = three_parameter_fit(values, frequency_hz=20.0, interval_s=INTERVAL_S)
    told = response(20.0, samples=8000, seed=3).relative_uncertainty
    assert told > 3.0 * fit.amplitude_uncertainty / fit.amplitude


def test_motion_beside_the_sine_is_no_noise() -> None:
    both = steady(20.0, true_ratio(20.0))
    samples = both["angle_deg"].size
    wave = 2.0 * np.pi * 20.6 * np.arange(samples) * INTERVAL_S
    both["angle_deg"] = both["angle_deg"] + 0.1 / (2.0 * np.pi * 20.6) * np.sin(wave)
    ratio = true_ratio(20.6)
    both["output"] = both["output"] + 0.1 * abs(ratio) * np.cos(wave + np.angle(ratio))
    found = steady_response(**both, interval_s=INTERVAL_S, frequency_hz=20.0)
    assert abs(found.ratio / true_ratio(20.0) - 1.0) < 1e-4
    assert found.relative_uncertainty < 1e-4  # of an amplitude of which 0.7 % lie beside


def swept(low_hz: float, growth_per_s: float, duration_s: float, late_s: float) -> dict[str, np.ndarray]:
    """A sweep of an even rate, through a second-order gyro with a delay of two samples."""
    finer = 8
    time_s = np.arange(round(duration_s / INTERVAL_S) * finer) * INTERVAL_S / finer - late_s
    phase = (
        2.0
        * np.pi
        * low_hz
        * np.where(time_s < 0.0, time_s, np.expm1(growth_per_s * np.maximum(time_s, 0.0)) / growth_per_s)
    )
    rate = PEAK_DPS * np.cos(phase)
    turned = np.cumsum((rate[1:] + rate[:-1]) / 2.0) * INTERVAL_S / finer
    omega = 2.0 * np.pi * NATURAL_HZ
    system = [omega**2], [1.0, 2.0 * DAMPING * omega, omega**2]
    numerator, denominator = bilinear(*system, fs=finer / INTERVAL_S)
    output = SCALE * lfilter(numerator, denominator, rate)[::finer]
    return {
        "angle_deg": np.concatenate(([0.0], turned))[::finer],
        "output": 2.5 + np.concatenate((output[:1].repeat(2), output[:-2])),
    }


@pytest.mark.parametrize("late_s", [0.0, 0.4])
def test_a_sweep_gives_the_response_at_any_frequency_it_passes(late_s: float) -> None:
    growth_per_s = 0.03
    channels = swept(8.0, growth_per_s, 80.0, late_s)
    for frequency_hz in (9.0, 20.0, 50.0, 70.0):
        found = swept_response(
            **channels,
            interval_s=INTERVAL_S,
            frequency_hz=frequency_hz,
            low_hz=8.0,
            growth_per_s=growth_per_s,
        )
        error = found.ratio / true_ratio(found.frequency_hz, 2.0 * INTERVAL_S) - 1.0
        assert found.frequency_hz == pytest.approx(frequency_hz, rel=1e-5)
        assert abs(error.real) < 2e-4
        assert abs(np.degrees(error.imag)) < 0.01
        assert found.rate_dps == pytest.approx(PEAK_DPS, rel=1e-4)


def evaluated(frequency_hz: float, growth_per_s: float) -> SineResponse:
    return swept_response(
        **swept(8.0, 0.03, 80.0, 0.0),
        interval_s=INTERVAL_S,
        frequency_hz=frequency_hz,
        low_hz=8.0,
        growth_per_s=growth_per_s,
    )


def test_a_sweep_that_is_too_fast_or_too_short_is_refused() -> None:
    with pytest.raises(InsufficientDataError, match="too fast: 8 periods"):
        evaluated(9.0, 0.11)
    for frequency_hz in (8.1, 87.0):
        with pytest.raises(InsufficientDataError, match=f"does not hold {frequency_hz:g} Hz"):
            evaluated(frequency_hz, 0.03)


def test_a_table_that_creeps_does_not_leak_into_its_sine() -> None:
    both = steady(50.0, true_ratio(50.0))
    time_s = np.arange(both["angle_deg"].size) * INTERVAL_S
    both["angle_deg"] = both["angle_deg"] + 0.3 * time_s - 0.02 * time_s**2
    both["output"] = both["output"] + SCALE * (0.3 - 0.04 * time_s)
    found = steady_response(**both, interval_s=INTERVAL_S, frequency_hz=50.0)
    assert found.ratio == pytest.approx(true_ratio(50.0), rel=1e-6)


def test_an_angle_that_does_not_follow_the_sweep_is_refused() -> None:
    angle = 0.3 * np.random.default_rng(1).normal(size=320_000)
    with pytest.raises(InsufficientDataError, match="does not follow the sweep"):
        swept_response(
            angle,
            angle,
            interval_s=INTERVAL_S,
            frequency_hz=20.0,
            low_hz=8.0,
            growth_per_s=0.03,
        )


def test_what_is_no_response_is_refused() -> None:
    with pytest.raises(InsufficientDataError, match="9 whole periods of 20 Hz"):
        response(20.0, samples=1990)
    with pytest.raises(InsufficientDataError, match=r"moves at 20.5 Hz, and was asked for 20 Hz"):
        response(20.5, asked_hz=20.0)
    faint = steady(20.0, true_ratio(20.0))
    noise = 0.2 * np.random.default_rng(2).normal(size=faint["angle_deg"].size)
    faint["angle_deg"] = 0.01 * faint["angle_deg"] + 1e-1 * noise
    with pytest.raises(InsufficientDataError, match="does not let tell; raise the level"):
        steady_response(**faint, interval_s=INTERVAL_S, frequency_hz=20.0)


def test_an_envelope_of_order_nought_is_a_sine_fit() -> None:
    values = steady(20.0, true_ratio(20.0), seed=4)["output"]
    ticks = np.arange(values.size) - (values.size - 1) / 2.0
    wave = np.exp(2j * np.pi * 20.0 * INTERVAL_S * ticks)
    envelope = fit_envelope(values, wave, order=0, drift=0)
    fit = three_parameter_fit(values, frequency_hz=20.0, interval_s=INTERVAL_S)
    turned = fit.phasor * np.exp(2j * np.pi * 20.0 * INTERVAL_S * (values.size - 1) / 2.0)
    assert envelope.middle == pytest.approx(complex(turned), rel=1e-9)
    assert envelope.residual_rms == pytest.approx(fit.residual_rms, rel=1e-9)
