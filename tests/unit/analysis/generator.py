"""Gyro noise of known coefficients, each sample the exact mean of the process over its interval."""

import numpy as np
from numpy.typing import NDArray
from scipy.signal import lfilter

DPH = 1.0 / 3600.0


def gyro_noise(
    samples: int,
    *,
    interval_s: float = 1.0,
    angle_random_walk: float = 0.0,
    bias_instability: float = 0.0,
    rate_random_walk: float = 0.0,
    since_power_on_s: float = 0.0,
    seed: int = 1,
) -> NDArray[np.float64]:
    """N in °/√s, B in °/s, K in °/s/√s; every process starts at zero at power-on."""
    random = np.random.default_rng(seed)
    before = round(since_power_on_s / interval_s)
    count = before + samples
    rate = random.standard_normal(count) * angle_random_walk / np.sqrt(interval_s)
    rate += _walk(count, interval_s, rate_random_walk, random)
    if bias_instability:
        rate += _flicker(count, interval_s, bias_instability, random)
    return rate[before:]


def _walk(
    count: int, interval_s: float, coefficient: float, random: np.random.Generator
) -> NDArray[np.float64]:
    steps = random.standard_normal((2, count)) * np.sqrt(interval_s)
    begin = np.concatenate(([0.0], np.cumsum(steps[0])[:-1]))
    return coefficient * (begin + steps[0] / 2.0 + steps[1] / np.sqrt(12.0))


def _flicker(
    count: int, interval_s: float, coefficient: float, random: np.random.Generator
) -> NDArray[np.float64]:
    """Two Ornstein–Uhlenbeck processes a decade of corner times, of equal variance B² ln(ratio)/π."""
    longest = 30.0 * count * interval_s
    number = round(2.0 * np.log10(30.0 * longest / interval_s)) + 1
    corners = np.geomspace(interval_s / 30.0, longest, number)
    variance = coefficient**2 * np.log(corners[1] / corners[0]) / np.pi
    total = np.zeros(count)
    for corner in corners:
        total += _averaged_process(count, interval_s, float(corner), variance, random)
    return total


def _averaged_process(
    count: int, interval_s: float, corner_s: float, variance: float, random: np.random.Generator
) -> NDArray[np.float64]:
    steps = interval_s / corner_s
    decay = np.exp(-steps)
    drive = np.sqrt(-variance * np.expm1(-2.0 * steps)) * random.standard_normal(count)
    end = lfilter([1.0], [1.0, -decay], drive)
    begin = np.concatenate(([0.0], end[:-1]))
    share = -np.expm1(-steps) / steps / (1.0 + decay)
    mean = 2.0 * variance * (steps + np.expm1(-steps)) / steps**2
    rest = max(mean - 2.0 * variance * (1.0 + decay) * share**2, 0.0)
    return share * (begin + end) + np.sqrt(rest) * random.standard_normal(count)
