"""The gyro's noise against theory (IEEE 952 Annex C) and against its own sampling pattern."""

import math
from collections.abc import Sequence

import numpy as np
import pytest
from numpy.typing import NDArray

from gyrotest.simulation.noise import NoiseDensities, RateNoise
from gyrotest.simulation.streams import Normals, generator


def densities(
    *, n: float = 0.0, b: float = 0.0, k: float = 0.0, bandwidth: float = 50.0
) -> NoiseDensities:
    return NoiseDensities(
        angle_random_walk_dps_sqrt_s=n,
        bias_instability_dps=b,
        rate_random_walk_dps_per_sqrt_s=k,
        bandwidth_hz=bandwidth,
    )


def noise(
    given: NoiseDensities, *, seed: int = 1, since_power_on_s: float = 0.0, start_s: float = 0.0
) -> RateNoise:
    stream = Normals(generator(seed, "test"))
    return RateNoise(given, stream, since_power_on_s=since_power_on_s, start_s=start_s)


def allan_deviations(rates: NDArray[np.float64], groups: Sequence[int]) -> NDArray[np.float64]:
    deviations = []
    for m in groups:
        means = rates[: rates.size // m * m].reshape(-1, m).mean(axis=1)
        deviations.append(math.sqrt(0.5 * np.mean(np.diff(means) ** 2)))
    return np.array(deviations)


def test_angle_random_walk_falls_as_one_over_root_tau() -> None:
    rates = noise(densities(n=0.02)).means(0.0, 1.0, 1.0, 200_000)
    taus = [1, 4, 16, 64]
    # 3125 groups at the longest: 1.3 % standard error. The pole at 50 Hz takes 0.3 % at 1 s.
    assert allan_deviations(rates, taus) == pytest.approx(0.02 / np.sqrt(taus), rel=0.05)


def test_bias_instability_is_flat_at_its_coefficient_times_0_664() -> None:
    variances = [
        allan_deviations(
            noise(densities(b=0.01), seed=seed).means(0.0, 1.0, 1.0, 100_000), [1, 10, 100, 1000]
        )
        ** 2
        for seed in range(8)
    ]
    plateau = math.sqrt(2.0 * math.log(2.0) / math.pi) * 0.01
    assert np.sqrt(np.mean(variances, axis=0)) == pytest.approx(np.full(4, plateau), rel=0.06)


def test_rate_random_walk_rises_as_root_tau() -> None:
    rates = noise(densities(k=1e-4)).means(0.0, 1.0, 1.0, 200_000)
    taus = [4, 16, 64]
    assert allan_deviations(rates, taus) == pytest.approx(1e-4 * np.sqrt(np.array(taus) / 3.0), rel=0.06)


def test_white_noise_is_limited_by_the_bandwidth_at_short_apertures() -> None:
    rates = noise(densities(n=0.02, bandwidth=10.0)).means(0.0, 1e-4, 1.0, 40_000)
    # One pole at f_b turns the density 2N² into the variance π f_b N².
    assert rates.var() == pytest.approx(math.pi * 10.0 * 0.02**2, rel=0.04)


def test_a_long_aperture_is_the_mean_of_the_short_ones_that_make_it_up() -> None:
    given = densities(n=0.02, b=0.05, k=1e-3, bandwidth=2.0)
    long = noise(given, seed=3).means(0.0, 0.4, 1.0, 40_000)
    short = noise(given, seed=4)
    parts = np.array([short.means(float(k), 0.1, 0.1, 4) for k in range(40_000)])
    # Differences, because the rate itself wanders off.
    expected = np.diff(parts.mean(axis=1)).var()
    assert np.diff(long).var() == pytest.approx(expected, rel=0.04)


def test_readings_with_dead_time_keep_the_correlation_of_the_process() -> None:
    tau_s = 1.0 / (2.0 * math.pi * 0.05)
    rates = noise(densities(n=1.0, bandwidth=0.05), since_power_on_s=1e3).means(0.0, 0.01, 2.0, 60_000)
    lagged = np.mean(rates[1:] * rates[:-1]) / np.mean(rates**2)
    assert lagged == pytest.approx(math.exp(-2.0 / tau_s), abs=0.02)


def test_one_at_a_time_gives_the_same_record_as_all_at_once() -> None:
    given = densities(n=0.02, b=0.01, k=1e-4)
    one_by_one, at_once = noise(given), noise(given)
    singles = np.array([one_by_one.mean(5.0 + 0.5 * k, 0.2) for k in range(3000)])
    assert at_once.means(5.0, 0.2, 0.5, 3000) == pytest.approx(singles, rel=1e-9, abs=1e-12)
    assert at_once.mean(2000.0, 0.2) == pytest.approx(one_by_one.mean(2000.0, 0.2), rel=1e-9)


def test_all_noise_is_zero_at_power_on() -> None:
    given = densities(n=0.02, b=0.01, k=1e-4)
    first = [noise(given, seed=seed).mean(0.0, 1e-9) for seed in range(50)]
    # 0.25 deg/s of white noise once it has settled.
    assert np.abs(first).max() < 1e-3


def test_the_random_walk_has_grown_since_power_on() -> None:
    first = [
        noise(densities(k=0.01), seed=seed, since_power_on_s=400.0, start_s=7.0).mean(7.0, 1e-6)
        for seed in range(2000)
    ]
    assert np.std(first) == pytest.approx(0.01 * math.sqrt(400.0), rel=0.07)


def test_flicker_noise_grows_with_the_time_since_power_on() -> None:
    def spread(since_power_on_s: float) -> float:
        return float(
            np.std(
                [
                    noise(densities(b=0.01), seed=seed, since_power_on_s=since_power_on_s).mean(
                        0.0, 1e-6
                    )
                    for seed in range(1500)
                ]
            )
        )

    # Each decade of time adds the variance B² ln(10)/π.
    added = spread(1e4) ** 2 - spread(1e2) ** 2
    assert added == pytest.approx(2.0 * math.log(10.0) / math.pi * 0.01**2, rel=0.35)


def test_no_noise_gives_zero() -> None:
    assert not noise(densities()).means(0.0, 0.1, 0.2, 100).any()


def test_an_aperture_that_overlaps_the_last_one_is_refused() -> None:
    source = noise(densities(n=0.1))
    source.mean(0.0, 1.0)
    with pytest.raises(ValueError, match="after the last one"):
        source.mean(0.5, 1.0)


def test_very_short_steps_neither_cancel_nor_fail() -> None:
    rates = noise(densities(n=0.02, b=0.01, k=1e-4)).means(0.0, 1e-5, 2e-5, 5000)
    assert np.isfinite(rates).all()
    # Within a fiftieth of the pole's time constant the rate hardly moves.
    assert np.diff(rates).std() < 0.2 * math.sqrt(math.pi * 50.0) * 0.02
