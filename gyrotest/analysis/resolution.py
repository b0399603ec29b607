"""Resolution: the steps in which a record is digitised, and how far they move its mean."""

import math

import numpy as np
from numpy.typing import NDArray

_LOOKED_AT = 65536
_SAME = 1e-9


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
    """Return how far steps can move the mean of a record, in the step's unit.

    Parameters
    ----------
    step, deviation
        What the record is digitised in, and its standard deviation as digitised.

    Notes
    -----
    Half a step where the record varies by less than that: samples on two neighbouring steps do not
    tell where between them the rate is (JCGM 100 F.2.2.1 for none at all). Beyond, noise of
    σ² = deviation² − step²/12 dithers the steps, which leaves step/π · exp(−2π²(σ/step)²).
    """
    if deviation < step / 2.0:
        return step / 2.0
    noise_in_steps = (deviation / step) ** 2 - 1.0 / 12.0
    return step / math.pi * math.exp(-2.0 * math.pi**2 * noise_in_steps)
