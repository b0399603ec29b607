"""The complex envelope of a record on a known wave: least squares, and what lies beside the wave."""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

_Array = NDArray[np.float64]
_Waves = NDArray[np.complex128]

_SEGMENTS = 128


@dataclass(frozen=True, slots=True, kw_only=True)
class Envelope:
    """The record is `Re[E(τ)·wave]` and a polynomial beside it, τ from −1 to 1 over the record.

    `coefficients` (order + 1,) are those of E in powers of τ, `residual` (n,) is what is left.
    """

    coefficients: _Waves
    residual: _Array

    @property
    def order(self) -> int:
        """Order of E in τ; of 0, on a constant, it is a sine fit with three parameters (IEEE 1057)."""
        return self.coefficients.size - 1

    @property
    def middle(self) -> complex:
        """E in the middle of the record."""
        return complex(self.coefficients[0])

    @property
    def slope(self) -> complex:
        """dE/dτ in the middle of the record."""
        return complex(self.coefficients[1]) if self.order else 0j

    @property
    def residual_rms(self) -> float:
        """Root mean square of what is left."""
        return math.sqrt(float(np.mean(self.residual**2)))

    def sidebands(self, wave: _Waves, lines: NDArray[np.int64]) -> _Waves:
        """Return the residual's phasors (m,) beside the wave, by `lines` periods more in the record."""
        each = max(self.residual.size // _SEGMENTS, 1)
        segments = self.residual.size // each
        turned = (self.residual * wave.conj())[: segments * each].reshape(segments, each).sum(axis=1)
        middles = ((np.arange(segments) + 0.5) * each - self.residual.size / 2.0) * (
            2.0 / self.residual.size
        )
        turning = np.exp(-1j * math.pi * np.outer(lines, middles))
        phasors: _Waves = (turning @ turned) * (2.0 / (segments * each))
        return phasors


def fit_envelope(values: _Array, wave: _Waves, *, order: int, drift: int) -> Envelope:
    """Fit an envelope, and a slow polynomial beside it.

    Parameters
    ----------
    values
        Shape (n,), any unit.
    wave
        Shape (n,), of modulus 1.
    order, drift
        Of the envelope and of the polynomial beside it, in time; both 0 for a sine on a constant.
    """
    time = (np.arange(values.size) - (values.size - 1) / 2.0) * (2.0 / values.size)
    powers = [time**power for power in range(max(order, drift) + 1)]
    origin = float(values.mean())
    columns = np.stack(
        [
            *(one * wave.real for one in powers[: order + 1]),
            *(-one * wave.imag for one in powers[: order + 1]),
            *powers[: drift + 1],
        ]
    )
    centred = values - origin
    solution = np.linalg.solve(columns @ columns.T, columns @ centred)
    residual = centred - solution @ columns
    residual.setflags(write=False)
    coefficients = solution[: order + 1] + 1j * solution[order + 1 : 2 * (order + 1)]
    coefficients.setflags(write=False)
    return Envelope(coefficients=coefficients, residual=residual)
