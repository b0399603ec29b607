"""Intervals: chi-square bounds of a deviation and Student's factor for an expanded uncertainty."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

ONE_SIGMA = 0.6826894921370859
NORMAL_95 = 1.959963984540054


@dataclass(frozen=True, slots=True, kw_only=True)
class Bounds:
    """Lower and upper bounds, in the unit of what they bound; the arrays are read-only."""

    lower: NDArray[np.float64]
    upper: NDArray[np.float64]


def deviation_bounds(
    deviation: ArrayLike, degrees_of_freedom: ArrayLike, *, confidence: float
) -> Bounds:
    """Bound a standard or Allan deviation whose variance is chi-square distributed.

    Parameters
    ----------
    deviation, degrees_of_freedom
        Arrays of the same shape (or scalars); the bounds have the deviation's unit.
    confidence
        Two-sided coverage, between 0 and 1; the tails are equal.

    Raises
    ------
    ValueError
        The confidence is not between 0 and 1.

    Notes
    -----
    NIST SP 1065 eq. 45: s²·ν/χ²(1 − q) ≤ σ² ≤ s²·ν/χ²(q), q = (1 − confidence)/2.
    """
    from scipy.special import chdtri

    if not 0.0 < confidence < 1.0:
        raise ValueError(f"a confidence lies between 0 and 1, e.g. 0.95, found {confidence!r}")
    values = np.asarray(deviation, dtype=np.float64)
    nu = np.asarray(degrees_of_freedom, dtype=np.float64)
    tail = (1.0 - confidence) / 2.0
    lower = values * np.sqrt(nu / chdtri(nu, tail))
    upper = values * np.sqrt(nu / chdtri(nu, 1.0 - tail))
    lower.setflags(write=False)
    upper.setflags(write=False)
    return Bounds(lower=lower, upper=upper)


def coverage_factor(degrees_of_freedom: float, *, coverage: float = 0.9545) -> float:
    """Return Student's t for a coverage at effective degrees of freedom (GUM, JCGM 100 G.3.2; inf: normal)."""
    from scipy.special import ndtri, stdtrit

    probability = (1.0 + coverage) / 2.0
    if not np.isfinite(degrees_of_freedom):
        return float(ndtri(probability))
    return float(stdtrit(max(degrees_of_freedom, 1.0), probability))


def chi_square_quantile(probability: float, degrees_of_freedom: float) -> float:
    """Return the value below which a chi-square variable lies with a probability."""
    from scipy.special import chdtri

    return float(chdtri(degrees_of_freedom, 1.0 - probability))
