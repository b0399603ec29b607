"""Records of known noise for benchmarks: long ones, fast."""

import numpy as np
from numpy.typing import NDArray

DPH = 1.0 / 3600.0


def noise_record(
    samples: int,
    *,
    interval_s: float,
    seed: int,
    quantization_noise: float = 0.0,
    angle_random_walk: float = 0.0,
    bias_instability: float = 0.0,
    rate_random_walk: float = 0.0,
    rate_ramp: float = 0.0,
) -> NDArray[np.float64]:
    """Q in °, N in °/√s, B in °/s, K in °/s/√s, R in °/s².

    Flicker noise is white noise through (1 − z⁻¹)^(−1/2) (N. J. Kasdin, Proc. IEEE 83, 802, 1995),
    which has run for the record's length before it begins.
    """
    random = np.random.default_rng(seed)
    rate = random.standard_normal(samples) * (angle_random_walk / np.sqrt(interval_s))
    if bias_instability:
        rate += bias_instability * _flicker(samples, random)
    if rate_random_walk:
        steps = random.standard_normal(samples)
        rate += rate_random_walk * np.sqrt(interval_s) * np.cumsum(steps)
    if quantization_noise:
        rate += quantization_noise / interval_s * np.diff(random.standard_normal(samples + 1))
    if rate_ramp:
        rate += rate_ramp * interval_s * np.arange(samples)
    return rate


def _flicker(samples: int, random: np.random.Generator) -> NDArray[np.float64]:
    count = 2 * samples
    lag = np.arange(1, count)
    response = np.append(1.0, np.cumprod((lag - 0.5) / lag))
    size = 1 << (2 * count - 1).bit_length()
    spectrum = np.fft.rfft(response, size) * np.fft.rfft(random.standard_normal(count), size)
    whole: NDArray[np.float64] = np.fft.irfft(spectrum, size)
    return whole[samples:count]
