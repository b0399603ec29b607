"""Skew of channels: columns that one clock samples one after another, brought to one instant."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray


class Aligner:
    """Brings columns to the instants of the first one, block by block.

    Parameters
    ----------
    offsets_s
        How much later than the first column each one is sampled, s, the first among them (0).
    interval_s
        Time between two samples of a column, s.
    """

    def __init__(self, offsets_s: Sequence[float], interval_s: float) -> None:
        raise NotImplementedError

    @property
    def lost(self) -> int:
        """Samples at either end of a stretch that are not given back: row 0 given is row `lost` put in."""
        raise NotImplementedError

    def push(self, values: NDArray[np.float64]) -> NDArray[np.float64]:
        """Take rows (n, columns) and return those (m, columns) that are complete by now."""
        raise NotImplementedError

    def reset(self) -> None:
        """Begin a new stretch: what comes is not joined to what came before."""
        raise NotImplementedError
