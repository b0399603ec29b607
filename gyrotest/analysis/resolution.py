"""Resolution: the steps in which a record is digitised, and how far they move its mean."""

import math

import numpy as np
from numpy.typing import NDArray

_LOOKED_AT = 65536
_SAME = 1e-9
_HARMONICS = 16


def digital_step(values: NDArray[np.float64]) -> float | None:
    """Return the step between neighbouring values of a record whose values repeat; None of one that is fine.

    Looked for in the first 65,536 samples, where at least half of them repeat another.
    """
    looked_at = values[:_LOOKED_AT]
    levels = np.unique(looked_at)
    if levels.size < 2 or 2 * levels.size > looked_at.size:
        return None
    steps = np.diff(levels)
    return float(steps[steps > _SAME * (levels[-1] - levels[0])].min())


def mean_half_width(step: float, deviation: float) -> float:
    """Return how far steps can move the mean of a record of a standard deviation, in the step's unit.

    Notes
    -----
    Half a step without noise (JCGM 100 F.2.2.1); normal noise dithers the steps, which leaves
    no more than step/π · Σ exp(−2π²(k·deviation/step)²)/k: next to nothing from half a step of noise on.
    """
    order = np.arange(1.0, _HARMONICS + 1.0)
    terms = np.exp(-2.0 * (math.pi * order * deviation / step) ** 2) / order
    return min(step / 2.0, step / math.pi * float(terms.sum()))
