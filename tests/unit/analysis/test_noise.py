"""Noise identification: truths recovered with honest uncertainties; what spoils a record."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.signal import butter, lfilter

from gyrotest.analysis.allan import overlapping_allan_deviation
from gyrotest.analysis.noise import NoiseModel, fitted_factors, fourth_cumulant, identify_noise
from gyrotest.errors import InsufficientDataError
from tests.unit.analysis.generator import DPH, gyro_noise

ARW = 30 * DPH
HOUR = np.arange(3600.0)


def honest(model: NoiseModel) -> NoiseModel:
    """Check what holds of every model, whatever the record."""
    for term in model.terms:
        bounds = [term.lower_95, term.lower_68, term.value, term.upper_68, term.upper_95]
        assert np.isfinite([*bounds, term.standard_uncertainty]).all()
        assert bounds == sorted(bounds)
        assert term.lower_95 >= 0.0
        assert term.upper_95 > 0.0
        assert term.standard_uncertainty > 0.0
        assert term.resolved == (term.lower_95 > 0.0)
    assert np.isfinite(model.covariance).all()
    assert (np.diag(model.covariance) >= 0.0).all()
    assert 0.0 <= model.fit_probability <= 1.0
    assert 0.0 < model.first_tau_s < model.last_tau_s
    assert model.misfit >= 0.0
    return model


def identified(seed: int, samples: int = 3600, **truth: float) -> NoiseModel:
    return identify_noise(gyro_noise(samples, seed=seed, **truth), sample_rate_hz=1.0)


def test_angle_random_walk_and_bias_instability_are_recovered_within_their_uncertainty() -> None:
    truth = {"angle_random_walk": 30 * DPH, "bias_instability": 8 * DPH, "rate_random_walk": 0.05 * DPH}
    models = [identified(seed, **truth) for seed in range(40)]
    walks = [model.angle_random_walk for model in models]
    z = [(one.value - truth["angle_random_walk"]) / one.standard_uncertainty for one in walks]
    assert abs(np.mean(z)) < 0.4
    assert 0.75 < np.std(z, ddof=1) < 1.3
    flickers = [model.bias_instability_coefficient for model in models]
    covered = [one.lower_95 <= truth["bias_instability"] <= one.upper_95 for one in flickers]
    assert sum(covered) >= 35
    assert all(one.resolved for one in walks)


def test_an_unresolved_term_has_an_upper_limit_that_holds() -> None:
    models = [identified(seed, angle_random_walk=30 * DPH) for seed in range(40)]
    walks = [model.rate_random_walk for model in models]
    assert all(one.upper_95 > 0.0 for one in walks)
    assert sum(one.resolved for one in walks) <= 4
    assert all(one.lower_95 == 0.0 for one in walks if not one.resolved)


def test_a_strong_rate_random_walk_is_resolved() -> None:
    model = identified(3, samples=36_000, angle_random_walk=30 * DPH, rate_random_walk=5 * DPH)
    walk = model.rate_random_walk
    assert walk.resolved
    assert walk.lower_95 < 5 * DPH < walk.upper_95


def test_dead_time_inflates_the_apparent_walk_only() -> None:
    fine = gyro_noise(6 * 36_000, interval_s=1 / 6, angle_random_walk=30 * DPH, seed=5)
    coarse = fine.reshape(-1, 6)[:, 0]
    model = identify_noise(coarse, sample_rate_hz=1.0, duty=1 / 6)
    assert model.angle_random_walk.value == pytest.approx(30 * DPH * np.sqrt(6.0), rel=0.02)


def test_a_low_pass_filter_is_kept_out_of_the_fit() -> None:
    found = []
    for seed in range(6):
        fine = gyro_noise(200_000, interval_s=0.01, angle_random_walk=0.04, seed=seed)
        filtered = np.convolve(fine, np.ones(5) / 5.0, mode="valid")
        model = identify_noise(filtered, sample_rate_hz=100.0)
        assert model.first_tau_s > 0.05
        found.append(model.angle_random_walk.value)
    # At the shortest time the filter leaves 0.008.
    assert np.mean(found) == pytest.approx(0.04, rel=0.03)


def test_a_curve_at_hand_gives_the_same_model() -> None:
    rate = gyro_noise(3600, angle_random_walk=1.0, bias_instability=0.3)
    wanted = np.union1d(fitted_factors(3600), [7, 77])
    curve = overlapping_allan_deviation(rate, sample_rate_hz=1.0, averaging_factors=wanted.tolist())
    given = identify_noise(rate, sample_rate_hz=1.0, deviation=curve)
    assert given.squares.tolist() == identify_noise(rate, sample_rate_hz=1.0).squares.tolist()


def test_the_fitted_curve_runs_through_the_points() -> None:
    rate = gyro_noise(36_000, angle_random_walk=1.0, bias_instability=0.3)
    model = identify_noise(rate, sample_rate_hz=1.0)
    curve = overlapping_allan_deviation(rate, sample_rate_hz=1.0, averaging_factors=[1, 10, 100])
    fitted = model.allan_deviation_dps(curve.averaging_factor)
    np.testing.assert_allclose(fitted, curve.deviation_dps, rtol=0.1)
    assert model.misfit < 3.0


@pytest.mark.parametrize("samples", [2, 35])
def test_a_short_record_is_refused(samples: int) -> None:
    with pytest.raises(InsufficientDataError, match=f"has {samples} samples; a noise model needs"):
        identify_noise(np.arange(float(samples)), sample_rate_hz=1.0)


def test_the_shortest_record_is_enough() -> None:
    assert identified(1, samples=36, angle_random_walk=1.0).angle_random_walk.upper_95 > 0.5


@given(st.floats(1e-12, 1e9), st.sampled_from([36, 1000, 5000]))
@settings(max_examples=12, deadline=None)
def test_coefficients_scale_with_the_record(scale: float, samples: int) -> None:
    rate = gyro_noise(samples, angle_random_walk=1.0, bias_instability=0.3)
    wanted = identify_noise(rate, sample_rate_hz=1.0)
    found = identify_noise(scale * rate, sample_rate_hz=1.0)
    for one, scaled in zip(wanted.terms, found.terms, strict=True):
        assert scaled.value == pytest.approx(scale * one.value, rel=1e-4, abs=1e-6 * scale)
        assert scaled.upper_95 == pytest.approx(scale * one.upper_95, rel=1e-4)


@given(st.floats(-1e6, 1e6))
@settings(max_examples=8, deadline=None)
def test_an_offset_changes_nothing(offset: float) -> None:
    rate = gyro_noise(3600, angle_random_walk=1.0, bias_instability=0.3)
    wanted = identify_noise(rate, sample_rate_hz=1.0).squares
    found = identify_noise(rate + offset, sample_rate_hz=1.0).squares
    np.testing.assert_allclose(found, wanted, rtol=1e-4, atol=1e-7)


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_a_record_backwards_has_the_same_coefficients(seed: int) -> None:
    rate = gyro_noise(
        3600, angle_random_walk=1.0, bias_instability=0.3, rate_random_walk=0.02, seed=seed
    )
    rate += HOUR / 1000.0
    wanted = identify_noise(rate, sample_rate_hz=1.0)
    found = identify_noise(rate[::-1], sample_rate_hz=1.0)
    # The tail shorter than a block is another one.
    np.testing.assert_allclose(found.squares, wanted.squares, rtol=0.1, atol=1e-5)


@pytest.mark.parametrize("rate_hz", [0.01, 0.3, 125.0, 10_000.0])
def test_the_unit_of_time_is_free(rate_hz: float) -> None:
    rate = gyro_noise(3600, angle_random_walk=1.0, bias_instability=0.3)
    wanted = identify_noise(rate, sample_rate_hz=1.0)
    found = identify_noise(rate, sample_rate_hz=rate_hz)
    for power, one, other in zip((-1.0, -0.5, 0.0, 0.5, 1.0), wanted.terms, found.terms, strict=True):
        assert other.upper_95 == pytest.approx(one.upper_95 * rate_hz**power, rel=1e-4)


@pytest.mark.parametrize("samples", [36, 37, 53, 64, 97, 100])
def test_tiny_records_of_whatever_kind_have_honest_models(samples: int) -> None:
    random = np.random.default_rng(samples)
    white, count = random.standard_normal(samples), np.arange(samples)
    for rate in (
        white,
        np.cumsum(white),
        np.diff(random.standard_normal(samples + 1)),
        np.round(white),
        np.sin(0.3 * count),
        (-1.0) ** count,
        1.0 * (count > samples // 2),
        10.0 * (count > samples // 2) + white,
        1.0 * (count == samples // 3),
        np.where(count < samples // 2, 0.0, white),
        count + 0.1 * white,
    ):
        honest(identify_noise(rate, sample_rate_hz=1.0))


@pytest.mark.parametrize("samples", [3600, 10_007])
def test_records_that_are_no_plain_noise_have_honest_models(samples: int) -> None:
    random = np.random.default_rng(samples)
    white, count = random.standard_normal(samples), np.arange(samples)
    for rate in (
        1e9 + white,
        1e12 + white,
        np.round(0.5 * white),
        np.cumsum(white),
        np.cumsum(np.cumsum(white)),
        np.sin(0.3 * count),
        10.0 * np.sin(2.0 * np.pi * count / samples) + white,
        1e3 * (count > samples // 3) + white,
        1e4 * (count == samples // 3) + white,
        np.where((count > samples // 4) & (count < samples // 2), 0.0, white),
        np.repeat(white, 10)[:samples],
        random.standard_cauchy(samples),
    ):
        honest(identify_noise(rate, sample_rate_hz=100.0))


def test_a_record_of_a_million_samples_a_prime_of_them() -> None:
    rate = np.random.default_rng(2).standard_normal(1_000_003)
    walk = honest(identify_noise(rate, sample_rate_hz=1.0)).angle_random_walk
    assert walk.value == pytest.approx(1.0, abs=4.0 * walk.standard_uncertainty)
    assert walk.standard_uncertainty < 0.003


@pytest.mark.parametrize("duty", [1.0, 0.5, 0.1, 0.01])
def test_any_duty_has_an_honest_model(duty: float) -> None:
    honest(identify_noise(gyro_noise(3600, angle_random_walk=1.0), sample_rate_hz=1.0, duty=duty))


def test_intervals_hold_the_truth() -> None:
    truth = {"angle_random_walk": ARW, "bias_instability": 8 * DPH, "rate_random_walk": 0.3 * DPH}
    models = [identified(seed, **truth) for seed in range(40)]
    for value, name in (
        (ARW, "angle_random_walk"),
        (8 * DPH, "bias_instability_coefficient"),
        (0.3 * DPH, "rate_random_walk"),
    ):
        terms = [getattr(one, name) for one in models]
        assert sum(one.lower_95 <= value <= one.upper_95 for one in terms) >= 35, name
        assert sum(one.lower_68 <= value <= one.upper_68 for one in terms) >= 19, name


def test_quantization_noise_is_told_from_white_noise() -> None:
    random = np.random.default_rng(3)
    rate = np.diff(random.standard_normal(36_001)) + 0.5 * random.standard_normal(36_000)
    model = identify_noise(rate, sample_rate_hz=1.0)
    found = model.quantization_noise
    assert found.resolved
    assert found.lower_95 < 1.0 < found.upper_95
    assert model.angle_random_walk.lower_95 < 0.5 < model.angle_random_walk.upper_95


@pytest.mark.parametrize("frequency_hz", [0.2, 0.137, 0.05])
def test_a_line_is_kept_out_of_angle_random_walk_and_quantization_noise(frequency_hz: float) -> None:
    plain = gyro_noise(20_000, angle_random_walk=1.0, bias_instability=0.1, seed=6)
    line = 1.5 * np.sin(2.0 * np.pi * frequency_hz * np.arange(20_000.0))
    model = honest(identify_noise(plain + line, sample_rate_hz=1.0))
    assert [one.frequency_hz for one in model.lines] == pytest.approx([frequency_hz], abs=0.002)
    assert model.lines[0].amplitude_dps == pytest.approx(1.5, rel=0.1)
    walk = model.angle_random_walk
    assert walk.lower_95 < 1.0 < walk.upper_95
    assert walk.value == pytest.approx(1.0, rel=0.1)
    assert model.quantization_noise.upper_95 < 0.5


def test_a_wide_resonance_is_kept_out_of_the_angle_random_walk() -> None:
    random = np.random.default_rng(8)
    pole = 0.99 * np.exp(2j * np.pi * 0.2)
    ringing = lfilter([0.06], [1.0, -2.0 * pole.real, abs(pole) ** 2], random.standard_normal(100_000))
    model = honest(identify_noise(random.standard_normal(100_000) + ringing, sample_rate_hz=1.0))
    assert model.lines
    assert model.angle_random_walk.value == pytest.approx(1.0, rel=0.04)
    assert model.quantization_noise.upper_95 < 0.3


@pytest.mark.parametrize("order", [1, 2])
def test_intervals_hold_the_angle_random_walk_of_a_filtered_record(order: int) -> None:
    numerator, denominator = butter(order, 0.15)
    found, held = [], 0
    for seed in range(12):
        white = gyro_noise(14_900, angle_random_walk=1.0, bias_instability=0.1, seed=seed)
        model = honest(identify_noise(lfilter(numerator, denominator, white)[500:], sample_rate_hz=1.0))
        assert model.first_tau_s > 3.0
        walk = model.angle_random_walk
        found.append(walk.value)
        held += walk.lower_95 <= 1.0 <= walk.upper_95
        assert not model.quantization_noise.resolved
    # At the shortest time a filter of the first order leaves 0.2, one of the second order 0.1.
    assert np.mean(found) == pytest.approx(1.0, rel=0.12)
    assert held >= 10


def test_a_filter_of_20_s_that_reaches_the_slow_modes_is_kept_out_as_well() -> None:
    decay = np.exp(-1.0 / 20.0)
    found, held = [], 0
    for seed in range(10):
        white = np.random.default_rng(seed).standard_normal(14_900)
        rate = lfilter([1.0 - decay], [1.0, -decay], white)[500:]
        model = honest(identify_noise(rate, sample_rate_hz=1.0))
        assert model.first_tau_s > 20.0
        walk = model.angle_random_walk
        found.append(walk.value)
        held += walk.lower_95 <= 1.0 <= walk.upper_95
    # At the shortest time the filter leaves 0.16.
    assert np.mean(found) == pytest.approx(1.0, rel=0.25)
    assert held >= 7


@pytest.mark.parametrize(
    ("rate", "message"),
    [
        (np.full(100, 2.5), "all 100 samples are 2.5: a constant carries no noise"),
        (np.where(np.arange(100) == 7, np.nan, 1.0 * np.arange(100)), "sample 7 is nan"),
        (np.where(np.arange(100) == 9, -np.inf, 1.0 * np.arange(100)), "sample 9 is -inf"),
        (np.arange(3600.0), "no noise model describes the record"),
        (0.1 * np.arange(1000.0), "no noise model describes the record"),
        (1.0 * (np.arange(10_007) == 10_006), "no noise model describes the record"),
    ],
)
def test_a_record_that_carries_no_noise_is_refused(rate: np.ndarray, message: str) -> None:
    with pytest.raises(InsufficientDataError, match=message):
        identify_noise(rate, sample_rate_hz=1.0)


def test_a_record_of_several_axes_is_refused() -> None:
    with pytest.raises(ValueError, match="a rate record has one dimension, found 2"):
        identify_noise(np.zeros((3, 100)), sample_rate_hz=1.0)


@pytest.mark.parametrize("sample_rate_hz", [0.0, -1.0, np.nan, np.inf])
def test_a_sample_rate_that_is_none_is_refused(sample_rate_hz: float) -> None:
    with pytest.raises(ValueError, match="a sample rate is a positive, finite number of Hz"):
        identify_noise(gyro_noise(100, angle_random_walk=1.0), sample_rate_hz=sample_rate_hz)


@pytest.mark.parametrize("duty", [0.0, -0.5, 1.5, np.nan, np.inf])
def test_a_duty_that_is_none_is_refused(duty: float) -> None:
    with pytest.raises(ValueError, match="a duty is above 0 and at most 1"):
        identify_noise(gyro_noise(100, angle_random_walk=1.0), sample_rate_hz=1.0, duty=duty)


@pytest.mark.parametrize("kind", ["laplace", "student"])
def test_heavy_tails_are_in_the_interval_of_the_angle_random_walk(kind: str) -> None:
    held = 0
    for seed in range(60):
        random = np.random.default_rng(seed)
        white = random.laplace(size=7200) if kind == "laplace" else random.standard_t(4, size=7200)
        rate = white / np.sqrt(2.0) + gyro_noise(7200, bias_instability=0.05, seed=1000 + seed)
        walk = identify_noise(rate, sample_rate_hz=1.0).angle_random_walk
        held += walk.lower_95 <= 1.0 <= walk.upper_95
    assert held >= 50


def test_bad_samples_are_refused_with_a_curve_at_hand_too() -> None:
    rate = gyro_noise(3600, angle_random_walk=1.0)
    curve = overlapping_allan_deviation(rate, sample_rate_hz=1.0)
    hidden = np.ma.masked_array(rate, mask=np.arange(3600) == 7)
    broken = rate.copy()
    broken[7] = np.nan
    with pytest.raises(InsufficientDataError, match="1 of 3600 samples are masked"):
        identify_noise(hidden, sample_rate_hz=1.0, deviation=curve)
    with pytest.raises(InsufficientDataError, match="sample 7 is nan"):
        identify_noise(broken, sample_rate_hz=1.0, deviation=curve)


def test_the_fourth_cumulant_is_that_of_the_samples() -> None:
    random = np.random.default_rng(4)
    assert fourth_cumulant(random.laplace(size=400_000)) == pytest.approx(12.0, rel=0.1)
    assert fourth_cumulant(random.random(400_000)) == pytest.approx(-1.0 / 120.0, rel=0.05)
    assert abs(fourth_cumulant(random.standard_normal(400_000))) < 0.05


def test_white_noise_alone_is_held_by_its_interval() -> None:
    models = [identified(seed, samples=7200, angle_random_walk=1.0) for seed in range(80)]
    held = [one.angle_random_walk.lower_95 <= 1.0 <= one.angle_random_walk.upper_95 for one in models]
    assert sum(held) >= 72
