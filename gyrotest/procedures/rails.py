"""Samples that stand at a limit of the output: a rail."""

import numpy as np
from numpy.typing import NDArray

from gyrotest.analysis.resolution import digital_step

_FEWEST = 5
_FEWEST_LEVELS = 3
_SIGMAS = 4.0


def rail_of(values: NDArray[np.float64], *, blur: float = 0.0) -> NDArray[np.bool_]:
    """Return which samples (n,) stand at a limit of the output: pile up at the greatest or least value.

    Of a finely resolved output the same value never comes back five times by chance, least of all the
    extreme one. Of a coarsely digitised one the extreme value is rarer than its neighbour, unless what
    lies beyond was cut off. A constant output stands at its limit, or is stuck, wherever it is. Where what
    reads the output adds noise of its own, values within `blur` of the extreme one count as it.
    """
    if not values.size:
        return np.zeros(0, dtype=np.bool_)
    lowest: NDArray[np.bool_] = values <= values.min() + blur
    highest: NDArray[np.bool_] = values >= values.max() - blur
    if lowest.all():
        return lowest
    step = digital_step(values)
    width = blur if step is None else max(step, blur)
    railed = np.zeros(values.size, dtype=np.bool_)
    for extreme, above in ((lowest, values - values.min()), (highest, values.max() - values)):
        if _piles_up(values, extreme, above, width, coarse=step is not None):
            railed |= extreme
    return railed


def _piles_up(
    values: NDArray[np.float64],
    extreme: NDArray[np.bool_],
    above: NDArray[np.float64],
    width: float,
    *,
    coarse: bool,
) -> bool:
    """Whether there are more at the extreme than in as wide a stretch beside it; `above` are distances to it."""
    count = int(extreme.sum())
    if count < _FEWEST:
        return False
    if coarse and np.unique(values).size < _FEWEST_LEVELS:
        return False
    beside = int((~extreme & (above <= float(above[extreme].max()) + 1.001 * width)).sum())
    return count > beside + _SIGMAS * float(np.sqrt(count + beside))
