"""What a simulated meter reads."""

from typing import Protocol

import numpy as np
from numpy.typing import NDArray


class Signal(Protocol):
    """What a meter reads: the mean voltage over apertures, asked for in the order of time."""

    def mean_voltage(self, start_s: float, aperture_s: float) -> float:
        """The mean over one aperture, V."""

    def mean_voltages(
        self, start_s: float, aperture_s: float, spacing_s: float, count: int
    ) -> NDArray[np.float64]:
        """The means over `count` apertures that begin every `spacing_s`, (count,), V."""
