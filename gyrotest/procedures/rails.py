"""Samples that stand at a limit of the output: a rail."""

import numpy as np
from numpy.typing import NDArray

from gyrotest.analysis.resolution import digital_step

_FEWEST = 5
_FEWEST_LEVELS = 3
_SIGMAS = 4.0


def rail_of(values: NDArray[np.float64]) -> NDArray[np.bool_]:
    """Return which samples (n,) stand at a limit of the output: pile up at the greatest or least value.

    Of a finely resolved output the same value never comes back five times by chance, least of all the
    extreme one. Of a coarsely digitised one the extreme value is rarer than its neighbour, unless what
    lies beyond was cut off. A constant output stands at its limit, or is stuck, wherever it is.
    """
    if not values.size:
        return np.zeros(0, dtype=np.bool_)
    lowest: NDArray[np.bool_] = values == values.min()
    highest: NDArray[np.bool_] = values == values.max()
    if lowest.all():
        return lowest
    step = digital_step(values)
    railed = np.zeros(values.size, dtype=np.bool_)
    for extreme, sign in ((lowest, 1.0), (highest, -1.0)):
        if _piles_up(values, extreme, None if step is None else sign * step):
            railed |= extreme
    return railed


def _piles_up(values: NDArray[np.float64], extreme: NDArray[np.bool_], inward: float | None) -> bool:
    count = int(extreme.sum())
    if count < _FEWEST:
        return False
    if inward is None:
        return True
    if np.unique(values).size < _FEWEST_LEVELS:
        return False
    end = float(values[extreme][0])
    beside = int((np.abs(values - end - inward) < 0.5 * abs(inward)).sum())
    return count > beside + _SIGMAS * float(np.sqrt(count + beside))
