"""Least squares among noise that wanders: white, flicker and random-walk noise estimated with the line."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gyrotest.analysis.step_noise import Variance, mean_covariances
from gyrotest.errors import InsufficientDataError

_Array = NDArray[np.float64]
_ROUNDS = 60
_STEP = 0.85
_SAME = 1e-3
# A wander that the values do not resolve is not a wander that is absent: parts of the standard
# uncertainties of B² and K² that join them.
_PRUDENCE = np.array([0.0, 0.2, 0.02])
_WALK = 2
_RESOLVED = 2.0
_FEWEST_FREEDOM = 4.0
_RANK = 1e-9


@dataclass(frozen=True, slots=True, kw_only=True)
class Spans:
    """When the values (m,) begin that are means over a time, and for how long each of them is one."""

    begins_s: _Array
    durations_s: _Array


@dataclass(frozen=True, slots=True, kw_only=True)
class WanderingFit:
    """Coefficients (p,) of the columns of a design, in the unit of the values over that of the columns.

    `weights` (p, m) give them from the values. `squares` are N², B², K² of the noise, per unit of which
    `terms` (3, m, m) is the covariance of the values; `square_covariance` (3, 3) is that of the squares.
    """

    coefficients: _Array
    weights: _Array
    residuals: _Array
    squares: _Array
    terms: _Array
    square_covariance: _Array

    @property
    def prudent_squares(self) -> _Array:
        """The squares (3,), the slow ones a part of their standard uncertainty higher."""
        prudent: _Array = self.squares + _PRUDENCE * np.sqrt(np.diag(self.square_covariance))
        return prudent

    @property
    def noise_covariance(self) -> _Array:
        """Covariance (m, m) of the values' noise."""
        whole: _Array = np.tensordot(self.squares, self.terms, axes=1)
        return whole

    @property
    def covariance(self) -> _Array:
        """Covariance (p, p) of the coefficients by the noise."""
        found: _Array = self.weights @ self.noise_covariance @ self.weights.T
        return found

    def variance(self, functional: _Array) -> Variance:
        """Return the variance of a sum over the coefficients with these factors (p,), and how well it is known."""
        over_values = functional @ self.weights
        per_square = np.array([over_values @ term @ over_values for term in self.terms])
        value = float(per_square @ self.prudent_squares)
        spread = float(per_square @ self.square_covariance @ per_square)
        freedom = 2.0 * value**2 / spread if spread > 0.0 else np.inf
        return Variance(value=value, degrees_of_freedom=max(freedom, _FEWEST_FREEDOM))


def wandering_fit(values: _Array, design: _Array, spans: Spans, *, since_s: float = 0.0) -> WanderingFit:
    """Fit a linear model to means over spans of time, weighted by the covariance that their noise has.

    Parameters
    ----------
    values
        Shape (m,), of any unit.
    design
        Shape (m, p); one column is constant.
    spans
        Of each value; they do not overlap.
    since_s
        Time for which the noise had wandered before the first value.

    Raises
    ------
    InsufficientDataError
        Fewer values than twice the columns, columns that depend on each other, values without noise.

    Notes
    -----
    Generalised least squares, its covariance C = N²·C_N + B²·C_B + K²·C_K with the three covariances of
    means that `gyrotest.analysis.step_noise` gives. The squares are those of restricted maximum
    likelihood, tr(PC_j) = yᵀPC_jPy with P = C⁻¹ − C⁻¹A(AᵀC⁻¹A)⁻¹AᵀC⁻¹ (Patterson and Thompson, 1971), by
    scoring without negative squares; a random walk that is not resolved is taken for none, but for a prudent
    share of its uncertainty. The degrees of freedom of a variance follow from their information
    (Satterthwaite). So a bias that wanders from turn to turn is in the uncertainty, and is weighed down
    where it wanders most.
    """
    _refuse_singular(design)
    terms = mean_covariances(spans.begins_s, spans.durations_s, since_s=since_s)[1:]
    start = values - design @ np.linalg.lstsq(design, values, rcond=None)[0]
    level = float(start @ start) / (values.size - design.shape[1])
    if not level > 0.0:
        raise InsufficientDataError(
            "the values lie on the model without any noise: is the output alive?"
        )
    # Of white noise alone, to begin with.
    squares = np.array([level * float(np.mean(spans.durations_s)), 0.0, 0.0])
    last = _settled(values, design, terms, squares)
    if last.squares[_WALK] < _RESOLVED * np.sqrt(last.square_covariance[_WALK, _WALK]):
        last = _settled(values, design, terms[:_WALK], last.squares[:_WALK])
        last = _Round.of(values, design, terms, np.append(last.squares, 0.0))
    coefficients = last.weights @ values
    return WanderingFit(
        coefficients=coefficients,
        weights=last.weights,
        residuals=values - design @ coefficients,
        squares=last.squares,
        terms=terms,
        square_covariance=last.square_covariance,
    )


@dataclass(frozen=True, slots=True, kw_only=True)
class _Round:
    """What a set of squares leads to: weights of the coefficients, and the next squares.

    The information on the squares is `correlated` times the outer product of `scale`.
    """

    squares: _Array
    weights: _Array
    correlated: _Array
    scale: _Array
    following: _Array

    @property
    def square_covariance(self) -> _Array:
        """The covariance of the squares: the inverse of the information."""
        inverse: _Array = np.linalg.inv(self.correlated) / np.outer(self.scale, self.scale)
        return inverse

    @classmethod
    def of(cls, values: _Array, design: _Array, terms: _Array, squares: _Array) -> "_Round":
        from scipy.optimize import nnls

        precision = np.linalg.inv(np.tensordot(squares, terms, axes=1))
        weighted = design.T @ precision
        weights = np.linalg.solve(weighted @ design, weighted)
        projected = precision - weighted.T @ weights
        left = projected @ values
        products = [projected @ term for term in terms]
        information = 0.5 * np.array([[np.sum(one * other.T) for other in products] for one in products])
        score = 0.5 * np.array([left @ term @ left for term in terms])
        scale = np.sqrt(np.diag(information))
        correlated = information / np.outer(scale, scale) + _RANK * np.eye(len(terms))
        factor = np.linalg.cholesky(correlated)
        following, _ = nnls(factor.T, np.linalg.solve(factor, score / scale))
        return cls(
            squares=squares,
            weights=np.asarray(weights),
            correlated=correlated,
            scale=scale,
            following=following / scale,
        )


def _settled(values: _Array, design: _Array, terms: _Array, squares: _Array) -> _Round:
    """Go on from round to round until the squares stay."""
    for _ in range(_ROUNDS):
        last = _Round.of(values, design, terms, squares)
        found = squares + _STEP * (last.following - squares)
        change = np.abs(found - squares) * last.scale
        squares = found
        if change.max() <= _SAME * float((squares * last.scale).max()):
            break
    return _Round.of(values, design, terms, squares)


def _refuse_singular(design: _Array) -> None:
    count, columns = design.shape
    if count < 2 * columns:
        raise InsufficientDataError(
            f"{count} values for {columns} coefficients; at least {2 * columns} are needed"
        )
    sizes = np.linalg.svd(design / np.linalg.norm(design, axis=0), compute_uv=False)
    if not sizes[-1] > _RANK * sizes[0]:
        raise InsufficientDataError(
            f"{count} values do not tell {columns} coefficients apart: their columns depend on each other"
        )
