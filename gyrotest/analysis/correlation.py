"""How long a record remembers: the time over which its samples count as one."""

import numpy as np
from numpy.typing import NDArray

from gyrotest.errors import InsufficientDataError

_FEWEST = 4


def correlation_time(values: NDArray[np.float64]) -> float:
    """Estimate the integrated correlation time of a record, in samples, at least 1.

    Parameters
    ----------
    values
        Shape (n,), evenly spaced or nearly so; their mean is taken off.

    Raises
    ------
    InsufficientDataError
        Fewer than four values.

    Notes
    -----
    τ = 1 + 2·Σρ_k, summed while the sums of two neighbouring autocorrelations are positive (the initial
    positive sequence of Geyer, 1992), so that the noise of far lags stays out. The mean of n samples of
    standard deviation s has the standard uncertainty s·√(τ/n). 1 of white noise, and where neighbours
    oppose each other: to count more samples than there are would need more trust in the estimate.
    """
    if values.size < _FEWEST:
        raise InsufficientDataError(
            f"{values.size} samples are too few for a correlation time; {_FEWEST} are needed"
        )
    autocovariance = _autocovariance(values)
    if autocovariance[0] <= 0.0:
        return 1.0
    pairs = autocovariance[1:-1:2] + autocovariance[2::2]
    negative = np.flatnonzero(pairs <= 0.0)
    used = pairs[: int(negative[0])] if negative.size else pairs
    return max(1.0 + 2.0 * float(used.sum() / autocovariance[0]), 1.0)


def _autocovariance(values: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the biased autocovariances of lags 0 … n/2, by way of the power spectrum."""
    from scipy.fft import irfft, next_fast_len, rfft

    centred = values - values.mean()
    size = int(next_fast_len(2 * values.size, real=True))
    power = np.abs(rfft(centred, size)) ** 2
    half = values.size // 2 // 2 * 2 + 1
    return np.asarray(irfft(power, size)[:half] / values.size, dtype=np.float64)
