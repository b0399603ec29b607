"""The noise of step means: fitted to all steps of a test at once, carried to and between their means.

A step is short, so that one alone says little of flicker noise; all together do. What happens within
the steps tells how far apart the means of different steps lie.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gyrotest.analysis.noise_terms import FLICKER, Grid
from gyrotest.analysis.slow_modes import slow_modes
from gyrotest.errors import InsufficientDataError

SHORTEST_STEP = 16
"""Samples that a step is planned with at least; half of them may be lost or be outliers."""

_Array = NDArray[np.float64]
_Integral = Callable[[_Array], _Array]
_WHITE, _WALK = 1, 3
_RESOLVED = 2.0
_ROUNDS = 60
_SAME = 1e-9
_FEWEST = SHORTEST_STEP // 2
_PRUDENCE = np.array([0.0, 0.0, 0.1, 0.02])
_FEWEST_FREEDOM = 5.0


@dataclass(frozen=True, slots=True, kw_only=True)
class Variance:
    """A variance and the degrees of freedom with which it is known."""

    value: float
    degrees_of_freedom: float


@dataclass(frozen=True, slots=True, kw_only=True)
class StepNoise:
    """Squared coefficients Q², N², B², K² (4,) of the steps' common noise, and their covariance (4, 4).

    In the square of the unit U of the samples: (U·s)², U²·s, U², U²/s.
    """

    squares: _Array
    covariance: _Array

    @property
    def prudent_squares(self) -> _Array:
        """The squared coefficients, the slow ones a part of their standard uncertainty higher.

        A wander that short steps do not resolve is not a wander that is absent.
        """
        prudent: _Array = self.squares + _PRUDENCE * np.sqrt(np.diag(self.covariance))
        return prudent

    def variance(self, per_square: _Array) -> Variance:
        """Return the variance of something whose variance per unit of each square is given (4,)."""
        value = float(per_square @ self.prudent_squares)
        spread = float(per_square @ self.covariance @ per_square)
        freedom = 2.0 * value**2 / spread if spread > 0.0 else np.inf
        return Variance(value=value, degrees_of_freedom=max(freedom, _FEWEST_FREEDOM))

    def of_mean(self, duration_s: float, *, since_s: float = 0.0) -> Variance:
        """Return the variance of the mean over one step."""
        per_square = mean_covariances(np.zeros(1), np.full(1, duration_s), since_s=since_s)
        return self.variance(per_square[:, 0, 0])


@dataclass(frozen=True, slots=True, kw_only=True)
class LikeSteps:
    """Means (m,) of steps that have the same stimulus: when they began, how long they are."""

    means: _Array
    begins_s: _Array
    durations_s: _Array


def step_noise(steps: Sequence[_Array], grid: Grid, *, like: LikeSteps | None = None) -> StepNoise:
    """Fit the noise that all steps have in common.

    Parameters
    ----------
    steps
        Each of shape (n,), evenly spaced samples of one unit; their means do not matter.
    grid
        How they are sampled.
    like
        Steps whose means would be the same without noise, such as those at rest before and after: how
        far they lie apart tells of the slow noise that one step is too short for.

    Raises
    ------
    InsufficientDataError
        A step of fewer than 8 samples, or steps without any noise.

    Notes
    -----
    Maximum likelihood of the steps' cosine modes, each normal with the spectrum at its frequency as its
    variance (`gyrotest.analysis.slow_modes`), by weighted least squares without negative squares, the
    weights from the model, until these stay.
    """
    shortest = min((one.size for one in steps), default=0)
    if shortest < _FEWEST:
        raise InsufficientDataError(
            f"a step of {shortest} samples; the uncertainty of a step's mean needs at least {_FEWEST}"
        )
    modes = [slow_modes(one, grid) for one in steps]
    power = np.concatenate([one.mode_dps**2 for one in modes])
    columns = np.concatenate([one.variance for one in modes])
    if not power.sum() > 0.0:
        raise InsufficientDataError("the samples of every step are all the same: is the output alive?")
    if like is not None and like.means.size > 1:
        power = np.append(power, np.diff(like.means) ** 2)
        columns = np.concatenate((columns, _differences(like)))
    return _fitted(power, columns)


def mean_covariances(begins_s: _Array, durations_s: _Array, *, since_s: float = 0.0) -> _Array:
    """Return the covariance of step means per unit of each squared coefficient, shape (4, m, m).

    Parameters
    ----------
    begins_s, durations_s
        Shape (m,): when each step began, and how long its mean is.
    since_s
        Time for which the rate random walk had walked before the first step.

    Notes
    -----
    Flicker noise and a random walk have the covariances −ln|t|/π and −|t|/2 but for a constant, which
    differences of means do not feel. For their sum it is chosen so that the mean over all the time has
    the variance that S3 gives a mean: its Allan variance, 2·ln2/π·B² and K²·(T/3 + t₀).
    """
    begins = begins_s - begins_s.min()
    span_s = float((begins + durations_s).max())
    flicker = -_window_means(_twice_integrated_log, begins, durations_s) / np.pi
    flicker += FLICKER + (np.log(span_s) - 1.5) / np.pi
    walk = -_window_means(_twice_integrated_size, begins, durations_s) / 2.0
    walk += span_s / 2.0 + since_s
    return np.stack((np.diag(3.0 / durations_s**2), np.diag(1.0 / durations_s), flicker, walk))


def _differences(like: LikeSteps) -> _Array:
    """Return the variance per unit of each square of the differences of neighbours, (m − 1, 4)."""
    full = mean_covariances(like.begins_s, like.durations_s)
    own = np.diagonal(full, axis1=1, axis2=2)
    between = np.diagonal(full, offset=1, axis1=1, axis2=2)
    variances: _Array = (own[:, 1:] + own[:, :-1] - 2.0 * between).T
    return variances


def _fitted(power: _Array, columns: _Array) -> StepNoise:
    """Fit the squares; a random walk that is not resolved is taken for none, but for the prudent share of it."""
    scale = columns.mean(axis=0) / power.mean()
    scaled = columns / scale
    squares = _squares(power, scaled)
    if squares[_WALK] < _RESOLVED * np.sqrt(_covariance(scaled, squares)[_WALK, _WALK]):
        squares = np.append(_squares(power, scaled[:, :_WALK]), 0.0)
    covariance = _covariance(scaled, squares)
    return StepNoise(squares=squares / scale, covariance=covariance / np.outer(scale, scale))


def _squares(power: _Array, columns: _Array) -> _Array:
    from scipy.optimize import nnls

    squares: _Array = np.zeros(columns.shape[1])
    squares[_WHITE] = 1.0
    for _ in range(_ROUNDS):
        weight = 1.0 / (columns @ squares)
        found, _ = nnls(columns * weight[:, np.newaxis], power * weight)
        change = float(np.abs(found - squares).max())
        squares = np.asarray(0.5 * (squares + found), dtype=np.float64)
        if change <= _SAME * float(squares.max()):
            break
    return squares


def _covariance(columns: _Array, squares: _Array) -> _Array:
    """Return the inverse of the Fisher information: a squared mode has the variance 2·(its mean)²."""
    weighted = columns / (columns @ squares)[:, np.newaxis]
    inverse = np.linalg.pinv(weighted.T @ weighted, rcond=1e-12)
    return np.asarray(2.0 * inverse, dtype=np.float64)


def _window_means(twice_integrated: _Integral, begins: _Array, durations: _Array) -> _Array:
    """Return the mean of a function of the lag over each pair of windows, by its second integral."""
    ends = begins + durations
    lag = (ends - begins[:, np.newaxis], begins - begins[:, np.newaxis])
    late = (ends - ends[:, np.newaxis], begins - ends[:, np.newaxis])
    integral = (
        twice_integrated(lag[0])
        - twice_integrated(lag[1])
        - twice_integrated(late[0])
        + twice_integrated(late[1])
    )
    means: _Array = integral / np.outer(durations, durations)
    return means


def _twice_integrated_log(lag: _Array) -> _Array:
    size = np.abs(lag)
    integral: _Array = 0.5 * lag**2 * np.log(np.where(size > 0.0, size, 1.0)) - 0.75 * lag**2
    return integral


def _twice_integrated_size(lag: _Array) -> _Array:
    integral: _Array = np.abs(lag) ** 3 / 6.0
    return integral
