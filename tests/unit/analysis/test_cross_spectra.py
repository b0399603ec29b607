"""Spectra block by block: what does not depend on how the samples come, what no segment bridges, the signs."""

from dataclasses import replace

import numpy as np
import pytest

from gyrotest.analysis.cross_spectra import CrossSpectra, Spectra, default_segment, pooled
from gyrotest.analysis.taper import taper
from gyrotest.errors import InsufficientDataError

RATE_HZ = 1000.0
SEGMENT = 1000


def make(**options: object) -> CrossSpectra:
    given = {"rate_hz": RATE_HZ, "low_hz": 20.0, "high_hz": 100.0, "segment": SEGMENT} | options
    return CrossSpectra(**given)  # type: ignore[arg-type]


def record(samples: int, seed: int = 1) -> tuple[np.ndarray, np.ndarray]:
    random = np.random.default_rng(seed)
    return np.cumsum(random.normal(size=samples)) / RATE_HZ, random.normal(size=samples)


def of(angle: np.ndarray, output: np.ndarray, **options: object) -> Spectra:
    made = make(**options)
    made.push(angle, output)
    return made.spectra()


def same(one: Spectra, other: Spectra, rtol: float = 1e-11) -> None:
    for name in ("frequency_hz", "reference", "output", "cross", "correlation"):
        np.testing.assert_allclose(getattr(one, name), getattr(other, name), rtol=rtol)
    assert (one.segments, one.averages) == (other.segments, pytest.approx(other.averages))


def test_blocks_of_any_size_give_what_one_block_gives() -> None:
    angle, output = record(12_345)
    made = make()
    for part in np.split(np.arange(angle.size), [0, 1, 999, 1000, 1001, 5000, 5000, 11_000]):
        made.push(angle[part], output[part])
    same(made.spectra(), of(angle, output))


def test_spectra_in_between_change_nothing() -> None:
    angle, output = record(7000)
    made = make()
    made.push(angle[:2600], output[:2600])
    assert made.spectra().segments == 4
    made.push(angle[2600:], output[2600:])
    same(made.spectra(), of(angle, output))


def test_no_segment_bridges_a_gap() -> None:
    angle, output = record(5300)
    made = make()
    made.push(angle[:2700], output[:2700])
    made.begin_stretch()
    made.push(angle[2700:] + 500.0, output[2700:] - 80.0)
    parts = [of(angle[:2700], output[:2700]), of(angle[2700:], output[2700:])]
    same(made.spectra(), pooled(parts), rtol=1e-8)
    assert made.segments == 4 + 4


def test_two_gaps_at_once_are_one() -> None:
    angle, output = record(3000)
    made = make()
    made.begin_stretch()
    made.push(angle, output)
    made.begin_stretch()
    made.begin_stretch()
    same(made.spectra(), of(angle, output))


def test_a_lag_has_a_negative_phase() -> None:
    samples, late = 40_000, 3
    angle, _ = record(samples)
    rate = np.gradient(angle) * RATE_HZ
    found = of(angle[late:], rate[:-late])
    expected = -360.0 * found.frequency_hz * late / RATE_HZ
    error_deg = np.degrees(np.angle(found.cross)) - expected
    assert np.abs(error_deg).max() < 0.3  # 3 ms of each second have no counterpart
    assert abs(error_deg.mean()) < 0.03


@pytest.mark.parametrize("window", ["hann", "blackman", "nuttall"])
def test_an_angle_whose_rate_is_white_gives_a_white_rate(window: str) -> None:
    random = np.random.default_rng(3)
    samples = 400_000
    lines = np.fft.rfftfreq(samples, 1.0 / RATE_HZ)
    rate = np.fft.rfft(random.normal(size=samples)) * (lines > 1.0)
    angle = np.fft.irfft(np.divide(rate, 2j * np.pi * lines, out=np.zeros_like(rate), where=lines > 0))
    found = of(angle, np.fft.irfft(rate), low_hz=5.0, window=window)
    np.testing.assert_allclose(found.reference[10:], found.output[10:], rtol=2e-4)
    # five periods a segment: multiplied after the taper this were wrong by 4 %
    assert found.reference[0] / found.output[0] == pytest.approx(1.0, abs=1e-3)


def test_a_large_slow_swing_does_not_leak_into_the_band() -> None:
    angle, output = record(30_000)
    swing = 300.0 + 2.0 * np.sin(2.0 * np.pi * 0.05 * np.arange(angle.size) / RATE_HZ)
    plain, swung = of(angle, output), of(angle + swing, output)
    np.testing.assert_allclose(swung.reference, plain.reference, rtol=1e-3)


@pytest.mark.parametrize(("segments", "expected"), [(1, 1.0), (2, 2 / (1 + 1 / 36)), (99, 93.8416)])
def test_overlapping_segments_are_worth_fewer(segments: int, expected: float) -> None:
    samples = SEGMENT + (segments - 1) * SEGMENT // 2
    found = of(*record(samples))
    assert found.segments == segments
    assert found.averages == pytest.approx(expected, rel=1e-4)


@pytest.mark.parametrize("window", ["hann", "blackman"])
def test_averages_scatter_as_their_number_says(window: str) -> None:
    found = [of(*record(8000, seed), window=window) for seed in range(120)]
    powers = np.array([one.output for one in found])
    relative = powers.std(axis=0, ddof=1) / powers.mean(axis=0)
    assert np.mean(relative**2) * found[0].averages == pytest.approx(1.0, abs=0.06)


@pytest.mark.parametrize("window", ["hann", "blackman", "nuttall"])
def test_neighbouring_lines_are_as_correlated_as_is_said(window: str) -> None:
    found = [of(*record(6000, seed), window=window) for seed in range(150)]
    powers = np.array([one.output for one in found])
    powers = powers / powers.mean(axis=0) - 1.0
    for apart in (1, 2, 3, 4):
        seen = np.mean(powers[:, apart:] * powers[:, :-apart]) / np.mean(powers**2)
        assert seen == pytest.approx(found[0].correlation[apart], abs=0.03)


def test_hann_has_its_published_overlap_and_neighbours() -> None:
    hann = taper("hann", 4000)
    assert hann.next[0] == pytest.approx(1 / 36)
    np.testing.assert_allclose(hann.same[:4], [1.0, 4 / 9, 1 / 36, 0.0], atol=1e-12)
    assert hann.power == pytest.approx(3 / 8)


def test_runs_are_averaged_by_their_segments() -> None:
    short, long = of(*record(2000, 1)), of(*record(9000, 2))
    found = pooled([short, long])
    assert found.segments == short.segments + long.segments
    assert found.averages == pytest.approx(short.averages + long.averages, rel=0.01)
    shares = np.array([short.segments, long.segments]) / found.segments
    np.testing.assert_allclose(found.cross, shares[0] * short.cross + shares[1] * long.cross)


def test_runs_of_other_lines_are_not_averaged() -> None:
    one = of(*record(3000))
    with pytest.raises(ValueError, match="one and the same"):
        pooled([one, replace(one, segment_s=2.0)])
    with pytest.raises(ValueError, match="no run"):
        pooled([])


def test_a_record_shorter_than_a_segment_is_refused() -> None:
    made = make()
    for _ in range(3):
        made.push(*record(SEGMENT - 1))
        made.begin_stretch()
    with pytest.raises(InsufficientDataError, match=r"segment of 1 s \(1000 samples\).*record longer"):
        made.spectra()


def test_what_is_not_a_number_is_refused() -> None:
    angle, output = record(100)
    output[50] = np.nan
    with pytest.raises(InsufficientDataError, match="begin a new stretch"):
        make().push(angle, output)


def test_signals_of_different_lengths_are_refused() -> None:
    with pytest.raises(ValueError, match="not sampled together"):
        make().push(np.zeros(10), np.zeros(11))


@pytest.mark.parametrize(("low_hz", "high_hz"), [(0.5, 100.0), (20.0, 499.5), (100.0, 20.0)])
def test_a_band_beyond_the_lines_is_refused(low_hz: float, high_hz: float) -> None:
    with pytest.raises(ValueError, match="lines 2 … 498 Hz"):
        make(low_hz=low_hz, high_hz=high_hz)


def test_an_unknown_window_and_a_segment_too_short_are_refused() -> None:
    with pytest.raises(ValueError, match="one of hann, blackman, nuttall, found 'boxcar'"):
        make(window="boxcar")
    with pytest.raises(ValueError, match="at least 8 samples, found 4"):
        make(segment=4)


@pytest.mark.parametrize(("rate_hz", "low_hz"), [(10_000.0, 5.0), (125.0, 0.7), (1613.0, 3.3)])
def test_a_default_segment_holds_twenty_periods(rate_hz: float, low_hz: float) -> None:
    segment = default_segment(rate_hz=rate_hz, low_hz=low_hz)
    assert segment % 2 == 0
    assert 20.0 <= segment / rate_hz * low_hz <= 23.0


def test_the_band_holds_both_its_ends() -> None:
    found = CrossSpectra(rate_hz=10_000.0, low_hz=5.0, high_hz=100.0)
    found.push(*record(40_000))
    frequency_hz = found.spectra().frequency_hz
    assert (frequency_hz[0], frequency_hz[-1], frequency_hz.size) == (5.0, 100.0, 381)
