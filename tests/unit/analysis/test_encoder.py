"""Encoder signals: the ellipse they go round, and the angle that they stand for."""

import dataclasses
import itertools

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from gyrotest.analysis.encoder import AngleTrack, Decoder, Ellipse, EllipseFit, required_rate_hz
from gyrotest.errors import InsufficientDataError

LINES = 9000
RATE_HZ = 10_000.0
LINE_DEG = 360.0 / LINES
FAULTY = Ellipse(
    sine_offset=2.51,
    cosine_offset=2.43,
    sine_amplitude=0.52,
    cosine_amplitude=0.46,
    quadrature_error=0.07,
)


def vibration_deg(samples: int = 20_000, amplitude_deg: float = 0.3) -> np.ndarray:
    time_s = np.arange(samples) / RATE_HZ
    fast = 0.02 * np.sin(2.0 * np.pi * 83.0 * time_s)
    return 0.013 + amplitude_deg * (np.sin(2.0 * np.pi * 5.0 * time_s) + fast)


def signals(angle_deg: np.ndarray, ellipse: Ellipse = FAULTY, noise: float = 0.0) -> np.ndarray:
    phase = np.deg2rad(angle_deg) * LINES
    clean = np.stack(
        (
            ellipse.sine_offset + ellipse.sine_amplitude * np.sin(phase),
            ellipse.cosine_offset + ellipse.cosine_amplitude * np.cos(phase + ellipse.quadrature_error),
        )
    )
    return clean + noise * np.random.default_rng(3).normal(size=clean.shape)


def fitted(both: np.ndarray, block: int = 4096) -> Ellipse:
    (sine, cosine), fit = both, EllipseFit()
    for begin in range(0, sine.size, block):
        fit.push(sine[begin : begin + block], cosine[begin : begin + block])
    return fit.fit()


def decoder(ellipse: Ellipse = FAULTY, *, reversed_: bool = False) -> Decoder:
    return Decoder(ellipse, lines=LINES, rate_hz=RATE_HZ, reversed_=reversed_)


def in_lines(found_deg: np.ndarray, true_deg: np.ndarray) -> np.ndarray:
    """The error without whole lines, in lines."""
    error = (found_deg - true_deg) / LINE_DEG
    whole: np.ndarray = error - np.rint(error[0])
    return whole


def test_the_ellipse_of_clean_signals_is_found_exactly() -> None:
    found = fitted(signals(vibration_deg()))
    for name in ("sine_offset", "cosine_offset", "sine_amplitude", "cosine_amplitude"):
        assert getattr(found, name) == pytest.approx(getattr(FAULTY, name), abs=1e-10)
    assert found.quadrature_error == pytest.approx(FAULTY.quadrature_error, abs=1e-10)
    assert found.harmonics < 1e-10


@settings(max_examples=30, deadline=None)
@given(
    offsets=st.tuples(st.floats(-3.0, 3.0), st.floats(-3.0, 3.0)),
    ratio=st.floats(0.5, 2.0),
    quadrature_error=st.floats(-0.4, 0.4),
)
def test_any_offsets_gains_and_quadrature_are_corrected(
    offsets: tuple[float, float], ratio: float, quadrature_error: float
) -> None:
    true_deg = vibration_deg(4000)
    faulty = Ellipse(
        sine_offset=offsets[0],
        cosine_offset=offsets[1],
        sine_amplitude=0.5,
        cosine_amplitude=0.5 * ratio,
        quadrature_error=quadrature_error,
    )
    sine, cosine = signals(true_deg, faulty)
    found_deg = decoder(fitted(np.stack((sine, cosine)))).push(sine, cosine)
    assert np.abs(in_lines(found_deg, true_deg)).max() < 1e-6


def test_noisy_signals_give_the_angle_to_a_ten_thousandth_of_a_line() -> None:
    true_deg = vibration_deg(400_000)
    found = fitted(signals(true_deg, noise=0.005), block=65536)
    error = in_lines(decoder(found).push(*signals(true_deg)), true_deg)
    assert np.abs(error - error.mean()).max() < 1e-4
    assert found.scatter == pytest.approx(0.0102, rel=0.1)


def test_points_that_begin_at_rest_still_give_the_ellipse() -> None:
    angle = np.concatenate((np.zeros(70_000), vibration_deg()))
    found = fitted(signals(angle, noise=1e-4), block=65536)
    assert found.sine_offset == pytest.approx(FAULTY.sine_offset, abs=2e-4)
    assert found.cosine_amplitude == pytest.approx(FAULTY.cosine_amplitude, abs=2e-4)


def test_the_angle_goes_on_over_blocks_of_any_size_and_both_ways() -> None:
    true_deg = np.concatenate((np.linspace(0.0, 2.0, 9000), np.linspace(2.0, -1.0, 12000)))
    sine, cosine = signals(true_deg)
    one = decoder()
    edges = [0, 1, 2, 5, 700, 701, 9003, 20_000, true_deg.size]
    parts = [one.push(sine[a:b], cosine[a:b]) for a, b in itertools.pairwise(edges)]
    one.check()
    np.testing.assert_allclose(np.concatenate(parts), true_deg, atol=1e-4 * LINE_DEG)
    assert one.fastest_dps == pytest.approx(3.0 / 12000 * RATE_HZ, rel=1e-3)


def test_a_reversed_encoder_gives_the_other_sign() -> None:
    sine, cosine = signals(vibration_deg())
    np.testing.assert_allclose(decoder(reversed_=True).push(sine, cosine), -decoder().push(sine, cosine))


def test_after_a_reset_the_angle_begins_anew() -> None:
    sine, cosine = signals(vibration_deg())
    one = decoder()
    whole = one.push(sine, cosine)
    one.reset()
    np.testing.assert_array_equal(one.push(sine, cosine), whole)


def test_a_pass_at_rest_is_decoded_by_the_ellipse_of_the_runs() -> None:
    at_rest = 0.7 * LINE_DEG + 0.001 * LINE_DEG * np.sin(np.arange(3000) / 50.0)
    with pytest.raises(InsufficientDataError, match=r"do not go round|parts of a line"):
        fitted(signals(at_rest, noise=1e-4))
    ellipse = fitted(signals(vibration_deg()))
    error = in_lines(decoder(ellipse).push(*signals(at_rest)), at_rest)
    assert np.abs(error).max() < 1e-6


def test_the_rule_of_six_samples_a_line_is_the_methods() -> None:
    assert required_rate_hz(60.0, 9000) == pytest.approx(9000.0)
    assert required_rate_hz(-60.0, 9000) == pytest.approx(9000.0)


def test_too_fast_a_turn_is_refused_with_both_rates() -> None:
    limit_dps = RATE_HZ * 360.0 / (6.0 * LINES)
    for share, refused in ((0.99, False), (1.02, True), (3.3, True)):
        time_s = np.arange(8000) / RATE_HZ
        turning = np.cumsum(share * limit_dps * np.sin(2.0 * np.pi * 5.0 * time_s)) / RATE_HZ
        if not refused:
            decoder().push(*signals(turning))
            continue
        with pytest.raises(InsufficientDataError, match="10000 Hz") as caught:
            decoder().push(*signals(turning))
        assert "ω_max" in str(caught.value)
        assert "9000 lines (M)" in str(caught.value)
        needed = float(str(caught.value).split(" need ")[1].split(" Hz")[0])
        assert needed > RATE_HZ


def test_a_lost_signal_is_counted_and_placed() -> None:
    sine, cosine = signals(vibration_deg())
    sine[7000:7012], cosine[7000:7012] = FAULTY.sine_offset, FAULTY.cosine_offset
    one = decoder()
    for begin in range(0, sine.size, 1000):
        one.push(sine[begin : begin + 1000], cosine[begin : begin + 1000])
    with pytest.raises(InsufficientDataError, match=r"lost in 12 samples, first at sample 7000 "):
        one.check()


@pytest.mark.parametrize("block", [20_000, 997, 5001, 2])
def test_an_angle_that_leaps_is_counted_and_placed(block: int) -> None:
    true_deg = vibration_deg(amplitude_deg=0.05)
    true_deg[5000:] += 0.45 * LINE_DEG
    sine, cosine = signals(true_deg)
    one = decoder()
    for begin in range(0, sine.size, block):
        one.push(sine[begin : begin + block], cosine[begin : begin + block])
    with pytest.raises(InsufficientDataError, match=r"leaps 1 times.* first at sample 5000 "):
        one.check()


def test_sound_signals_pass_the_check() -> None:
    one = decoder()
    one.push(*signals(vibration_deg(), noise=0.01))
    one.check()


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda u, v: (u, np.full_like(v, 2.4)), "cosine signal is constant"),
        (lambda u, v: (np.full_like(u, 2.4), np.full_like(v, 2.4)), "sine and cosine signal are"),
        (lambda u, v: (u, 2.4 + 0.01 * (v - 2.4)), "do not go round"),
        (lambda u, v: (np.minimum(u, 2.9), v), "sine signal stands at 2.9 .* clipped"),
        (lambda u, v: (u, np.maximum(v, 2.1)), "cosine signal stands at 2.1 .* clipped"),
        (lambda u, v: (u[:100], v[:100]), "100 samples are too few"),
    ],
)
def test_signals_that_give_no_ellipse_are_refused(change: object, message: str) -> None:
    assert callable(change)
    with pytest.raises(InsufficientDataError, match=message):
        fitted(change(*signals(vibration_deg(), noise=1e-3)))


def test_coarsely_digitised_signals_are_not_taken_for_clipped() -> None:
    step = 0.52 / 120.0
    found = fitted(np.rint(signals(vibration_deg()) / step) * step)
    assert found.sine_amplitude == pytest.approx(FAULTY.sine_amplitude, rel=1e-3)


def test_less_than_a_line_is_refused_with_what_is_covered() -> None:
    angle = 0.35 * LINE_DEG * np.sin(np.arange(20_000) / 30.0)
    with pytest.raises(InsufficientDataError, match=r"cover \d+ of 32 parts of a line"):
        fitted(signals(angle, noise=1e-4))


def test_distortion_that_an_ellipse_cannot_correct_is_told() -> None:
    true_deg = vibration_deg(100_000)
    sine, cosine = signals(true_deg, noise=2e-3)
    sine += 0.01 * FAULTY.sine_amplitude * np.sin(2.0 * np.deg2rad(true_deg) * LINES)
    found = fitted(np.stack((sine, cosine)))
    error = in_lines(decoder(found).push(sine, cosine), true_deg)
    assert found.harmonics == pytest.approx(0.005, abs=0.0007)
    assert np.abs(error - error.mean()).max() * 2.0 * np.pi < 2.5 * found.harmonics + 0.02


def test_an_angle_is_unwrapped_over_whole_turns() -> None:
    true_deg = np.linspace(10.0, 1500.0, 4000)
    track = AngleTrack(rate_hz=1000.0)
    wrapped = true_deg % 360.0
    parts = [track.push(wrapped[a : a + 333]) for a in range(0, 4000, 333)]
    track.check()
    np.testing.assert_allclose(np.concatenate(parts), true_deg)
    assert track.fastest_dps == pytest.approx(1490.0 / 3999 * 1000.0)
    np.testing.assert_allclose(
        AngleTrack(rate_hz=1000.0, reversed_=True).push(wrapped[:50]), -wrapped[:50]
    )


def test_a_leap_of_an_angle_is_told_and_flicker_of_its_last_digit_is_none() -> None:
    quiet = np.zeros(5000)
    quiet[2000] = 0.001
    still = AngleTrack(rate_hz=1000.0)
    still.push(quiet)
    still.check()
    true_deg = vibration_deg()
    true_deg[8000:] += 0.5
    track = AngleTrack(rate_hz=RATE_HZ)
    track.push(true_deg)
    with pytest.raises(InsufficientDataError, match=r"leaps 1 times.* first at sample 8000 "):
        track.check()
    with pytest.raises(InsufficientDataError, match=r"changes by 100° .* 1000 Hz"):
        AngleTrack(rate_hz=1000.0).push(np.array([0.0, 100.0]))


def test_an_ellipse_says_what_the_signals_are_corrected_to() -> None:
    ellipse = dataclasses.replace(FAULTY, quadrature_error=0.3)
    phase = np.linspace(-3.0, 3.0, 50)
    vector = ellipse.corrected(*signals(np.rad2deg(phase) / LINES, ellipse))
    np.testing.assert_allclose(vector.sine, np.sin(phase), atol=1e-12)
    np.testing.assert_allclose(vector.cosine, np.cos(phase), atol=1e-12)
    np.testing.assert_allclose(vector.length, 1.0, atol=1e-12)
