"""The spread of a quantity over repeated measurements, each of which has noise of its own."""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from gyrotest.analysis.interval import deviation_bounds
from gyrotest.errors import InsufficientDataError

_FEWEST = 2


@dataclass(frozen=True, slots=True, kw_only=True)
class Repeatability:
    """Mean and sample standard deviation of `count` values, in their unit.

    `lower_95` … `upper_95` hold the spread of what was measured; `noise` is the rms of the values' own
    standard uncertainties, which the deviation contains.
    """

    count: int
    mean: float
    deviation: float
    lower_95: float
    upper_95: float
    noise: float

    @property
    def mean_uncertainty(self) -> float:
        """Standard uncertainty of the mean by the scatter alone."""
        return self.deviation / math.sqrt(self.count)


def repeatability(values: ArrayLike, *, uncertainties: ArrayLike = 0.0) -> Repeatability:
    """Compute the sample standard deviation (n − 1) with the 95 % interval of the underlying spread.

    Parameters
    ----------
    values
        Shape (n,): one value a repeat.
    uncertainties
        Shape (n,) or scalar: each value's own standard uncertainty by its noise, in the same unit;
        none of what is common to all repeats.

    Raises
    ------
    InsufficientDataError
        Fewer than two values, or one that is not finite.

    Notes
    -----
    S3.6 and NIST SP 1065 eq. 45. The expectation of s² is σ² + ū², with σ the spread of the quantity
    itself and ū the rms of the values' own uncertainties. s is given as it is, ū not subtracted; the
    interval's lower end is √(L² − ū²), with L that of s, or 0, and its upper end that of s, so that it
    holds σ whether or not the uncertainties are estimated too large.
    """
    found = np.asarray(values, dtype=np.float64)
    if found.size < _FEWEST:
        raise InsufficientDataError(f"{found.size} values have no spread; {_FEWEST} are needed")
    if not np.isfinite(found).all():
        raise InsufficientDataError(f"{np.count_nonzero(~np.isfinite(found))} values are not finite")
    deviation = float(found.std(ddof=1))
    bounds = deviation_bounds(deviation, found.size - 1, confidence=0.95)
    noise = math.sqrt(float(np.mean(np.square(np.asarray(uncertainties, dtype=np.float64)))))
    return Repeatability(
        count=found.size,
        mean=float(found.mean()),
        deviation=deviation,
        lower_95=math.sqrt(max(float(bounds.lower) ** 2 - noise**2, 0.0)),
        upper_95=float(bounds.upper),
        noise=noise,
    )
