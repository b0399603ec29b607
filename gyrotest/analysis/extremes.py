"""Intervals of magnitudes, which noise makes larger: of one difference, and of the largest of several."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gyrotest.analysis.interval import coverage_factor

_TAIL = 0.025


@dataclass(frozen=True, slots=True, kw_only=True)
class Magnitude:
    """A magnitude and its 95 % interval, whose lower end is 0 where it may be noise alone."""

    value: float
    lower_95: float
    upper_95: float


def magnitude(value: float, *, standard: float, freedom: float) -> Magnitude:
    """Return |value| of a normal value with its interval.

    |value| ± t·u, cut at 0: as a noisy value's magnitude differs from the true one by no more than the
    value itself does, it contains the truth at least as often, and just as often where that is 0.
    """
    half = coverage_factor(freedom, coverage=1.0 - 2.0 * _TAIL) * standard
    size = abs(value)
    return Magnitude(value=size, lower_95=max(size - half, 0.0), upper_95=size + half)


def largest_magnitude(
    values: NDArray[np.float64], *, standard: NDArray[np.float64], freedom: NDArray[np.float64]
) -> Magnitude:
    """Return max|values| with an interval that contains the largest true magnitude 95 times in a hundred.

    Parameters
    ----------
    values, standard, freedom
        Shape (n,): normal values, correlated as they may be, their standard uncertainties and degrees of
        freedom.

    Notes
    -----
    The largest of several noisy magnitudes is too large on average, and that of true zeros is not 0. The
    upper end, max(|v_i| + t·u_i), fails only where the one value whose true magnitude is largest errs by
    more than t·u: once in forty times. The lower end, max(|v_i| − t'·u_i), fails only where any of them
    errs by more, so that t' has the tail shared out (Šidák: 1 − (1 − 0.025)^(1/n)).
    """
    each = 1.0 - (1.0 - _TAIL) ** (1.0 / values.size)
    size = np.abs(values)
    above = np.array([coverage_factor(one, coverage=1.0 - 2.0 * _TAIL) for one in freedom])
    below = np.array([coverage_factor(one, coverage=1.0 - each) for one in freedom])
    return Magnitude(
        value=float(size.max()),
        lower_95=max(float((size - below * standard).max()), 0.0),
        upper_95=float((size + above * standard).max()),
    )
