"""The noise terms of a gyro: their Allan variance and spectrum in a sampled record.

A record has one sample every `interval_s`, each the mean over `aperture_s` of it. Where the
aperture fills the interval the Allan variances are the textbook ones; where it does not, what lies
above half the sampling rate folds back and adds at short averaging times.
All is per unit of the squared coefficient; columns stand for Q (quantization noise), N (angle random
walk), B (bias instability coefficient), K (rate random walk) and R (rate ramp), in that order.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

FLICKER = 2.0 * np.log(2.0) / np.pi
"""Allan variance of flicker noise over B²."""

_EXACT_FACTORS = 64
_LEAST_FOLDS, _MOST_FOLDS = 12, 400


@dataclass(frozen=True, slots=True, kw_only=True)
class Grid:
    """How a record is sampled."""

    interval_s: float
    aperture_s: float


def allan_columns(averaging_factors: NDArray[np.int64], grid: Grid) -> NDArray[np.float64]:
    """Allan variance of each term, shape (k, 5).

    N is the apparent one, as the record shows it: dead time is taken out of it afterwards.
    """
    m = averaging_factors.astype(np.float64)
    tau = m * grid.interval_s
    dead = grid.interval_s - grid.aperture_s
    flicker = FLICKER + _folded_flicker(averaging_factors, grid)
    # A random walk averaged over the aperture: D(τ) = K²(τ − a/3) is its structure function.
    walk = tau / 3.0 + dead / (6.0 * m)
    return np.column_stack((3.0 / tau**2, 1.0 / tau, flicker, walk, tau**2 / 2.0))


def _folded_flicker(averaging_factors: NDArray[np.int64], grid: Grid) -> NDArray[np.float64]:
    """Return what dead time adds to flicker: exact at first, then falling as 1/m like white noise."""
    if grid.aperture_s >= grid.interval_s * (1.0 - 1e-9):
        return np.zeros(averaging_factors.size)
    capped = np.minimum(averaging_factors, _EXACT_FACTORS)
    exact = {int(m): _flicker_variance(int(m), grid) - FLICKER for m in np.unique(capped)}
    return np.array([exact[int(c)] * c / m for c, m in zip(capped, averaging_factors, strict=True)])


def _flicker_variance(m: int, grid: Grid) -> float:
    """Compute ½ΣΣ c_i c_j C((i − j)p), C(t) = −ln|t|/π averaged over two apertures."""
    lag = np.arange(2 * m, dtype=np.float64)
    contrast = (2.0 * _tent(lag, m) - _tent(lag - m, m) - _tent(lag + m, m)) / m**2
    contrast[1:] *= 2.0
    a, t = grid.aperture_s, lag * grid.interval_s
    covariance = -(
        _twice_integrated_log(t + a) - 2.0 * _twice_integrated_log(t) + _twice_integrated_log(t - a)
    )
    return float(np.sum(contrast * covariance)) / (2.0 * np.pi * a**2)


def _tent(lag: NDArray[np.float64], m: int) -> NDArray[np.float64]:
    tent: NDArray[np.float64] = np.maximum(m - np.abs(lag), 0.0)
    return tent


def _twice_integrated_log(t: NDArray[np.float64]) -> NDArray[np.float64]:
    size = np.abs(t)
    integral: NDArray[np.float64] = 0.5 * t**2 * np.log(np.where(size > 0.0, size, 1.0)) - 0.75 * t**2
    return integral


def spectrum_columns(frequency_hz: NDArray[np.float64], grid: Grid) -> NDArray[np.float64]:
    """One-sided spectral density of the samples, shape (k, 5), for 0 < f ≤ 1/(2·interval).

    A ramp has none: it is no noise.
    """
    p, a = grid.interval_s, grid.aperture_s
    white = np.full(frequency_hz.size, 2.0)
    folded = np.zeros(frequency_hz.size)
    # As far as an aperture passes anything.
    folds = int(min(max(np.ceil(2.0 * p / a), _LEAST_FOLDS), _MOST_FOLDS))
    for fold in range(-folds, folds + 1):
        f = np.abs(frequency_hz + fold / p)
        folded += np.sinc(f * a) ** 2 / (np.pi * f)
    cosine = np.cos(2.0 * np.pi * frequency_hz * p)
    walk = 2.0 * p * (p - a / 3.0 * (1.0 - cosine)) / (2.0 * (1.0 - cosine))
    quantization = 4.0 * (1.0 - cosine) / p
    return np.column_stack((quantization, white, folded, walk, np.zeros(frequency_hz.size)))


def allan_response(
    frequency_hz: NDArray[np.float64], averaging_factors: NDArray[np.int64], grid: Grid
) -> NDArray[np.float64]:
    """Weight of the samples' spectrum in each Allan variance, shape (averaging factors, frequencies)."""
    phase = np.pi * frequency_hz * grid.interval_s
    m = averaging_factors.astype(np.float64)[:, np.newaxis]
    response: NDArray[np.float64] = 2.0 * np.sin(m * phase) ** 4 / (m * np.sin(phase)) ** 2
    return response


def momentary_flicker_excess(frequency_hz: NDArray[np.float64], grid: Grid) -> NDArray[np.float64]:
    """Return by how much the spectrum (k,) of flicker noise per B² rises where samples are momentary values.

    Of the sampled process with the spectrum 1/(2·|sin πfp|)·2p, whose filter is (1 − z⁻¹)^(−1/2):
    N. J. Kasdin, Proc. IEEE 83, 802, 1995. 0 where dead time is known: then the samples are means.
    """
    p = grid.interval_s
    if grid.aperture_s < p * (1.0 - 1e-9):
        return np.zeros(frequency_hz.size)
    averaged = spectrum_columns(frequency_hz, grid)[:, 2]
    excess: NDArray[np.float64] = p / np.sin(np.pi * frequency_hz * p) - averaged
    return excess


def momentary_walk_excess(averaging_factors: NDArray[np.int64], grid: Grid) -> NDArray[np.float64]:
    """Return by how much the Allan variance (k,) of a walk per K² rises where samples are momentary values."""
    if grid.aperture_s < grid.interval_s * (1.0 - 1e-9):
        return np.zeros(averaging_factors.size)
    return np.asarray(grid.interval_s / (6.0 * averaging_factors), dtype=np.float64)
