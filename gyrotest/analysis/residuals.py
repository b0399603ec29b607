"""The size of residuals that have errors of their own: their rms with an interval that holds."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from gyrotest.analysis.interval import chi_square_quantile
from gyrotest.errors import InsufficientDataError

_UPPER = 0.95


@dataclass(frozen=True, slots=True, kw_only=True)
class RootMeanSquare:
    """The rms of residuals with a 95 % interval of that of the true ones, and the rms of their errors."""

    value: float
    lower_95: float
    upper_95: float
    error: float


def root_mean_square(residuals: ArrayLike, *, covariance: NDArray[np.float64]) -> RootMeanSquare:
    """Compute the rms of residuals that are known with errors.

    Parameters
    ----------
    residuals
        Shape (n,), any unit.
    covariance
        Shape (n, n): covariance of the residuals' errors, the square of their unit.

    Raises
    ------
    InsufficientDataError
        No residual, or one that is not finite.

    Notes
    -----
    The rms is a length, so that it differs from the true residuals' by no more than the rms ε of the
    errors (triangle inequality). The interval is the rms ± the 95 % quantile of ε, ε² being taken as
    chi-square with the degrees of freedom (tr V)²/tr V² about its mean tr V/n (Satterthwaite). That is
    wider than needed where the errors are independent and small, and holds where the residuals are nothing
    but errors.
    """
    found = np.asarray(residuals, dtype=np.float64)
    if not found.size or not np.isfinite(found).all():
        raise InsufficientDataError(f"{found.size} residuals, or one that is not finite")
    value = float(np.sqrt(np.mean(found**2)))
    trace, square = float(np.trace(covariance)), float(np.sum(covariance**2))
    if square <= 0.0:
        return RootMeanSquare(value=value, lower_95=value, upper_95=value, error=0.0)
    freedom = trace**2 / square
    mean = trace / found.size
    largest = float(np.sqrt(mean * chi_square_quantile(_UPPER, freedom) / freedom))
    return RootMeanSquare(
        value=value,
        lower_95=max(value - largest, 0.0),
        upper_95=value + largest,
        error=float(np.sqrt(mean)),
    )
