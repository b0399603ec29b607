"""Dead time, the Earth's rate, intervals, continuity."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.signal import lfilter

from gyrotest.analysis.continuity import (
    Stretch,
    stretches_by_index,
    stretches_by_time,
    stuck_stretch,
)
from gyrotest.analysis.dead_time import _inflation, dead_time_correction
from gyrotest.analysis.earth import EARTH_RATE_DPS, earth_share_dps
from gyrotest.analysis.interval import chi_square_quantile, coverage_factor, deviation_bounds
from gyrotest.analysis.resolution import digital_step, mean_half_width


def test_dead_time_is_corrected_only_for_a_wide_enough_bandwidth() -> None:
    wide = dead_time_correction(reading_s=0.1, spacing_s=0.2, bandwidth_hz=50.0)
    assert wide is not None
    held_back = (1.0 - math.exp(-10.0 * math.pi)) / (10.0 * math.pi)
    assert wide.factor == pytest.approx(math.sqrt(0.5) / math.sqrt(1.0 - held_back))
    assert wide.half_width == pytest.approx(1.0 - math.sqrt(1.0 - held_back))
    for bandwidth in (None, 5.0):
        assert dead_time_correction(reading_s=0.1, spacing_s=0.2, bandwidth_hz=bandwidth) is None


def test_the_correction_goes_to_nothing_with_the_dead_time() -> None:
    gaps = (0.5, 0.1, 0.01, 1e-4, 0.0)
    found = [dead_time_correction(reading_s=1.0 - gap, spacing_s=1.0, bandwidth_hz=5.0) for gap in gaps]
    factors = [1.0 if one is None else one.factor for one in found]
    assert factors == sorted(factors)
    assert factors[3] == pytest.approx(1.0, abs=1e-6)
    unknown = dead_time_correction(reading_s=0.99, spacing_s=1.0, bandwidth_hz=None)
    assert unknown is not None
    assert unknown.factor * (1.0 - unknown.half_width) == pytest.approx(math.sqrt(0.99))
    assert unknown.factor * (1.0 + unknown.half_width) == pytest.approx(1.0)


def test_the_correction_is_that_of_simulated_first_order_noise() -> None:
    """Readings of 8 ms every 10 ms of noise with a time constant of 3 ms, in steps of 1 ms."""
    random = np.random.default_rng(1)
    white = random.standard_normal(10_000_000)
    decay = math.exp(-1.0 / 3.0)
    filtered = lfilter([1.0 - decay], [1.0, -decay], white).reshape(-1, 10)[:, :8].mean(axis=1)
    apparent = np.std(filtered.reshape(-1, 200).mean(axis=1)) * math.sqrt(2000.0)
    found = dead_time_correction(reading_s=0.008, spacing_s=0.01, bandwidth_hz=1000.0 / (6.0 * math.pi))
    assert found is None  # 53 Hz is less than 1/(2 · 8 ms): not allowed, whatever the formula gives
    exact = math.sqrt(_inflation(0.008, 0.01, 0.003))
    assert apparent == pytest.approx(exact, rel=0.02)


def test_without_dead_time_nothing_is_corrected_whatever_the_bandwidth() -> None:
    whole = dead_time_correction(reading_s=1.0, spacing_s=1.0, bandwidth_hz=None)
    assert whole is not None
    assert (whole.factor, whole.half_width) == (1.0, 0.0)


def test_the_earth_turns_a_vertical_axis_by_the_sine_of_latitude() -> None:
    share = earth_share_dps((1.0, 0.0, 0.0), latitude_deg=30.0, heading_deg=None)
    assert share == pytest.approx(EARTH_RATE_DPS / 2.0)
    down = earth_share_dps((-3.0, 0.0, 0.0), latitude_deg=30.0, heading_deg=None)
    assert down == pytest.approx(-EARTH_RATE_DPS / 2.0)


@pytest.mark.parametrize(
    ("axis", "heading", "cosine"),
    [
        ((0.0, 1.0, 0.0), 0.0, 1.0),
        ((0.0, 1.0, 0.0), 90.0, 0.0),
        ((0.0, 0.0, 1.0), 90.0, -1.0),
        ((0.0, 1.0, 0.0), 60.0, 0.5),
    ],
)
def test_a_horizontal_axis_needs_the_benchs_heading(
    axis: tuple[float, float, float], heading: float, cosine: float
) -> None:
    share = earth_share_dps(axis, latitude_deg=60.0, heading_deg=heading)
    assert share == pytest.approx(EARTH_RATE_DPS * 0.5 * cosine, abs=1e-12)
    assert earth_share_dps(axis, latitude_deg=60.0, heading_deg=None) is None


def test_an_unknown_mounting_or_site_gives_no_share() -> None:
    assert earth_share_dps(None, latitude_deg=48.0, heading_deg=0.0) is None
    assert earth_share_dps((1.0, 0.0, 0.0), latitude_deg=None, heading_deg=0.0) is None
    assert earth_share_dps((0.0, 0.0, 0.0), latitude_deg=48.0, heading_deg=0.0) is None


def test_three_values_leave_a_deviation_uncertain_by_half_to_six_times() -> None:
    bounds = deviation_bounds(1.0, 2.0, confidence=0.95)
    assert (round(float(bounds.lower), 2), round(float(bounds.upper), 2)) == (0.52, 6.28)


@given(st.floats(1.0, 1e6), st.floats(0.6, 0.99))
def test_bounds_lie_on_both_sides_of_the_deviation(freedom: float, confidence: float) -> None:
    lower = deviation_bounds(1.0, freedom, confidence=confidence).lower
    upper = deviation_bounds(1.0, freedom, confidence=confidence).upper
    assert lower < 1.0 < upper


def test_coverage_factors_are_those_of_the_gum() -> None:
    assert coverage_factor(math.inf) == pytest.approx(2.0, abs=1e-3)
    assert coverage_factor(10.0) == pytest.approx(2.28, abs=0.005)
    assert coverage_factor(3.0) == pytest.approx(3.31, abs=0.005)
    assert chi_square_quantile(0.95, 1.0) == pytest.approx(3.841, abs=1e-3)


def test_stretches_end_where_the_index_jumps() -> None:
    assert stretches_by_index(np.arange(5, 10)) == (Stretch(start=0, stop=5),)
    assert stretches_by_index(np.array([0, 1, 2, 7, 8])) == (
        Stretch(start=0, stop=3),
        Stretch(start=3, stop=5),
    )


def test_stretches_end_where_time_stamps_are_off_by_half_an_interval() -> None:
    time_s = np.arange(100_000) * 0.01
    time_s[70_000:] += 22.0
    time_s[40_000] += 0.004
    found = stretches_by_time(time_s, interval_s=0.01)
    assert found == (Stretch(start=0, stop=70_000), Stretch(start=70_000, stop=100_000))


def test_a_repeated_value_in_fine_noise_is_stuck() -> None:
    values = np.random.default_rng(1).standard_normal(100_000)
    assert stuck_stretch(values) is None
    values[65_530:65_545] = values[65_530]
    assert stuck_stretch(values) == Stretch(start=65_530, stop=65_545)
    values[99_900:] = 0.5
    assert stuck_stretch(values) == Stretch(start=99_900, stop=100_000)


def test_coarse_counts_repeat_themselves_without_being_stuck() -> None:
    counts = np.rint(np.random.default_rng(1).standard_normal(100_000) * 0.5)
    assert stuck_stretch(counts) is None
    counts[500:800] = 0.0
    assert stuck_stretch(counts) is not None


def test_counts_show_their_step_and_fine_readings_none() -> None:
    noise = np.random.default_rng(1).standard_normal(100_000)
    assert digital_step(0.05 * np.rint(5.0 * noise)) == pytest.approx(0.05)
    assert digital_step(noise) is None
    assert digital_step(np.full(100, 2.5)) is None


@pytest.mark.parametrize("deviation", [0.0, 0.05, 0.1, 0.2, 0.3, 0.4, 0.5, 1.0])
def test_no_mean_is_further_off_than_the_half_width_of_its_steps(deviation: float) -> None:
    noise = deviation * np.random.default_rng(1).standard_normal(200_000)
    for offset in np.linspace(0.0, 1.0, 21):
        record = np.rint(offset + noise)
        error = abs(float(np.mean(record - offset)))
        by_chance = 4.0 * (deviation + 0.5 * (deviation > 0.0)) / math.sqrt(noise.size)
        assert error <= mean_half_width(1.0, float(record.std(ddof=1))) + by_chance
    dithered = np.rint(0.3 + noise).std(ddof=1)
    assert (mean_half_width(1.0, float(dithered)) < 0.02) == (deviation >= 0.4)
