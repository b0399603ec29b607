"""Many values drawn in few places: the lowest, the highest and the mean of consecutive runs."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gyrotest.procedures.drawn_units import Unit

MOST_BINS = 900
"""More places than a page can show apart."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Bins:
    """Lowest, highest and mean of consecutive runs of `size` values; the last run may be shorter."""

    size: int
    lowest: NDArray[np.float64]
    highest: NDArray[np.float64]
    mean: NDArray[np.float64]


def binned(values: NDArray[np.float64], size: int) -> Bins:
    """Reduce runs of `size` values; a last run that is shorter stands too."""
    starts = np.arange(0, values.size, size)
    counts = np.minimum(size, values.size - starts)
    return Bins(
        size=size,
        lowest=np.minimum.reduceat(values, starts),
        highest=np.maximum.reduceat(values, starts),
        mean=np.add.reduceat(values, starts) / counts,
    )


def drawn(values: NDArray[np.float64], unit: Unit) -> tuple[float, ...]:
    """Return values in the unit that they are drawn in."""
    return tuple((values * unit.factor).tolist())
