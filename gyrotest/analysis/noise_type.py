"""Noise type: which power law rules a record at an averaging time, by its lag-1 autocorrelation."""

from enum import IntEnum

import numpy as np
from numpy.typing import NDArray

from gyrotest.analysis.kernels.lag import COLUMNS, SHORTEST, add_averages, identify


class NoiseType(IntEnum):
    """A power law of the rate's spectrum; the value is its exponent of frequency."""

    QUANTIZATION = 2
    ANGLE_FLICKER = 1
    ANGLE_RANDOM_WALK = 0
    BIAS_INSTABILITY = -1
    RATE_RANDOM_WALK = -2


def noise_types(angle: NDArray[np.float64], averaging_factors: NDArray[np.int64]) -> NDArray[np.int8]:
    """Identify the dominant noise type at each averaging factor.

    Parameters
    ----------
    angle
        Shape (n + 1,): the running sum of the rate record.
    averaging_factors
        Shape (k,), ascending. Where fewer than 30 averages remain, the type of the next shorter time
        stands.

    Returns
    -------
    ndarray
        Shape (k,): values of `NoiseType`.

    Notes
    -----
    W. J. Riley and C. A. Greenhall, "Power law noise identification using the lag 1
    autocorrelation", 18th EFTF, 2004. A longer record is taken in pieces of 65,536 averages.
    """
    enough = identifiable(averaging_factors, angle.size - 1)
    rows = np.zeros((enough.size, COLUMNS))
    add_averages(np.ascontiguousarray(angle), 0, 0, angle.size - 1, enough, rows)
    return types_at(averaging_factors, enough, rows)


def identifiable(factors: NDArray[np.int64], samples: int) -> NDArray[np.int64]:
    """Return the ascending factors that leave enough averages for an identification."""
    return factors[samples // factors >= SHORTEST]


def types_at(
    averaging_factors: NDArray[np.int64], identified: NDArray[np.int64], rows: NDArray[np.float64]
) -> NDArray[np.int8]:
    """Read the noise types off the sums over averages of the identified factors, which it uses up.

    A factor takes the type of the longest identified one that is not longer than itself.
    """
    exponents = np.zeros(identified.size)
    identify(rows, exponents)
    known = np.concatenate(([NoiseType.ANGLE_RANDOM_WALK], exponents.astype(np.int8)))
    places = np.searchsorted(identified, averaging_factors, side="right")
    types: NDArray[np.int8] = known[places].astype(np.int8)
    return types
