"""The ellipse that two signals in quadrature go round: offsets, amplitudes, and error of quadrature."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True, slots=True, kw_only=True)
class Ellipse:
    """Sine = `sine_offset + sine_amplitude·sin φ`, cosine = `cosine_offset + cosine_amplitude·cos(φ + quadrature_error)`.

    Offsets and amplitudes in the signals' unit, the error of quadrature in radians.
    """

    sine_offset: float
    cosine_offset: float
    sine_amplitude: float
    cosine_amplitude: float
    quadrature_error: float


class EllipseFit:
    """The ellipse through all points that were pushed, by sums: memory does not grow."""

    def push(self, sine: NDArray[np.float64], cosine: NDArray[np.float64]) -> None:
        """Take further points, both (n,), of one instant each."""
        raise NotImplementedError

    def fit(self) -> Ellipse:
        """Return the ellipse; raises `InsufficientDataError`."""
        raise NotImplementedError
