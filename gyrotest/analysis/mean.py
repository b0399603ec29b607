"""The mean of a record and how well it stands for the gyro's bias."""

from dataclasses import dataclass

import numpy as np

from gyrotest.analysis.noise_model import NoiseModel
from gyrotest.analysis.noise_terms import FLICKER

_FEWEST_FREEDOM = 5.0
"""Fewer would count the doubt about K twice: it is in the prudent K² already."""


@dataclass(frozen=True, slots=True, kw_only=True)
class MeanUncertainty:
    """Standard uncertainty of a mean, °/s, and the degrees of freedom with which it is known."""

    standard_uncertainty_dps: float
    degrees_of_freedom: float


def mean_uncertainty(
    model: NoiseModel, *, duration_s: float, since_power_on_s: float = 0.0
) -> MeanUncertainty:
    """Estimate the uncertainty of the mean over a record by its Allan deviation carried to its length.

    Parameters
    ----------
    model
        The record's noise.
    duration_s
        The record's length T.
    since_power_on_s
        Time t₀ from power-on to the record, over which the rate random walk has walked already.

    Notes
    -----
    u² = 3Q²/T² + N²/T + (2 ln 2/π)·B² + K²·(T/3 + t₀) + D²/12. N²/T and K²T/3 are at once the Allan
    variances at T and the variances of the mean about the bias at the record's begin; D/√12 is how a
    drift that changes the rate by D spreads over the record; s/√n would count samples that are not
    independent. The degrees of freedom are 2u⁴ over the variance of u² that the noise terms have.
    """
    walk = duration_s / 3.0 + since_power_on_s
    gradient = np.array([3.0 / duration_s**2, 1.0 / duration_s, FLICKER, walk, 0.0])
    drift = 0.0 if model.drift is None else model.drift.change_dps**2 / 12.0
    variance = float(gradient @ model.prudent_squares) + drift
    spread = float(gradient @ model.covariance @ gradient)
    return MeanUncertainty(
        standard_uncertainty_dps=float(np.sqrt(variance)),
        degrees_of_freedom=max(2.0 * variance**2 / spread, _FEWEST_FREEDOM),
    )
