"""The error of an encoder's angle that comes again with every line: found while the table moves on smoothly."""

import itertools
import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

_Array = NDArray[np.float64]

SEGMENT = 1024
"""Consecutive samples that are looked at together."""

_ORDERS = 4
_WINDOWS = (16, 32, 64, 128)
_DEGREE = 6
_LEAST_TRAVEL = 2.0 * 2.0 * math.pi
_FEWEST_WINDOWS = 50
_SIGNIFICANT = 2.0
_OUTLYING = 6.0
_GROUPS = 8
_MOST_UNCERTAIN = 2e-3


@dataclass(frozen=True, slots=True, kw_only=True)
class LineError:
    """The phase that is read is too large by Σ `cosines[k−1]`·cos kφ + `sines[k−1]`·sin kφ, radians.

    `uncertainty` is the standard uncertainty of what remains, in radians.
    """

    cosines: tuple[float, ...]
    sines: tuple[float, ...]
    uncertainty: float

    def at(self, sine: _Array, cosine: _Array) -> _Array:
        """Return the error at phases (n,) that are given by their sine and cosine, radians."""
        turned_cosine, turned_sine = cosine, sine
        total = self.cosines[0] * cosine + self.sines[0] * sine
        for of_cosine, of_sine in zip(self.cosines[1:], self.sines[1:], strict=True):
            turned_cosine, turned_sine = (
                turned_cosine * cosine - turned_sine * sine,
                turned_sine * cosine + turned_cosine * sine,
            )
            total += of_cosine * turned_cosine + of_sine * turned_sine
        return total


def find_line_error(phase: _Array) -> LineError | None:
    """Find the error within a line by what is not smooth in the phases of moving tables.

    Parameters
    ----------
    phase
        Shape (segments, n): phases of consecutive samples, radians, wrapped or not.

    Returns
    -------
    None where the table passes too few lines fast enough to tell.

    Notes
    -----
    An ellipse does not show all distortion of the signals: third harmonics that leave the points on an
    ellipse turn the phase all the same. But a table cannot follow the lines. In short windows, in each of which
    it passes two lines or more, the phase is a polynomial of the sixth degree in time and a periodic function
    of itself, with four harmonics; the length of the windows is the one that leaves the least uncertainty, by
    the residual or by how far eighths of the record lie apart. A harmonic that is not twice its uncertainty
    is not corrected; one that is uncertain by more than 2 mrad is not known.
    """
    found = [one for length in _WINDOWS if (one := _by_windows(phase, length)) is not None]
    best = min(found, key=lambda one: one.uncertainty, default=None)
    return None if best is None or best.uncertainty > _MOST_UNCERTAIN else best


def _by_windows(phase: _Array, length: int) -> LineError | None:
    count = phase.shape[1] // length
    windows = np.unwrap(phase[:, : count * length].reshape(-1, length), axis=1)
    windows = windows[np.abs(windows[:, -1] - windows[:, 0]) >= _LEAST_TRAVEL]
    if windows.shape[0] < _FEWEST_WINDOWS:
        return None
    beside = _beside_polynomials(length)
    smooth = windows @ beside
    spread = np.sqrt((smooth**2).mean(axis=1))
    usual = spread <= _OUTLYING * np.median(spread)
    windows, smooth = windows[usual], smooth[usual]
    waves = [wave(k * windows) @ beside for wave in (np.cos, np.sin) for k in range(1, _ORDERS + 1)]
    design = np.stack([one.ravel() for one in waves])
    inverse = np.linalg.pinv(design @ design.T)
    solution = inverse @ (design @ smooth.ravel())
    left = smooth.ravel() - solution @ design
    freedom = smooth.shape[0] * (length - _DEGREE - 1) - solution.size
    by_residual = np.sqrt(np.diag(inverse) * float(left @ left) / freedom)
    edges = np.linspace(0, smooth.shape[0], _GROUPS + 1).astype(np.int64) * length
    parts = [
        _solved(design[:, begin:end], smooth.ravel()[begin:end])
        for begin, end in itertools.pairwise(edges)
    ]
    by_groups = np.std(parts, axis=0, ddof=1) / math.sqrt(_GROUPS)
    return _significant(solution, np.maximum(by_residual, by_groups))


def _solved(design: _Array, values: _Array) -> _Array:
    solution: _Array = np.linalg.pinv(design @ design.T) @ (design @ values)
    return solution


def _significant(solution: _Array, standard: _Array) -> LineError:
    """Keep harmonics that are beyond doubt; what is left out is uncertain by its own size."""
    sizes = np.hypot(*np.split(solution, 2))
    doubts = np.hypot(*np.split(standard, 2))
    kept = sizes > _SIGNIFICANT * doubts
    left_out = np.where(kept, doubts, np.maximum(sizes, doubts))
    cosines, sines = (np.where(kept, one, 0.0) for one in np.split(solution, 2))
    return LineError(
        cosines=tuple(cosines.tolist()),
        sines=tuple(sines.tolist()),
        uncertainty=float(np.sqrt((left_out**2).sum() / 2.0)),
    )


def _beside_polynomials(length: int) -> _Array:
    """Return the projection (length, length) of a window beside its polynomials."""
    basis, _ = np.linalg.qr(np.vander(np.linspace(-1.0, 1.0, length), _DEGREE + 1))
    projection: _Array = np.eye(length) - basis @ basis.T
    return projection
