"""Allan deviation and its family: known answers, properties, refusals."""

from collections.abc import Callable

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from gyrotest.analysis.allan import (
    AllanDeviation,
    allan_deviation,
    default_factors,
    hadamard_deviation,
    log_spaced_factors,
    modified_allan_deviation,
    overlapping_allan_deviation,
    total_deviation,
)
from gyrotest.analysis.noise_type import NoiseType
from gyrotest.errors import InsufficientDataError
from tests.unit.analysis.generator import gyro_noise

# Of a grid, so that no two samples differ by a rounding error only.
records = st.lists(
    st.integers(-6400, 6400).map(lambda step: step / 64.0), min_size=9, max_size=60
).filter(lambda values: max(values) > min(values))


def plain_overlapping(rate: np.ndarray, m: int) -> float:
    """The definition, over all pairs of adjacent group means."""
    means = [rate[k : k + m].mean() for k in range(rate.size - m + 1)]
    squares = [(means[k + m] - means[k]) ** 2 for k in range(rate.size - 2 * m + 1)]
    return float(np.sqrt(np.mean(squares) / 2.0))


def plain_classic(rate: np.ndarray, m: int) -> float:
    groups = rate[: rate.size // m * m].reshape(-1, m).mean(axis=1)
    return float(np.sqrt(np.mean(np.diff(groups) ** 2) / 2.0))


def plain_modified(rate: np.ndarray, m: int) -> float:
    """The mean of m neighbouring differences of group means is squared."""
    means = np.array([rate[k : k + m].mean() for k in range(rate.size - m + 1)])
    steps = means[m:] - means[:-m]
    squares = [steps[k : k + m].mean() ** 2 for k in range(steps.size - m + 1)]
    return float(np.sqrt(np.mean(squares) / 2.0))


def plain_hadamard(rate: np.ndarray, m: int) -> float:
    means = [rate[k : k + m].mean() for k in range(rate.size - m + 1)]
    starts = range(rate.size - 3 * m + 1)
    squares = [(means[k + 2 * m] - 2.0 * means[k + m] + means[k]) ** 2 for k in starts]
    return float(np.sqrt(np.mean(squares) / 6.0))


def plain_total(rate: np.ndarray, m: int) -> float:
    """The angle's point reflection at an end is the record's mirror image."""
    longer = np.concatenate((rate[m - 1 :: -1], rate, rate[: -m - 1 : -1]))
    steps = [longer[k : k + m].mean() - longer[k - m : k].mean() for k in range(m + 1, m + rate.size)]
    return float(np.sqrt(np.mean(np.square(steps)) / 2.0))


FAMILY: dict[str, tuple[Callable[..., AllanDeviation], Callable[[np.ndarray, int], float]]] = {
    "overlapping": (overlapping_allan_deviation, plain_overlapping),
    "classic": (allan_deviation, plain_classic),
    "modified": (modified_allan_deviation, plain_modified),
    "hadamard": (hadamard_deviation, plain_hadamard),
    "total": (total_deviation, plain_total),
}
every_estimator = pytest.mark.parametrize("estimator", list(FAMILY))


def differences(estimator: str, samples: int, m: int) -> int:
    """Count the differences that a record has; none below 1."""
    if estimator == "total":
        return samples - 1 if 2 * m <= samples else 0
    return {
        "overlapping": samples + 1 - 2 * m,
        "classic": samples // m - 1,
        "modified": samples + 2 - 3 * m,
        "hadamard": samples + 1 - 3 * m,
    }[estimator]


@every_estimator
@pytest.mark.parametrize("size", [36, 37, 101, 8200])
def test_an_estimator_equals_its_definition(estimator: str, size: int) -> None:
    rate = gyro_noise(size, angle_random_walk=1.0, rate_random_walk=0.1) + 1e4
    compute, definition = FAMILY[estimator]
    curve = compute(rate, sample_rate_hz=4.0, averaging_factors=[1, 3, size // 3])
    expected = [definition(rate - 1e4, int(m)) for m in curve.averaging_factor]
    np.testing.assert_allclose(curve.deviation_dps, expected, rtol=1e-9)
    np.testing.assert_allclose(curve.tau_s, curve.averaging_factor / 4.0)
    assert curve.n_differences.tolist() == [
        differences(estimator, size, int(m)) for m in curve.averaging_factor
    ]


@every_estimator
@pytest.mark.parametrize("size", [2, 3, 8])
def test_a_tiny_record_gives_the_right_answer_or_a_refusal(estimator: str, size: int) -> None:
    rate = np.array([1.0, 4.0, 2.0, -3.0, 0.5, 7.0, 6.0, 5.0])[:size]
    compute, definition = FAMILY[estimator]
    with pytest.raises(InsufficientDataError, match="at least 9 groups"):
        compute(rate, sample_rate_hz=1.0)
    for m in range(1, size + 1):
        if differences(estimator, size, m) < 1:
            found = f"averaging {m} samples needs at least [0-9]+; the record has {size}"
            with pytest.raises(InsufficientDataError, match=found):
                compute(rate, sample_rate_hz=1.0, averaging_factors=[m])
        else:
            curve = compute(rate, sample_rate_hz=1.0, averaging_factors=[m])
            assert curve.deviation_dps[0] == pytest.approx(definition(rate, m), rel=1e-12)
            assert curve.lower_dps[0] < curve.deviation_dps[0] < curve.upper_dps[0]


@every_estimator
def test_a_refusal_names_the_smallest_record_that_will_do(estimator: str) -> None:
    compute = FAMILY[estimator][0]
    rate = gyro_noise(100, angle_random_walk=1.0)
    needed = {"modified": 59, "hadamard": 60}.get(estimator, 40)
    assert compute(rate[:needed], sample_rate_hz=1.0, averaging_factors=[20]).n_differences[0] >= 1
    with pytest.raises(InsufficientDataError, match=f"at least {needed}; the record has {needed - 1}"):
        compute(rate[: needed - 1], sample_rate_hz=1.0, averaging_factors=[20])


def test_white_rate_noise_gives_minus_half_slope() -> None:
    rate = gyro_noise(200_000, angle_random_walk=0.01)
    curve = overlapping_allan_deviation(rate, sample_rate_hz=1.0, averaging_factors=[1, 10, 100])
    np.testing.assert_allclose(curve.deviation_dps * np.sqrt(curve.tau_s), 0.01, rtol=0.05)


def test_a_rate_ramp_gives_slope_one() -> None:
    rate = 0.5 * np.arange(1000.0)
    curve = overlapping_allan_deviation(rate, sample_rate_hz=1.0)
    np.testing.assert_allclose(curve.deviation_dps, 0.5 * curve.tau_s / np.sqrt(2.0), rtol=1e-9)


@settings(max_examples=60, deadline=None)
@given(
    estimator=st.sampled_from(list(FAMILY)),
    values=records,
    scale=st.floats(0.1, 1000.0),
    offset=st.floats(-1e3, 1e3),
)
def test_scale_passes_through_and_offset_and_direction_of_time_do_not_matter(
    estimator: str, values: list[float], scale: float, offset: float
) -> None:
    rate, compute = np.array(values), FAMILY[estimator][0]
    # Groups side by side are other groups from the other end, unless they fill the record.
    factors = [m for m in range(1, rate.size // 9 + 1) if estimator != "classic" or rate.size % m == 0]
    curve = compute(rate, sample_rate_hz=1.0, averaging_factors=factors)
    for changed in (scale * rate + offset, scale * rate[::-1], -scale * rate):
        other = compute(changed, sample_rate_hz=1.0, averaging_factors=factors)
        np.testing.assert_allclose(
            other.deviation_dps, scale * curve.deviation_dps, rtol=1e-9, atol=1e-9 * scale
        )


@settings(max_examples=40, deadline=None)
@given(
    estimator=st.sampled_from(list(FAMILY)),
    shape=st.lists(st.integers(1, 3), min_size=1, max_size=2),
    samples=st.integers(9, 400),
    seed=st.integers(0, 1000),
)
def test_leading_axes_give_what_the_axes_give_one_by_one(
    estimator: str, shape: list[int], samples: int, seed: int
) -> None:
    rate = np.random.default_rng(seed).standard_normal((*shape, samples))
    together = FAMILY[estimator][0](rate, sample_rate_hz=2.0)
    assert together.deviation_dps.shape == (*shape, together.tau_s.size)
    for place in np.ndindex(*shape):
        alone = FAMILY[estimator][0](rate[place], sample_rate_hz=2.0)
        for name in ("averaging_factor", "tau_s", "n_differences"):
            assert np.array_equal(getattr(together, name), getattr(alone, name))
        for name in ("deviation_dps", "edf", "lower_dps", "upper_dps", "noise_type"):
            assert np.array_equal(getattr(together, name)[place], getattr(alone, name))


@every_estimator
def test_axes_in_columns_and_whole_numbers_are_taken_as_they_come(estimator: str) -> None:
    counts = np.random.default_rng(1).integers(-2000, 2000, (500, 3), dtype=np.int16)
    compute = FAMILY[estimator][0]
    curve = compute(counts.T, sample_rate_hz=1.0)
    expected = compute(np.ascontiguousarray(counts.T, dtype=float), sample_rate_hz=1.0)
    np.testing.assert_allclose(curve.deviation_dps, expected.deviation_dps, rtol=1e-12)


def test_a_rate_ramp_is_nothing_to_the_hadamard_deviation() -> None:
    noise = gyro_noise(3000, angle_random_walk=1.0)
    plain = hadamard_deviation(noise, sample_rate_hz=1.0)
    ramped = hadamard_deviation(noise + 0.5 * np.arange(3000.0), sample_rate_hz=1.0)
    np.testing.assert_allclose(ramped.deviation_dps, plain.deviation_dps, rtol=1e-7)


def test_the_modified_deviation_of_white_angle_noise_has_slope_three_halves() -> None:
    rate = np.diff(np.random.default_rng(3).standard_normal(100_001))
    curve = modified_allan_deviation(rate, sample_rate_hz=1.0, averaging_factors=[4, 16, 64])
    np.testing.assert_allclose(curve.deviation_dps * curve.tau_s**1.5, np.sqrt(3.0), rtol=0.05)


def test_the_modified_deviation_of_single_samples_is_the_overlapping_one() -> None:
    rate = gyro_noise(200_000, rate_random_walk=1.0)
    curves = [
        compute(rate, sample_rate_hz=1.0, averaging_factors=[1])
        for compute in (modified_allan_deviation, overlapping_allan_deviation)
    ]
    np.testing.assert_allclose(curves[0].deviation_dps, curves[1].deviation_dps, rtol=1e-12)


def test_a_large_offset_costs_no_digits() -> None:
    rate = gyro_noise(300_000, angle_random_walk=1e-4)
    plain = overlapping_allan_deviation(rate, sample_rate_hz=1.0)
    offset = overlapping_allan_deviation(rate + 2.5, sample_rate_hz=1.0)
    np.testing.assert_allclose(offset.deviation_dps, plain.deviation_dps, rtol=1e-9)


@pytest.mark.parametrize("samples", [9, 10, 99, 900, 9000, 9_000_000, 90_000_000])
def test_default_factors_are_ten_a_decade_up_to_a_ninth(samples: int) -> None:
    factors = default_factors(samples)
    assert factors[0] == 1
    assert factors[-1] == samples // 9
    assert np.all(np.diff(factors) > 0)
    assert abs(np.count_nonzero((factors >= 100) & (factors < 1000)) - 10) <= 1 or samples < 9000
    assert {m for m in (1, 10, 100) if m <= samples // 9} <= set(factors.tolist())


def test_the_octave_of_a_default_factor_is_one_too() -> None:
    factors = default_factors(9_000_000)
    assert factors.size >= 55
    doubled = 2 * factors[(factors >= 16) & (factors <= 250_000)]
    assert np.isin(doubled, factors).all()


def test_log_spaced_factors_hold_both_ends() -> None:
    assert log_spaced_factors(7, per_decade=10).tolist() == [1, 2, 3, 4, 5, 6, 7]
    assert log_spaced_factors(37, per_decade=5).tolist() == [1, 2, 3, 4, 6, 10, 16, 25, 37]


def test_bounds_enclose_the_deviation_and_widen_with_confidence() -> None:
    curve = overlapping_allan_deviation(gyro_noise(900, angle_random_walk=1.0), sample_rate_hz=1.0)
    wide = curve.bounds_dps(0.95)
    assert np.all(wide.lower < curve.lower_dps)
    assert np.all(curve.lower_dps < curve.deviation_dps)
    assert np.all(curve.deviation_dps < curve.upper_dps)
    assert np.all(curve.upper_dps < wide.upper)
    for confidence in (0.0, 1.0, 95.0, float("nan")):
        with pytest.raises(ValueError, match="between 0 and 1"):
            curve.bounds_dps(confidence)


def test_the_record_is_read_only_and_part_of_a_curve_can_be_taken() -> None:
    curve = overlapping_allan_deviation(gyro_noise(900, angle_random_walk=1.0), sample_rate_hz=1.0)
    with pytest.raises(ValueError, match="read-only"):
        curve.deviation_dps[0] = 0.0
    part = curve.at([1, 100])
    assert part.averaging_factor.tolist() == [1, 100]
    assert part.deviation_dps[1] == curve.deviation_dps[-1]
    for one in (curve, part, curve.at(curve.averaging_factor)):
        for name in one.__slots__:
            assert not getattr(one, name).flags.writeable, name
    with pytest.raises(ValueError, match="no averaging factor 7"):
        curve.at([1, 7])


def test_each_axis_has_noise_types_of_its_own() -> None:
    rate = [gyro_noise(4000, angle_random_walk=1.0), gyro_noise(4000, rate_random_walk=1.0)]
    curve = overlapping_allan_deviation(rate, sample_rate_hz=1.0, averaging_factors=[1, 4, 10])
    assert curve.noise_type.dtype == np.int8
    assert np.all(curve.noise_type[0] == NoiseType.ANGLE_RANDOM_WALK)
    assert np.all(curve.noise_type[1] == NoiseType.RATE_RANDOM_WALK)
    assert np.all(curve.edf[1] < curve.edf[0])


@pytest.mark.parametrize(
    ("values", "message"),
    [
        ([], "has 0 samples"),
        ([1.0], "has 1 samples"),
        ([1.0, 2.0, 3.0, 4.0], "at least 9 groups"),
        ([3.0] * 20, "all 20 samples are 3"),
        ([1.0, 2.0] * 9 + [float("nan"), float("inf")], r"sample 18 is nan \(2 of 20"),
        ([1.0, float("-inf")] + [0.0] * 9, "sample 1 is -inf"),
    ],
)
@every_estimator
def test_too_little_or_unusable_data_is_refused(
    estimator: str, values: list[float], message: str
) -> None:
    with pytest.raises(InsufficientDataError, match=message):
        FAMILY[estimator][0](values, sample_rate_hz=1.0)


@every_estimator
def test_of_several_axes_the_one_that_will_not_do_is_named(estimator: str) -> None:
    compute, rate = FAMILY[estimator][0], np.random.default_rng(1).standard_normal((2, 3, 20))
    rate[1, 2, 18] = np.nan
    with pytest.raises(InsufficientDataError, match=r"^axis 1, 2: sample 18 is nan"):
        compute(rate, sample_rate_hz=1.0)
    rate[1, 0] = 3.0
    with pytest.raises(InsufficientDataError, match=r"^axis 1, 0: all 20 samples are 3"):
        compute(rate, sample_rate_hz=1.0)
    with pytest.raises(InsufficientDataError, match=r"^axis 0: all 20 samples are 3"):
        compute(rate[1], sample_rate_hz=1.0)


@every_estimator
@pytest.mark.parametrize("sample_rate_hz", [0.0, -1.0, float("nan"), float("inf")])
def test_a_sample_rate_is_positive_and_finite(estimator: str, sample_rate_hz: float) -> None:
    with pytest.raises(ValueError, match="positive, finite number of Hz"):
        FAMILY[estimator][0]([1.0, 3.0] * 9, sample_rate_hz=sample_rate_hz)


@every_estimator
@pytest.mark.parametrize("factors", [[], [0], [2, -1], [1.5], [2.0], ["1"]])
def test_averaging_factors_are_positive_whole_numbers(estimator: str, factors: list[int]) -> None:
    with pytest.raises(ValueError, match="positive whole numbers"):
        FAMILY[estimator][0]([1.0, 3.0] * 9, sample_rate_hz=1.0, averaging_factors=factors)


@pytest.mark.parametrize("shape", [(), (0, 20)])
def test_a_record_without_an_axis_is_refused(shape: tuple[int, ...]) -> None:
    with pytest.raises(ValueError, match="at least one axis"):
        overlapping_allan_deviation(np.ones(shape), sample_rate_hz=1.0)


def test_long_averaging_times_alone_have_the_noise_type_of_the_longest_that_shows_one() -> None:
    rate = gyro_noise(3000, rate_random_walk=1.0)
    curve = overlapping_allan_deviation(rate, sample_rate_hz=1.0, averaging_factors=[300, 1000])
    assert curve.noise_type.tolist() == [NoiseType.RATE_RANDOM_WALK] * 2


def test_averaging_factors_come_back_ascending_and_once() -> None:
    rate = gyro_noise(100, angle_random_walk=1.0)
    curve = overlapping_allan_deviation(rate, sample_rate_hz=1.0, averaging_factors=[5, 1, 5, 2])
    assert curve.averaging_factor.tolist() == [1, 2, 5]


@every_estimator
def test_a_masked_sample_is_no_sample(estimator: str) -> None:
    rate = gyro_noise(50, angle_random_walk=1.0)
    with pytest.raises(InsufficientDataError, match="1 of 50 samples are masked"):
        FAMILY[estimator][0](np.ma.masked_array(rate, mask=np.arange(50) == 5), sample_rate_hz=1.0)
    unmasked = FAMILY[estimator][0](np.ma.masked_array(rate), sample_rate_hz=1.0)
    np.testing.assert_array_equal(
        unmasked.deviation_dps, FAMILY[estimator][0](rate, sample_rate_hz=1.0).deviation_dps
    )


@pytest.mark.parametrize(
    "samples",
    [np.ones(50) * 1j, np.array(["1.5", "2.5"] * 25), np.arange(50).astype("m8[s]")],
    ids=["complex", "text", "times"],
)
def test_what_are_no_real_numbers_are_refused(samples: np.ndarray) -> None:
    with pytest.raises(ValueError, match="samples are real numbers, found "):
        overlapping_allan_deviation(samples, sample_rate_hz=1.0)


@pytest.mark.parametrize("factor", [1e200, 1e-200])
def test_samples_whose_squares_are_no_numbers_are_refused(factor: float) -> None:
    rate = factor * gyro_noise(50, angle_random_walk=1.0)
    with pytest.raises(InsufficientDataError, match="the squares are no numbers any more; is the unit"):
        overlapping_allan_deviation(rate, sample_rate_hz=1.0)
