"""Bias stability by smoothing: the standard deviation of averages over a stated time."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gyrotest.analysis.interval import deviation_bounds
from gyrotest.analysis.noise_model import NoiseModel
from gyrotest.analysis.noise_terms import Grid, spectrum_columns
from gyrotest.errors import InsufficientDataError

_EXACT_MODES = 4096
_THINNED_MODES = 4096


@dataclass(frozen=True, slots=True, kw_only=True)
class SmoothedDeviation:
    """Sample standard deviation of averages, its 95 % interval and its degrees of freedom."""

    smoothing_s: float
    deviation_dps: float
    lower_95_dps: float
    upper_95_dps: float
    averages: int
    edf: float


def smoothed_deviation(
    rate_dps: NDArray[np.float64], *, samples_per_average: int, model: NoiseModel
) -> SmoothedDeviation:
    """Compute the standard deviation (n − 1) of averages side by side, its interval by the noise model.

    Parameters
    ----------
    rate_dps
        Shape (n,), °/s. A tail shorter than an average is dropped.
    samples_per_average
        Whole number of samples in an average.
    model
        The record's noise: the averages of a wandering rate are no independent draws, so that
        n − 1 would promise too narrow an interval.

    Raises
    ------
    InsufficientDataError
        Fewer than two averages.
    """
    count = rate_dps.size // samples_per_average
    if count < 2:
        raise InsufficientDataError(
            f"{rate_dps.size} samples give {count} averages of {samples_per_average}; 2 are needed"
        )
    averages = rate_dps[: count * samples_per_average].reshape(count, samples_per_average).mean(axis=1)
    deviation = float(averages.std(ddof=1))
    smoothing_s = samples_per_average * model.grid.interval_s
    edf = smoothed_edf(count, smoothing_s=smoothing_s, squares=model.prudent_squares)
    bounds = deviation_bounds(deviation, edf, confidence=0.95)
    return SmoothedDeviation(
        smoothing_s=smoothing_s,
        deviation_dps=deviation,
        lower_95_dps=float(bounds.lower),
        upper_95_dps=float(bounds.upper),
        averages=count,
        edf=edf,
    )


def smoothed_edf(count: int, *, smoothing_s: float, squares: NDArray[np.float64]) -> float:
    """Return the degrees of freedom (Σλ)²/Σλ² of the sample variance of `count` averages.

    The eigenvalues λ of the averages' covariance, their mean removed, are taken as the averages'
    spectrum at f_k = k/(2·count·T), k = 1 … count − 1: exact for white noise, and for a random walk
    (whose modes are the discrete cosines).
    """
    modes, weights = _modes(count)
    grid = Grid(interval_s=smoothing_s, aperture_s=smoothing_s)
    power = spectrum_columns(modes / (2.0 * count * smoothing_s), grid) @ squares
    total, square = float(np.sum(weights * power)), float(np.sum(weights * power**2))
    return total**2 / square


def _modes(count: int) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return mode numbers and how many modes each stands for: all of the first ones, then log-spaced runs."""
    if count - 1 <= 2 * _EXACT_MODES:
        return np.arange(1, count, dtype=np.float64), np.ones(count - 1)
    first = np.arange(1, _EXACT_MODES, dtype=np.float64)
    edges = np.unique(np.rint(np.geomspace(_EXACT_MODES, count, _THINNED_MODES)))
    middle = (edges[1:] + edges[:-1] - 1.0) / 2.0
    return np.concatenate((first, middle)), np.concatenate((np.ones(first.size), np.diff(edges)))
