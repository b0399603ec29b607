"""An encoder's signals in quadrature as an angle."""

import numpy as np
from numpy.typing import NDArray

from gyrotest.analysis.ellipse import Ellipse, EllipseFit

__all__ = ["Decoder", "Ellipse", "EllipseFit", "required_rate_hz"]


def required_rate_hz(fastest_dps: float, lines: int) -> float:
    """Return the least sampling rate for a rate of turn, Hz: six samples a line (S4.1)."""
    return 6.0 * abs(fastest_dps) * lines / 360.0


class Decoder:
    """Two signals in quadrature as an unwrapped angle, block by block."""

    def __init__(self, ellipse: Ellipse, *, lines: int, rate_hz: float, reversed_: bool = False) -> None:
        raise NotImplementedError

    @property
    def fastest_dps(self) -> float:
        """The greatest rate met so far, °/s."""
        raise NotImplementedError

    def push(self, sine: NDArray[np.float64], cosine: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the angle (n,), °, which goes on from push to push; raises `InsufficientDataError`."""
        raise NotImplementedError

    def reset(self) -> None:
        """Begin a new stretch: the angle begins anew."""
        raise NotImplementedError
