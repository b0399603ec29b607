"""The ellipse that two signals in quadrature go round: offsets, amplitudes, and error of quadrature."""

import math
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from gyrotest.analysis.conic import Conic, ConicSums
from gyrotest.analysis.line_error import SEGMENT, LineError, find_line_error
from gyrotest.analysis.thinning import Thinned
from gyrotest.errors import InsufficientDataError

_FEWEST = 200
_KEPT = 16384
_SEGMENTS = 512
_SECTORS = 32
_FEWEST_IN_SECTOR = 3
_MOST_SCATTER = 0.15
_MOST_UNEQUAL = 10.0
_OF_NORMAL = 1.4826
_CHANCE = 2.0
_FEWEST_CLIPPED, _CLIPPED_MORE = 20, 6
_SAME = 1e-9


@dataclass(frozen=True, slots=True, kw_only=True)
class Vector:
    """A corrected vector: `sine` and `cosine` (n,) of the phase, where its length is 1."""

    sine: NDArray[np.float64]
    cosine: NDArray[np.float64]

    @property
    def length(self) -> NDArray[np.float64]:
        """Its length (n,)."""
        length: NDArray[np.float64] = np.hypot(self.sine, self.cosine)
        return length


@dataclass(frozen=True, slots=True, kw_only=True)
class Ellipse:
    """How two signals depart from the sine and the cosine of a phase φ.

    The one is `sine_offset + sine_amplitude·sin φ`, the other `cosine_offset + cosine_amplitude·cos(φ + ε)`,
    with ε the `quadrature_error` in radians and all else in the signals' unit. `scatter` is the spread
    (one sigma) of the corrected vector's length, `harmonics` the most that its mean in any 1/32 of the circle
    is off 1, beyond what the scatter explains: distortion that an ellipse cannot correct. `line_error` is
    what that does to the phase (None: the table moved too little to tell).
    """

    sine_offset: float
    cosine_offset: float
    sine_amplitude: float
    cosine_amplitude: float
    quadrature_error: float
    scatter: float = 0.0
    harmonics: float = 0.0
    line_error: LineError | None = None

    def corrected(self, sine: NDArray[np.float64], cosine: NDArray[np.float64]) -> Vector:
        """Return the signals, both (n,), as the vector that they stand for."""
        x = (sine - self.sine_offset) * (1.0 / self.sine_amplitude)
        y = (cosine - self.cosine_offset) * (1.0 / self.cosine_amplitude)
        y += x * math.sin(self.quadrature_error)  # cos(φ + ε) = cos φ cos ε − sin φ sin ε
        y *= 1.0 / math.cos(self.quadrature_error)
        return Vector(sine=x, cosine=y)


class EllipseFit:
    """The ellipse through all points that were pushed, by sums: memory does not grow.

    Notes
    -----
    S4.1, after Heydemann (Applied Optics 20, 3382, 1981), by the least-squares conic that is constrained to
    be an ellipse. Some thousand points, picked evenly from all, are kept to see how well it fits and whether
    they go all the way round, and half a million consecutive ones at most for the error within a line.
    """

    def __init__(self) -> None:
        self._sums = ConicSums()
        self._kept = Thinned(columns=2, most=_KEPT)
        self._segments = Thinned(columns=2 * SEGMENT, most=_SEGMENTS)
        self._waiting = np.empty((2, 0))

    def begin_stretch(self) -> None:
        """Say that what comes does not go on from what came before."""
        self._waiting = self._waiting[:, :0]

    def push(self, sine: NDArray[np.float64], cosine: NDArray[np.float64]) -> None:
        """Take further points, both (n,), of one instant each and in one unit."""
        if sine.size:
            self._sums.push(sine, cosine)
            self._kept.push(sine, cosine)
            self._keep_segments(np.concatenate((self._waiting, np.stack((sine, cosine))), axis=1))

    def _keep_segments(self, both: NDArray[np.float64]) -> None:
        count = both.shape[1] // SEGMENT
        self._waiting = both[:, count * SEGMENT :]
        whole = both[:, : count * SEGMENT].reshape(2, count, SEGMENT)
        self._segments.push_rows(np.concatenate((whole[0], whole[1]), axis=1))

    def fit(self) -> Ellipse:
        """Return the ellipse.

        Raises
        ------
        InsufficientDataError
            There are too few points, a signal is dead or clipped, or the points do not go all the way
            round an ellipse: less than a line was covered, or noise hides it.
        """
        sine, cosine = self._kept.columns
        if sine.size < _FEWEST:
            raise InsufficientDataError(
                f"{sine.size} samples are too few for the ellipse of the encoder's signals; {_FEWEST} are needed"
            )
        _refuse_constant(sine, cosine)
        _refuse_clipped("sine", sine)
        _refuse_clipped("cosine", cosine)
        conic = self._sums.fit()
        if conic is None:
            raise InsufficientDataError(f"{_NOT_ROUND}; no ellipse fits them")
        ellipse = _examined(_ellipse(conic), sine, cosine)
        return replace(ellipse, line_error=self._line_error(ellipse))

    def _line_error(self, ellipse: Ellipse) -> LineError | None:
        sine, cosine = np.split(self._segments.rows, 2, axis=1)
        vector = ellipse.corrected(sine, cosine)
        return find_line_error(np.arctan2(vector.sine, vector.cosine))


_NOT_ROUND = (
    "the encoder's signals do not go round a circle: the table moved by less than a line, a signal is dead, or"
    " noise hides them"
)


def _ellipse(conic: Conic) -> Ellipse:
    """Return it in amplitudes and phases: x²/a² + y²/b² + 2xy·sin ε/(ab) = cos² ε about the centre."""
    of_quadrature = conic.xy / (2.0 * math.sqrt(conic.xx * conic.yy))
    shrunk = math.sqrt(1.0 - of_quadrature**2)
    return Ellipse(
        sine_offset=conic.centre_x,
        cosine_offset=conic.centre_y,
        sine_amplitude=1.0 / (math.sqrt(conic.xx) * shrunk),
        cosine_amplitude=1.0 / (math.sqrt(conic.yy) * shrunk),
        quadrature_error=math.asin(of_quadrature),
    )


def _examined(ellipse: Ellipse, sine: NDArray[np.float64], cosine: NDArray[np.float64]) -> Ellipse:
    """Return the ellipse with what it leaves; refuse one that the points do not go round."""
    vector = ellipse.corrected(sine, cosine)
    length = vector.length
    scatter = _OF_NORMAL * float(np.median(np.abs(length - np.median(length))))
    amplitudes = sorted((ellipse.sine_amplitude, ellipse.cosine_amplitude))
    if scatter > _MOST_SCATTER or amplitudes[1] > _MOST_UNEQUAL * amplitudes[0]:
        raise InsufficientDataError(
            f"{_NOT_ROUND}; the best ellipse has amplitudes of {ellipse.sine_amplitude:.3g} and"
            f" {ellipse.cosine_amplitude:.3g}, and leaves a scatter of {scatter:.0%} (at most {_MOST_SCATTER:.0%})"
        )
    turns = np.arctan2(vector.sine, vector.cosine) / (2.0 * math.pi)
    sector = np.floor(turns * _SECTORS).astype(np.int64) % _SECTORS
    counts = np.bincount(sector, minlength=_SECTORS)
    empty = int((counts < _FEWEST_IN_SECTOR).sum())
    if empty:
        raise InsufficientDataError(
            f"the encoder's signals cover {_SECTORS - empty} of {_SECTORS} parts of a line: they are corrected by"
            " the ellipse of a whole line; move the table farther, if only in another step"
        )
    means = np.bincount(sector, weights=length, minlength=_SECTORS) / counts
    by_chance = _CHANCE * scatter / np.sqrt(counts)
    harmonics = float(np.maximum(np.abs(means - 1.0) - by_chance, 0.0).max())
    return replace(ellipse, scatter=scatter, harmonics=harmonics)


def _refuse_constant(sine: NDArray[np.float64], cosine: NDArray[np.float64]) -> None:
    dead = [name for name, one in (("sine", sine), ("cosine", cosine)) if one.min() == one.max()]
    if dead:
        raise InsufficientDataError(
            f"the encoder's {' and '.join(dead)} signal {'is' if len(dead) == 1 else 'are'} constant: dead, or"
            " not connected, or the table did not move"
        )


def _refuse_clipped(name: str, signal: NDArray[np.float64]) -> None:
    """Refuse a signal that stands at its greatest or least value far more often than next to it."""
    step = _SAME * (signal.max() - signal.min())
    levels, counts = np.unique(np.rint(signal / step) * step, return_counts=True)
    for level, most, beside in (
        (levels[0], counts[0], counts[1]),
        (levels[-1], counts[-1], counts[-2]),
    ):
        if most >= _FEWEST_CLIPPED and most > _CLIPPED_MORE * beside:
            raise InsufficientDataError(
                f"the encoder's {name} signal stands at {level:.4g} in {most} of {signal.size} samples: it is"
                " clipped; lower its gain, or widen the channel's range"
            )
