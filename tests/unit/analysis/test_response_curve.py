"""The fitted curve: honest at every frequency, and what is read off it."""

from dataclasses import replace

import numpy as np
import pytest

from gyrotest.analysis.cross_spectra import Spectra, pooled
from gyrotest.analysis.frequency_response import Response, hv
from gyrotest.analysis.noise_ratio import known_ratio
from gyrotest.analysis.response_curve import (
    Reading,
    ResponseCurve,
    bandwidth,
    fit_response,
    flatness,
    group_delay,
    quarter_turn,
)
from gyrotest.errors import InsufficientDataError
from tests.unit.analysis.vibration import HIGH_HZ, LOW_HZ, Truth, Vibration

TRUTH = Truth(gain=0.05, natural_hz=80.0, damping=0.65, delay_s=4e-4)
VIBRATION = Vibration(truth=TRUTH)
PLACES = np.array([5.0, 50.0, 100.0])
REFERENCE_HZ = 10.0
UNITS = 100


def response(seed: int, *, duration_s: float = 30.0, vibration: Vibration = VIBRATION) -> Response:
    """Three runs, averaged."""
    runs = [vibration.spectra((seed, run), duration_s=duration_s) for run in range(3)]
    return hv(pooled(runs), known_ratio(vibration.ratio))


def exact(truth: Truth, *, averages: float = 300.0, noise: float = 1e-6) -> Response:
    """A response without any scatter, from spectra that have none."""
    lines = np.arange(20, 401) / 4.0
    found = truth.response(lines)
    spectra = Spectra(
        frequency_hz=lines,
        reference=np.full(lines.size, 1.0 + noise),
        output=np.abs(found) ** 2,
        cross=found,
        segments=int(averages),
        averages=averages,
        segment_s=4.0,
        correlation=np.array([1.0]),
    )
    return hv(spectra, known_ratio(0.0))


def fit(given: Response, *, degree: int = 8, coherence_floor: float = 0.5) -> ResponseCurve:
    return fit_response(given, degree=degree, coherence_floor=coherence_floor)


@pytest.fixture(scope="module")
def curves() -> list[ResponseCurve]:
    return [fit(response(seed)) for seed in range(UNITS)]


@pytest.fixture(scope="module")
def exact_curve() -> ResponseCurve:
    return fit(exact(TRUTH), degree=10)


def true_crossing(values: np.ndarray, level: float, grid: np.ndarray) -> float:
    return float(grid[np.flatnonzero(values <= level)[0]])


def true_bandwidth() -> float:
    grid = np.linspace(LOW_HZ, 200.0, 400_001)
    level = abs(TRUTH.response(np.array([REFERENCE_HZ]))[0]) / np.sqrt(2.0)
    return true_crossing(np.abs(TRUTH.response(grid)), level, grid)


def honest(z: np.ndarray) -> None:
    assert np.all(np.abs(z.mean(axis=0)) <= 0.3)
    assert np.all((z.std(axis=0, ddof=1) >= 0.8) & (z.std(axis=0, ddof=1) <= 1.25))


def readings(found: list[Reading | None], truth: float) -> np.ndarray:
    assert None not in found
    return np.array([(one.value - truth) / one.uncertainty for one in found if one is not None])


def test_the_gain_is_honest_over_many_units(curves: list[ResponseCurve]) -> None:
    points = [one.at(PLACES) for one in curves]
    expected = np.abs(TRUTH.response(PLACES))
    honest(np.array([(one.gain - expected) / one.gain_uncertainty for one in points]))


def test_the_phase_is_honest_over_many_units(curves: list[ResponseCurve]) -> None:
    points = [one.at(PLACES) for one in curves]
    expected = TRUTH.phase_deg(PLACES)
    honest(np.array([(one.phase_deg - expected) / one.phase_uncertainty_deg for one in points]))


def test_the_bandwidth_is_honest_over_many_units(curves: list[ResponseCurve]) -> None:
    found = [bandwidth(one, reference_hz=REFERENCE_HZ) for one in curves]
    honest(readings(found, true_bandwidth()))


def test_the_quarter_turn_is_honest_over_many_units(curves: list[ResponseCurve]) -> None:
    grid = np.linspace(LOW_HZ, HIGH_HZ, 200_001)
    expected = true_crossing(TRUTH.phase_deg(grid), -90.0, grid)
    honest(readings([quarter_turn(one) for one in curves], expected))


def test_the_group_delay_is_honest_over_many_units(curves: list[ResponseCurve]) -> None:
    beside = TRUTH.phase_deg(np.array([39.9, 40.1]))
    expected = float(beside[0] - beside[1]) / 0.2 / 360.0
    honest(readings([group_delay(one, frequency_hz=40.0) for one in curves], expected))


def noisy(seed: int, *, coherence: float, on_output: float, averages: int = 27) -> Spectra:
    """Spectra of few averages of a gain of 1: lines of noise, `on_output` of its power on the output."""
    source, lines = np.random.default_rng(seed), np.arange(20, 401)

    def power(square: float) -> np.ndarray:
        parts = source.normal(size=(2, averages, lines.size))
        return np.sqrt(square / 2.0) * (parts[0] + 1j * parts[1])

    lost = 1.0 / coherence - 1.0
    moved = power(1.0)
    reference, output = moved + power(lost * (1.0 - on_output)), moved + power(lost * on_output)
    return Spectra(
        frequency_hz=lines / 4.0,
        reference=np.mean(np.abs(reference) ** 2, axis=0),
        output=np.mean(np.abs(output) ** 2, axis=0),
        cross=np.mean(output * reference.conj(), axis=0),
        segments=averages,
        averages=float(averages),
        segment_s=4.0,
        correlation=np.array([1.0]),
    )


@pytest.mark.parametrize(("on_output", "ratio"), [(1.0, np.inf), (0.5, 1.0), (0.0, 0.0)])
def test_few_averages_of_little_coherence_do_not_draw_the_curve_to_one_side(
    on_output: float, ratio: float
) -> None:
    """By weights from each line's own coherence it was wrong by 2ε², 0.65 % here."""
    gains = [
        fit(hv(noisy(seed, coherence=0.85, on_output=on_output), known_ratio(ratio)), degree=3)
        .log_gain.value(PLACES)
        .mean()
        for seed in range(80)
    ]
    assert np.mean(gains) == pytest.approx(0.0, abs=0.0015)


def test_misfits_are_one_where_the_degree_suffices(curves: list[ResponseCurve]) -> None:
    for polynomials in ([one.log_gain for one in curves], [one.phase for one in curves]):
        assert np.mean([one.misfit for one in polynomials]) == pytest.approx(1.0, abs=0.03)
        assert sum(one.lacking for one in polynomials) <= 2


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_three_runs_of_ten_minutes_give_the_truth_within_two_tenths(seed: int) -> None:
    truth = Truth(delay_s=4e-4)
    vibration = Vibration(truth=truth, reference=0.005, output=0.005)
    assert vibration.coherence == pytest.approx(0.99, abs=1e-3)
    found = fit(response(seed, duration_s=600.0, vibration=vibration), degree=5)
    points = found.at(np.linspace(5.0, 100.0, 96))
    expected = np.abs(truth.response(points.frequency_hz))
    assert np.abs(points.gain / expected - 1.0).max() < 0.002
    assert np.abs(points.phase_deg - truth.phase_deg(points.frequency_hz)).max() < 0.2
    assert (points.gain_uncertainty / points.gain).max() < 1.2e-3


def test_readings_off_an_exact_curve_are_exact(exact_curve: ResponseCurve) -> None:
    found = bandwidth(exact_curve, reference_hz=REFERENCE_HZ)
    assert found is not None
    assert found.value == pytest.approx(true_bandwidth(), rel=1e-3)
    grid = np.abs(TRUTH.response(np.linspace(LOW_HZ, HIGH_HZ, 10_001)))
    at_reference = abs(TRUTH.response(np.array([REFERENCE_HZ]))[0])
    expected = 100.0 * (grid.max() - grid.min()) / at_reference
    assert flatness(exact_curve, reference_hz=REFERENCE_HZ).value == pytest.approx(expected, rel=1e-3)


def test_the_flatness_up_to_a_frequency(exact_curve: ResponseCurve) -> None:
    found = flatness(exact_curve, reference_hz=20.0, to_hz=30.0)
    grid = np.abs(TRUTH.response(np.linspace(LOW_HZ, 30.0, 10_001)))
    expected = 100.0 * np.ptp(grid) / abs(TRUTH.response(np.array([20.0]))[0])
    assert found.value == pytest.approx(expected, rel=1e-3)
    with pytest.raises(InsufficientDataError, match="120 Hz lies outside"):
        flatness(exact_curve, reference_hz=20.0, to_hz=120.0)


def test_a_pure_delay_is_the_group_delay() -> None:
    found = fit(exact(Truth(natural_hz=1e9, damping=0.0, delay_s=2.5e-3)), degree=3)
    assert group_delay(found, frequency_hz=33.0).value == pytest.approx(2.5e-3, rel=1e-9)
    quarter = quarter_turn(found)
    assert quarter is not None
    assert (quarter.value, quarter.uncertainty) == (pytest.approx(100.0), pytest.approx(0.0, abs=0.1))
    # °: 0.9° a hertz
    assert (quarter.at_hz, quarter.factors) == (pytest.approx((100.0,)), pytest.approx((1.0 / 0.9,)))


def test_the_flatness_of_a_flat_gyro_is_its_noise() -> None:
    flat = Vibration(truth=Truth(natural_hz=1e9, damping=0.0))
    found = [
        flatness(fit(response(seed, vibration=flat), degree=2), reference_hz=20.0) for seed in range(30)
    ]
    assert all(0.0 < one.value < 8.0 * one.uncertainty for one in found)


def test_points_beyond_the_band_are_none_and_never_extrapolated() -> None:
    found = fit(exact(Truth(natural_hz=200.0)), degree=8)
    assert bandwidth(found, reference_hz=REFERENCE_HZ) is None
    assert quarter_turn(found) is None
    for frequency_hz in (4.0, 101.0, 130.0):
        with pytest.raises(InsufficientDataError, match=r"Hz lies outside of .* 5 … 100 Hz"):
            found.at(np.array([50.0, frequency_hz]))
    with pytest.raises(InsufficientDataError, match="3 Hz lies outside"):
        bandwidth(found, reference_hz=3.0)


def test_a_phase_that_begins_below_a_quarter_turn_is_refused() -> None:
    inverted = replace(exact(TRUTH), phase_deg=exact(TRUTH).phase_deg - 100.0)
    with pytest.raises(InsufficientDataError, match=r"-10.\.\d° where the band begins \(5 Hz\)"):
        quarter_turn(fit(inverted))


def test_a_phase_of_many_turns_is_unwrapped() -> None:
    long = Truth(natural_hz=1e9, damping=0.0, delay_s=0.03)
    given = exact(long)
    assert np.ptp(given.phase_deg) < 360.0
    points = fit(given, degree=3).at(PLACES)
    np.testing.assert_allclose(points.phase_deg, -360.0 * PLACES * 0.03, rtol=1e-9)


def test_lines_of_too_little_coherence_are_left_out_and_listed() -> None:
    given = exact(TRUTH)
    hum = (given.frequency_hz >= 49.0) & (given.frequency_hz <= 51.0)
    spoilt = replace(
        given,
        gain=np.where(hum, 7.0, given.gain),
        phase_deg=np.where(hum, 77.0, given.phase_deg),
        coherence=np.where(hum, 0.4, given.coherence),
    )
    found, clean = fit(spoilt, degree=10), fit(given, degree=10)
    np.testing.assert_array_equal(found.excluded_hz, given.frequency_hz[hum])
    np.testing.assert_allclose(found.at(PLACES).gain, clean.at(PLACES).gain, rtol=1e-4)
    assert clean.excluded_hz.size == 0


def test_a_band_whose_ends_lack_coherence_is_a_shorter_band() -> None:
    given = exact(TRUTH)
    quiet = given.frequency_hz < 8.0
    found = fit(replace(given, coherence=np.where(quiet, 0.1, given.coherence)))
    assert (found.low_hz, found.high_hz) == (8.0, 100.0)
    with pytest.raises(InsufficientDataError, match=r"5 Hz lies outside of .* 8 … 100 Hz"):
        found.at(np.array([5.0]))


def test_too_little_coherence_over_the_whole_band_is_refused() -> None:
    given = response(1, vibration=Vibration(truth=TRUTH, reference=1.0, output=1.0))
    with pytest.raises(
        InsufficientDataError,
        match=r"coherence is below 0\.9 over the whole band; .* is 0\.\d+ at best, at",
    ):
        fit(given, coherence_floor=0.9)


def test_lines_that_are_all_but_noise_are_left_out_whatever_the_floor() -> None:
    given = response(1)
    spoilt = given.frequency_hz < 20.0
    turned = np.random.default_rng(1).uniform(-180.0, 180.0, spoilt.size)
    found = fit(
        replace(
            given,
            phase_deg=np.where(spoilt, turned, given.phase_deg),
            error=np.where(spoilt, 0.5, given.error),
        ),
        coherence_floor=0.0,
    )
    assert found.low_hz == 20.0
    np.testing.assert_allclose(found.at(PLACES[1:]).phase_deg, TRUTH.phase_deg(PLACES[1:]), atol=2.0)
    with pytest.raises(InsufficientDataError, match="random error is above 30 %"):
        fit(replace(given, error=np.full(spoilt.size, 0.5)), coherence_floor=0.0)


def test_too_few_coherent_lines_for_the_degree_are_refused() -> None:
    given = exact(TRUTH)
    few = np.where(given.frequency_hz < 7.0, given.coherence, 0.0)
    with pytest.raises(
        InsufficientDataError, match="8 lines in the band; a polynomial of degree 8 needs 13"
    ):
        fit(replace(given, coherence=few))


def test_a_degree_that_is_too_low_is_said_and_stays_honest() -> None:
    sharp = Vibration(truth=Truth(natural_hz=60.0, damping=0.25))
    found = fit(response(2, duration_s=120.0, vibration=sharp), degree=4)
    assert found.log_gain.lacking
    points = found.at(np.linspace(5.0, 100.0, 200))
    z = (points.gain - np.abs(sharp.truth.response(points.frequency_hz))) / points.gain_uncertainty
    assert np.sqrt(np.mean(z**2)) < 2.0
    assert found.log_gain.lack_rms > 0.02


def test_degrees_of_gain_and_phase_may_differ() -> None:
    found = fit_response(exact(TRUTH), degree=7, coherence_floor=0.5, phase_degree=9)
    assert (found.log_gain.coefficients.size, found.phase.coefficients.size) == (8, 10)
