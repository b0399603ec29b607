"""How well a fit describes a record."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gyrotest.analysis.likelihood import Solution

_FIRST_BAND = 4
_SIGNIFICANT = 1e-3


@dataclass(frozen=True, slots=True, kw_only=True)
class Goodness:
    """Chi-square, its degrees of freedom, and how often chance alone fits no better."""

    chi_square: float
    freedom: int
    probability: float

    @property
    def misfit(self) -> float:
        """Chi-square over its degrees of freedom."""
        return self.chi_square / self.freedom

    @property
    def widening(self) -> float:
        """The misfit where chance does not explain it, else 1."""
        return max(self.misfit, 1.0) if self.probability < _SIGNIFICANT else 1.0


def goodness(solution: Solution) -> Goodness:
    """Return the goodness of a fit: of its Allan variances, and of its slow modes in bands of an octave."""
    from scipy.special import chdtrc

    likelihood, state = solution.likelihood, solution.state
    residual = likelihood.variances - likelihood.columns @ state.squares
    relative = solution.noise_modes() ** 2 / solution.mode_variance()
    bands = _bands(relative.size)
    counts = np.diff(np.append(bands, relative.size))
    means = np.maximum(np.add.reduceat(relative, bands) / counts, 1e-12)
    chi_square = max(float(residual @ likelihood.precision @ residual), 0.0)
    chi_square += float(np.sum(counts * (means - 1.0 - np.log(means))))
    used = int(np.count_nonzero(state.squares)) + (likelihood.course is not None)
    freedom = max(residual.size + bands.size - used, 1)
    return Goodness(
        chi_square=chi_square, freedom=freedom, probability=float(chdtrc(freedom, chi_square))
    )


def _bands(modes: int) -> NDArray[np.intp]:
    """Return where the bands begin, an octave each: 0, 4, 8, 16 and so on."""
    begins = [0]
    while (_FIRST_BAND << (len(begins) - 1)) + _FIRST_BAND <= modes:
        begins.append(_FIRST_BAND << (len(begins) - 1))
    return np.array(begins, dtype=np.intp)
