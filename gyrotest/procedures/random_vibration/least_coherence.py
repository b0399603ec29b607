"""The least coherence of a band, with an interval that allows for its being the least of many."""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gyrotest.analysis.interval import coverage_factor

_TAIL = 0.025


@dataclass(frozen=True, slots=True, kw_only=True)
class LeastCoherence:
    """The least coherence γ² that was found, and the 95 % interval of the least true one."""

    value: float
    lower_95: float
    upper_95: float


def least_coherence(coherence: NDArray[np.float64], *, averages: float) -> LeastCoherence:
    """Return the least of coherences γ² (k,), each from so many independent averages.

    artanh γ is nearly normal with the variance 1/(2(L − 1)) (Enochson and Goodman 1965). The lower end fails
    only where the one line whose true coherence is least is found too large by more than its own; the upper
    end where any line is found too small, so that the tail is shared out among them (Šidák).
    """
    deviation = math.sqrt(1.0 / (2.0 * max(averages - 1.0, 1.0)))
    each = 1.0 - (1.0 - _TAIL) ** (1.0 / coherence.size)
    least = float(coherence.min())
    place = math.atanh(min(math.sqrt(least), 1.0 - 1e-15))
    low = place - coverage_factor(math.inf, coverage=1.0 - 2.0 * _TAIL) * deviation
    high = place + coverage_factor(math.inf, coverage=1.0 - 2.0 * each) * deviation
    return LeastCoherence(
        value=least, lower_95=math.tanh(max(low, 0.0)) ** 2, upper_95=math.tanh(high) ** 2
    )


def coherence_text(value: float) -> str:
    """Return a coherence with the first two digits by which it is less than 1."""
    return f"{value:.{min(max(1 - math.floor(math.log10(max(1.0 - value, 1e-9))), 2), 9)}f}"
