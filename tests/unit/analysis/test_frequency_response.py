"""The estimators, the coherence and the random error, where the truth is known."""

from dataclasses import replace

import numpy as np
import pytest

from gyrotest.analysis.cross_spectra import CrossSpectra, Spectra
from gyrotest.analysis.frequency_response import coherence, h1, h2, hv, random_error
from gyrotest.analysis.noise_ratio import known_ratio, noise_ratio
from gyrotest.errors import InsufficientDataError
from tests.unit.analysis.vibration import Truth, Vibration

UNITS = 16
NOISE = 0.02


def log_error(gain: np.ndarray, spectra: Spectra, truth: Truth) -> float:
    """Mean relative error of the gain over the band, in which noise is a steady share."""
    low = spectra.frequency_hz < 40.0
    return float(np.mean(np.log(gain[low] / np.abs(truth.response(spectra.frequency_hz[low])))))


def exact(kappa: float, gain: float = 1.0, lag: float = 0.3) -> Spectra:
    """The spectra themselves, without any scatter: signal 1, and noise."""
    lines = np.linspace(5.0, 100.0, 20)
    reference = np.full(20, 1.0 + NOISE)
    return Spectra(
        frequency_hz=lines,
        reference=reference,
        output=np.full(20, gain**2 + kappa * NOISE),
        cross=np.full(20, gain * np.exp(-1j * lag)),
        segments=100,
        averages=95.0,
        segment_s=1.0,
        correlation=np.array([1.0]),
    )


@pytest.mark.parametrize("kappa", [1e-9, 0.1, 1.0, 10.0, 1e9])
@pytest.mark.parametrize("gain", [0.05, 1.0, 40.0])
def test_hv_is_exact_for_exact_spectra(kappa: float, gain: float) -> None:
    found = hv(exact(kappa, gain), known_ratio(kappa))
    np.testing.assert_allclose(found.gain, gain, rtol=1e-6)
    np.testing.assert_allclose(found.phase_deg, -np.degrees(0.3), rtol=1e-12)


def test_hv_becomes_h1_and_h2_where_one_channel_has_all_noise() -> None:
    spectra = exact(1.0)
    np.testing.assert_allclose(hv(spectra, known_ratio(np.inf)).gain, h1(spectra).gain)
    np.testing.assert_allclose(hv(spectra, known_ratio(1e12)).gain, h1(spectra).gain, rtol=1e-9)
    np.testing.assert_allclose(hv(spectra, known_ratio(0.0)).gain, h2(spectra).gain)


def test_the_source_s_estimator_is_wrong_where_only_the_gyro_has_noise() -> None:
    spectra = replace(exact(0.0), reference=np.ones(20), output=np.full(20, 1.0 / 0.96))
    assert hv(spectra, known_ratio(1.0)).gain[0] == pytest.approx(1.0211, abs=1e-4)
    assert h1(spectra).gain[0] == pytest.approx(1.0)


@pytest.mark.parametrize("kappa", [0.1, 1.0, 10.0])
@pytest.mark.parametrize("gain", [1.0, 0.05])
def test_hv_is_unbiased_where_h1_and_h2_are_not(kappa: float, gain: float) -> None:
    truth = Truth(gain=gain)
    vibration = Vibration(truth=truth, reference=NOISE / kappa**0.5, output=NOISE * kappa**0.5)
    assert vibration.ratio == pytest.approx(kappa * gain**2)
    errors = []
    for seed in range(UNITS):
        spectra = vibration.spectra((seed, 1), duration_s=120.0)
        rest = replace(vibration, rest=True).spectra((seed, 2), duration_s=60.0)
        found = (h1(spectra), h2(spectra), hv(spectra, noise_ratio(rest)))
        errors.append([log_error(one.gain, spectra, truth) for one in found])
    mean = np.mean(errors, axis=0)
    assert mean[0] == pytest.approx(-np.log1p(vibration.reference), abs=2e-3)
    assert mean[1] == pytest.approx(np.log1p(vibration.output), abs=2e-3)
    standard_error = np.std(errors, axis=0, ddof=1)[2] / UNITS**0.5
    assert abs(mean[2]) < max(3.0 * standard_error, 1e-3)
    assert abs(mean[2]) < 0.4 * np.abs(mean[:2]).min()


def test_a_pure_delay_has_its_exact_phase() -> None:
    delay_s = 1.7e-3
    truth = Truth(natural_hz=1e9, damping=0.0, delay_s=delay_s)
    found = hv(
        Vibration(truth=truth, reference=0.0, output=0.0).spectra(3, duration_s=120.0), known_ratio(1.0)
    )
    np.testing.assert_allclose(found.phase_deg, -360.0 * found.frequency_hz * delay_s, atol=0.03)
    np.testing.assert_allclose(found.gain, 1.0, rtol=1e-3)
    assert np.mean(found.phase_deg / found.frequency_hz) == pytest.approx(-360.0 * delay_s, rel=1e-4)


def test_scatter_over_many_runs_is_what_the_random_error_says() -> None:
    vibration = Vibration(reference=0.01, output=0.04)
    found = [
        hv(vibration.spectra((seed, 4), duration_s=42.0), known_ratio(vibration.ratio))
        for seed in range(200)
    ]
    promised = np.sqrt(np.mean([one.error**2 for one in found]))
    gain = np.sqrt(np.mean(np.var([np.log(one.gain) for one in found], axis=0, ddof=1)))
    phase = np.sqrt(np.mean(np.var([np.radians(one.phase_deg) for one in found], axis=0, ddof=1)))
    assert 0.9 < gain / promised < 1.15
    assert 0.9 < phase / promised < 1.15
    np.testing.assert_allclose(found[0].phase_error_deg, np.degrees(found[0].error))


@pytest.mark.parametrize("noise", [0.01, 0.5])
def test_coherence_is_not_feigned_by_few_averages(noise: float) -> None:
    vibration = Vibration(reference=noise, output=noise)
    found = [vibration.spectra((seed, 5), duration_s=18.0) for seed in range(40)]
    low = found[0].frequency_hz < 40.0
    raw = [np.abs(one.cross) ** 2 / (one.reference * one.output) for one in found]
    corrected = [coherence(one) for one in found]
    expected = np.mean(np.abs(1.0 / (1.0 + noise)) ** 2)
    assert np.mean(corrected, axis=0)[low].mean() == pytest.approx(expected, abs=0.015)
    if noise == 0.5:
        assert np.mean(raw, axis=0)[low].mean() > expected + 0.02


def test_no_coherence_at_all_is_close_to_none_and_has_no_error_bound() -> None:
    rest = Vibration(reference=1.0, output=1.0, rest=True).spectra(1, duration_s=60.0)
    assert coherence(rest).mean() < 0.02
    assert np.isinf(random_error(np.array([0.0]), 10.0)[0])
    assert random_error(np.array([1.0]), 10.0)[0] == 0.0


def test_a_gain_is_wrong_by_no_more_than_the_noise_ratio_says() -> None:
    vibration = Vibration(reference=0.2, output=0.2)
    spectra = vibration.spectra(1, duration_s=60.0)
    ratio = noise_ratio(replace(vibration, rest=True).spectra(2, duration_s=12.0))
    found = hv(spectra, ratio)
    assert ratio.curve is not None
    step = 1e-4 * ratio.deviations(spectra.frequency_hz)[:, 0]
    moved = [hv(spectra, known_ratio(k)).gain for k in ratio.at(spectra.frequency_hz) * np.exp(step)]
    change = np.log(np.diag(np.array(moved)) / found.gain)
    np.testing.assert_allclose(change, 1e-4 * found.common[:, 0], atol=1e-9)


def test_too_few_averages_are_refused() -> None:
    spectra = Vibration().spectra(1, duration_s=14.0)
    with pytest.raises(
        InsufficientDataError, match=r"6 segments of 4 s .* 5\.7 independent .*record 22 s"
    ):
        h1(spectra)
    assert h1(Vibration().spectra(1, duration_s=22.0)).averages > 8.0


@pytest.mark.parametrize("estimator", [h1, lambda one: hv(one, known_ratio(1.0))])
def test_a_table_that_stands_still_is_refused(estimator: object) -> None:
    made = CrossSpectra(rate_hz=400.0, low_hz=5.0, high_hz=100.0)
    made.push(np.zeros(20_000), np.random.default_rng(1).normal(size=20_000))
    with pytest.raises(InsufficientDataError, match=r"does not move at 5 Hz \(381 of 381"):
        estimator(made.spectra())  # type: ignore[operator]


def test_an_output_that_stands_still_is_refused() -> None:
    made = CrossSpectra(rate_hz=400.0, low_hz=5.0, high_hz=100.0)
    made.push(np.random.default_rng(1).normal(size=20_000), np.zeros(20_000))
    with pytest.raises(InsufficientDataError, match="output does not move"):
        h2(made.spectra())
