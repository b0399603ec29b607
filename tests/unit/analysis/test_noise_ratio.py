"""The noise ratio from a record at rest."""

from dataclasses import replace

import numpy as np
import pytest

from gyrotest.analysis.cross_spectra import CrossSpectra, Spectra
from gyrotest.analysis.noise_ratio import known_ratio, noise_ratio
from gyrotest.errors import InsufficientDataError
from tests.unit.analysis.vibration import HIGH_HZ, LOW_HZ, RATE_HZ, Vibration

PLACES = np.array([5.0, 12.0, 40.0, 100.0])
REST = Vibration(reference=0.5, output=2.0, rest=True)


def spectra_of(angle: np.ndarray, output: np.ndarray) -> Spectra:
    made = CrossSpectra(rate_hz=RATE_HZ, low_hz=LOW_HZ, high_hz=HIGH_HZ)
    made.push(angle, output)
    return made.spectra()


def encoder_at_rest(seed: int, duration_s: float) -> Spectra:
    """An encoder whose angle has white noise, and a gyro with white noise of its rate: κ ∝ 1/f²."""
    random = np.random.default_rng(seed)
    samples = int(duration_s * RATE_HZ)
    return spectra_of(random.normal(size=samples), random.normal(size=samples))


@pytest.mark.parametrize("duration_s", [4.0, 20.0])
def test_a_short_record_gives_the_ratio_within_its_own_uncertainty(duration_s: float) -> None:
    scores = []
    for seed in range(100):
        found = noise_ratio(REST.spectra((seed, 3), duration_s=duration_s))
        spread = np.linalg.norm(found.deviations(PLACES), axis=1)
        scores.append(np.log(found.at(PLACES) / REST.ratio) / spread)
    z = np.array(scores)
    assert np.all(np.abs(z.mean(axis=0)) < 0.3)
    assert np.all((z.std(axis=0) > 0.8) & (z.std(axis=0) < 1.25))


def test_an_encoder_s_noise_that_grows_with_the_frequency_is_followed() -> None:
    expected = 1.0 / (2.0 * np.pi * PLACES) ** 2
    found = [noise_ratio(encoder_at_rest(seed, 20.0)).at(PLACES) for seed in range(60)]
    np.testing.assert_allclose(np.mean(np.log(found), axis=0), np.log(expected), atol=0.08)


def test_a_line_of_interference_moves_the_ratio_little() -> None:
    random = np.random.default_rng(8)
    time_s = np.arange(int(60.0 * RATE_HZ)) / RATE_HZ
    angle, output = random.normal(size=(2, time_s.size))
    hum = 2.0 * np.sin(2.0 * np.pi * 50.0 * time_s)
    without, found = spectra_of(angle, output), spectra_of(angle, output + hum)
    assert (found.output / without.output).max() > 100.0
    ratio = noise_ratio(found).at(PLACES) / noise_ratio(without).at(PLACES)
    np.testing.assert_allclose(ratio, 1.0, atol=0.2)


def test_what_both_channels_see_at_rest_is_told() -> None:
    assert noise_ratio(REST.spectra(1, duration_s=60.0)).coherence == pytest.approx(0.0, abs=0.02)
    shaken = replace(REST, rest=False)
    assert noise_ratio(shaken.spectra(1, duration_s=60.0)).coherence == pytest.approx(0.21, abs=0.03)
    assert noise_ratio(REST.spectra(1, duration_s=4.0)).coherence is None


def test_a_channel_without_any_noise_leaves_all_of_it_to_the_other() -> None:
    random = np.random.default_rng(8)
    noise, still = random.normal(size=8000), np.full(8000, 1.25)
    assert noise_ratio(spectra_of(still, noise)).at(PLACES).tolist() == [np.inf] * 4
    assert noise_ratio(spectra_of(noise, still)).at(PLACES).tolist() == [0.0] * 4


def test_two_channels_without_any_noise_are_refused() -> None:
    still = np.full(8000, 1.25)
    with pytest.raises(InsufficientDataError, match="both channels stand still at rest"):
        noise_ratio(spectra_of(still, still))


def test_a_ratio_is_not_extrapolated() -> None:
    found = noise_ratio(REST.spectra(1, duration_s=20.0))
    for frequency_hz in (4.75, 100.25):
        with pytest.raises(InsufficientDataError, match=r"known for 5 … 100 Hz.*same segments and band"):
            found.at(np.array([50.0, frequency_hz]))


def test_a_known_ratio_is_the_same_everywhere_and_certain() -> None:
    found = known_ratio(0.3)
    assert found.at(PLACES).tolist() == [0.3] * 4
    assert found.deviations(PLACES).shape == (4, 0)
    with pytest.raises(ValueError, match="0 or more"):
        known_ratio(-1.0)
    with pytest.raises(ValueError, match="0 or more"):
        known_ratio(float("nan"))
