"""The Allan deviation of a stream, against the one of the whole record."""

import copy
import pickle
from collections.abc import Callable, Sequence

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from gyrotest.analysis.accumulator import AllanAccumulator, Mode
from gyrotest.analysis.allan import AllanDeviation, default_factors, overlapping_allan_deviation
from gyrotest.analysis.edf import allan_edf
from gyrotest.analysis.kernels import pyramid
from gyrotest.analysis.noise_type import NoiseType
from gyrotest.errors import InsufficientDataError
from tests.unit.analysis.generator import gyro_noise

MODES = [Mode.EXACT, Mode.BOUNDED]
NOISES = {
    NoiseType.ANGLE_RANDOM_WALK: {"angle_random_walk": 1.0},
    NoiseType.BIAS_INSTABILITY: {"bias_instability": 1.0},
    NoiseType.RATE_RANDOM_WALK: {"rate_random_walk": 1.0},
}


def accumulator(
    mode: Mode, factors: Sequence[int] | np.ndarray = (1, 3, 10, 25, 50)
) -> AllanAccumulator:
    return AllanAccumulator(4.0, mode=mode, averaging_factors=factors if mode is Mode.EXACT else None)


def assert_same_bits(one: AllanDeviation, other: AllanDeviation) -> None:
    for name in AllanDeviation.__slots__:
        np.testing.assert_array_equal(getattr(one, name), getattr(other, name), err_msg=name)


@pytest.mark.parametrize("size", [18, 127, 128, 1025, 16_384, 70_001])
@pytest.mark.parametrize("noise", NOISES)
def test_the_exact_mode_equals_the_whole_record(size: int, noise: NoiseType) -> None:
    rate = gyro_noise(size, **NOISES[noise]) + 2.5
    factors = default_factors(size)
    stream = accumulator(Mode.EXACT, factors)
    for block in np.array_split(rate, 7):
        stream.push(block)
    found = stream.result()
    whole = overlapping_allan_deviation(rate, sample_rate_hz=4.0)
    np.testing.assert_allclose(found.deviation_dps, whole.deviation_dps, rtol=1e-12)
    np.testing.assert_allclose(found.edf, whole.edf, rtol=1e-12)
    np.testing.assert_allclose(found.upper_dps, whole.upper_dps, rtol=1e-12)
    for name in ("averaging_factor", "tau_s", "n_differences", "noise_type"):
        np.testing.assert_array_equal(getattr(found, name), getattr(whole, name))


@pytest.mark.parametrize("noise", NOISES)
def test_the_bounded_mode_is_near_the_whole_record(noise: NoiseType) -> None:
    rate = gyro_noise(60_000, **NOISES[noise])
    stream = accumulator(Mode.BOUNDED)
    for block in np.array_split(rate, 50):
        stream.push(block)
    found = stream.result()
    factors = found.averaging_factor
    whole = overlapping_allan_deviation(rate, sample_rate_hz=4.0, averaging_factors=factors)
    full = allan_edf(60_001, factors, np.full(factors.shape, noise))
    sigma = whole.deviation_dps / np.sqrt(2.0 * full)
    off = (found.deviation_dps - whole.deviation_dps) / sigma
    np.testing.assert_allclose(off[factors <= 50], 0.0, atol=1e-7)
    assert np.max(np.abs(off)) < 0.15
    assert np.mean(found.noise_type == whole.noise_type) > 0.7
    same = (found.noise_type == whole.noise_type) & (whole.noise_type <= NoiseType.ANGLE_RANDOM_WALK)
    np.testing.assert_allclose(found.edf[same], whole.edf[same], rtol=0.01)


def test_the_bounded_mode_has_three_times_an_octave_up_to_a_ninth() -> None:
    stream = accumulator(Mode.BOUNDED)
    for size in (9, 90, 1000, 9000):
        stream.push(np.random.default_rng(size).normal(size=size - stream.n_samples))
        factors = stream.result().averaging_factor
        assert factors[0] == 1
        assert factors[-1] <= size // 9 < 1.25 * factors[-1] + 1
        assert np.all(factors[1:] / factors[:-1] <= 2.0)
    assert np.all(factors[10:] / factors[9:-1] <= 1.28)


def test_the_bounded_state_stays_below_sixteen_kilobytes() -> None:
    assert pyramid.SIZE * np.dtype(float).itemsize < 16_000


@pytest.mark.parametrize("mode", MODES)
@settings(max_examples=25, deadline=None)
@given(cuts=st.lists(st.integers(0, 3000), max_size=12), asked=st.booleans())
def test_any_cut_of_the_stream_gives_the_same_bits(mode: Mode, cuts: list[int], asked: bool) -> None:
    rate = np.random.default_rng(3).normal(2.5, 0.1, 3000)
    whole = accumulator(mode)
    whole.push(rate)
    parts = accumulator(mode)
    for block in np.split(rate, sorted(cuts)):
        parts.push(block)
        if asked and parts.n_samples >= 9:
            parts.result()
    assert_same_bits(parts.result(), whole.result())


def test_any_cut_gives_the_same_bits_also_where_the_room_of_the_exact_mode_is_used_up() -> None:
    rate = np.random.default_rng(4).normal(size=60_000)
    whole, parts = accumulator(Mode.EXACT), accumulator(Mode.EXACT)
    whole.push(rate)
    for block in np.array_split(rate, 480):
        parts.push(block)
    assert_same_bits(parts.result(), whole.result())


@pytest.mark.parametrize("mode", MODES)
def test_leading_axes_are_streams_of_their_own(mode: Mode) -> None:
    rate = np.random.default_rng(5).normal(size=(2, 3, 700))
    together = accumulator(mode)
    for block in np.array_split(rate, 5, axis=-1):
        together.push(block)
    found = together.result()
    assert found.deviation_dps.shape[:2] == found.noise_type.shape[:2] == (2, 3)
    for place in np.ndindex(2, 3):
        alone = accumulator(mode)
        alone.push(rate[place])
        one = alone.result()
        np.testing.assert_array_equal(found.deviation_dps[place], one.deviation_dps)
        np.testing.assert_array_equal(found.noise_type[place], one.noise_type)
        np.testing.assert_array_equal(found.edf[place], one.edf)


@pytest.mark.parametrize("mode", MODES)
def test_a_large_offset_costs_no_digits(mode: Mode) -> None:
    noise = np.round(np.random.default_rng(6).normal(size=200_000) * 2**20) * 2.0**-33
    factors = default_factors(noise.size)
    plain, offset = accumulator(mode, factors), accumulator(mode, factors)
    plain.push(noise)
    offset.push(noise + 2.5)
    np.testing.assert_allclose(offset.result().deviation_dps, plain.result().deviation_dps, rtol=1e-12)


@pytest.mark.parametrize("mode", MODES)
@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf])
def test_a_sample_that_is_no_number_is_named_and_its_block_not_taken_in(mode: Mode, bad: float) -> None:
    rate = np.random.default_rng(7).normal(size=(2, 500))
    stream, clean = accumulator(mode), accumulator(mode)
    stream.push(rate[:, :300])
    spoilt = rate[:, 300:].copy()
    spoilt[1, 20] = bad
    with pytest.raises(InsufficientDataError, match=f"axis 1: sample 320 of the stream is {bad}"):
        stream.push(spoilt)
    assert stream.n_samples == 300
    stream.push(rate[:, 300:])
    clean.push(rate)
    assert_same_bits(stream.result(), clean.result())


def test_the_first_sample_may_be_the_bad_one() -> None:
    with pytest.raises(InsufficientDataError, match=r"^sample 0 of the stream is nan"):
        accumulator(Mode.BOUNDED).push([np.nan, 1.0])


def test_too_few_samples_are_refused_and_pushing_goes_on() -> None:
    exact, bounded = accumulator(Mode.EXACT, [3, 5]), accumulator(Mode.BOUNDED)
    for stream, message in (
        (exact, "averaging 3 samples needs at least 6"),
        (bounded, "at least 9 groups"),
    ):
        with pytest.raises(InsufficientDataError):
            stream.result()
        stream.push([1.0, 2.0, 4.0, 3.0])
        with pytest.raises(InsufficientDataError, match=message):
            stream.result()
        stream.push([])
        stream.push([5.0, 1.0, 0.0, 2.0, 4.0])
        assert stream.result().averaging_factor[0] in (1, 3)
    assert exact.result().averaging_factor.tolist() == [3]


@pytest.mark.parametrize("mode", MODES)
def test_a_constant_stream_is_refused_until_it_moves(mode: Mode) -> None:
    stream = accumulator(mode, [1])
    stream.push([3.0] * 200)
    with pytest.raises(InsufficientDataError, match="all 200 samples of a stream are the same"):
        stream.result()
    stream.push([4.0])
    assert stream.result().deviation_dps[0] == pytest.approx(np.sqrt(1.0 / 400.0))


def test_mistakes_in_its_use_are_named() -> None:
    with pytest.raises(ValueError, match="positive, finite"):
        AllanAccumulator(0.0)
    with pytest.raises(ValueError, match="needs its averaging factors"):
        AllanAccumulator(1.0, mode="exact")
    with pytest.raises(ValueError, match="mode='exact' takes any"):
        AllanAccumulator(1.0, averaging_factors=[1])
    with pytest.raises(ValueError, match="is not a valid Mode"):
        AllanAccumulator(1.0, mode="roughly")
    with pytest.raises(ValueError, match="positive whole numbers"):
        accumulator(Mode.EXACT, [0])
    with pytest.raises(ValueError, match="at least one stream"):
        AllanAccumulator(1.0).push(1.0)
    stream = AllanAccumulator(1.0)
    stream.push([[1.0, 2.0]])
    with pytest.raises(ValueError, match=r"leading axes \(1,\); found a block of shape \(2,\)"):
        stream.push([1.0, 2.0])


@pytest.mark.parametrize("mode", Mode)
def test_masked_and_complex_samples_are_refused(mode: Mode) -> None:
    stream = accumulator(mode)
    with pytest.raises(InsufficientDataError, match="2 of 3 samples are masked"):
        stream.push(np.ma.masked_array([1.0, 2.0, 3.0], mask=[True, False, True]))
    with pytest.raises(ValueError, match="samples are real numbers, found complex128"):
        stream.push(np.array([1j]))
    assert stream.n_samples == 0


@pytest.mark.parametrize("mode", Mode)
def test_samples_whose_squares_are_no_numbers_give_no_result(mode: Mode) -> None:
    stream = accumulator(mode)
    stream.push(1e300 * gyro_noise(500, angle_random_walk=1.0))
    with pytest.raises(InsufficientDataError, match="their squares are no numbers any more"):
        stream.result()


def test_before_the_first_sample_too_few_are_told() -> None:
    with pytest.raises(InsufficientDataError, match="averaging 1 samples needs at least 2; there are 0"):
        accumulator(Mode.EXACT).result()


@pytest.mark.parametrize("copied", [copy.copy, copy.deepcopy, pickle.dumps])
def test_an_accumulator_is_not_copied(copied: Callable[[AllanAccumulator], object]) -> None:
    with pytest.raises(TypeError, match="neither copied nor pickled"):
        copied(accumulator(Mode.BOUNDED))
