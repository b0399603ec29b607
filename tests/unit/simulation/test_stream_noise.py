"""The noise of a gyro that averages without gaps: densities, order, gaps, and the same as the meter's."""

import math

import numpy as np
import pytest
from numpy.typing import NDArray

from gyrotest.simulation.noise import NoiseDensities, RateNoise
from gyrotest.simulation.stream_noise import StreamNoise
from gyrotest.simulation.streams import Normals

DENSITIES = NoiseDensities(
    angle_random_walk_dps_sqrt_s=0.0025,
    bias_instability_dps=1e-3,
    rate_random_walk_dps_per_sqrt_s=1e-5,
    bandwidth_hz=262.0,
)
ONLY_FLICKER = NoiseDensities(
    angle_random_walk_dps_sqrt_s=0.0,
    bias_instability_dps=1e-3,
    rate_random_walk_dps_per_sqrt_s=0.0,
    bandwidth_hz=262.0,
)
INTERVAL_S = 0.008


def noise(
    seed: int, densities: NoiseDensities = DENSITIES, *, interval_s: float = INTERVAL_S
) -> StreamNoise:
    return StreamNoise(
        densities, np.random.default_rng(seed), interval_s=interval_s, since_power_on_s=600.0
    )


def allan(means: NDArray[np.float64], m: int) -> float:
    groups = means[: means.size // m * m].reshape(-1, m).mean(axis=1)
    return float(np.sqrt(np.mean(np.diff(groups) ** 2) / 2.0))


@pytest.mark.parametrize("m", [10, 30, 300, 3000])
@pytest.mark.parametrize("interval_s", [0.0005, 0.008])
def test_flicker_noise_is_flat_at_its_coefficient(m: int, interval_s: float) -> None:
    expected = math.sqrt(2.0 * math.log(2.0) / math.pi) * 1e-3
    found = [
        allan(noise(seed, ONLY_FLICKER, interval_s=interval_s).take(200_000), m) for seed in range(6)
    ]
    # Below some intervals the filter takes its share.
    assert np.mean(found) == pytest.approx(
        expected, rel=0.12 if m == 10 and interval_s < 0.001 else 0.06
    )


@pytest.mark.parametrize("m", [1, 10, 100, 1000])
def test_it_has_the_deviations_of_the_noise_that_a_meter_reads(m: int) -> None:
    streamed = [allan(noise(seed).take(100_000), m) for seed in range(6)]
    read = []
    for seed in range(6):
        normals = Normals(np.random.default_rng(100 + seed))
        source = RateNoise(DENSITIES, normals, since_power_on_s=600.0, start_s=0.0)
        read.append(allan(source.means(0.0, INTERVAL_S, INTERVAL_S, 100_000), m))
    assert np.mean(streamed) == pytest.approx(np.mean(read), rel=0.01 if m < 100 else 0.08)


def test_the_order_does_not_depend_on_how_many_are_taken_at_a_time() -> None:
    whole = noise(1).take(20_000).copy()
    source = noise(1)
    parts = [source.take(size).copy() for size in (1, 5000, 17, 0, 4096, 10_886)]
    assert np.array_equal(np.concatenate(parts), whole)


def test_a_short_gap_leaves_out_what_would_have_come() -> None:
    whole, source = noise(2).take(1000).copy(), noise(2)
    source.take(10)
    source.skip(90)
    assert np.array_equal(source.take(900), whole[100:])


def test_a_long_gap_goes_on_with_the_same_spread() -> None:
    ends = []
    for seed in range(300):
        source = noise(seed, ONLY_FLICKER)
        source.skip(1_000_000)
        ends.append(source.take(100).mean())
    direct = [noise(1000 + seed, ONLY_FLICKER).take(100).mean() for seed in range(300)]
    assert np.std(ends) == pytest.approx(np.std(direct), rel=0.25)


def test_it_begins_at_zero_at_power_on() -> None:
    fresh = [
        StreamNoise(
            ONLY_FLICKER, np.random.default_rng(seed), interval_s=INTERVAL_S, since_power_on_s=0.0
        ).take(1)[0]
        for seed in range(200)
    ]
    warm = [noise(seed, ONLY_FLICKER).take(1)[0] for seed in range(200)]
    assert np.std(fresh) < 0.6 * np.std(warm)
