"""A polynomial over a band, fitted to spectral estimates whose neighbours are correlated."""

from dataclasses import dataclass

import numpy as np
from numpy.polynomial import chebyshev
from numpy.typing import NDArray

from gyrotest.analysis.fixed import fixed
from gyrotest.errors import InsufficientDataError

_Array = NDArray[np.float64]

EXTRA = 3
"""Degrees beyond the declared one by which a lack of fit is looked for."""

_BY_CHANCE = 1e-3


@dataclass(frozen=True, slots=True, kw_only=True)
class Estimates:
    """Values at k lines of a spectrum: `x`, `y`, and their standard deviations `error`, all (k,).

    `line` numbers the lines, so that neighbours are known; `correlation` is that of lines 0, 1, 2 … apart.
    `averages` is from how many each error was estimated (inf: known). `common` (k, q) are q independent
    standard deviations of what moves all values together.
    """

    x: _Array
    y: _Array
    error: _Array
    line: NDArray[np.int64]
    correlation: _Array
    averages: float
    common: _Array


@dataclass(frozen=True, slots=True, kw_only=True)
class BandPolynomial:
    """A polynomial of x in `low` … `high`, in Chebyshev's basis on the band.

    `coefficients` (p,) have the `covariance` (p, p). `residual_rms` is the weighted rms of what is left;
    `misfit` its square over what the errors promise, exceeded by chance with `fit_probability`. `lack`
    (p + 3,) is the polynomial of a higher degree less this one, `lack_rms` its rms over the band, as much
    by chance with `lack_probability`: where that is below 0.001, `lack` is part of every uncertainty.
    """

    low: float
    high: float
    coefficients: _Array
    covariance: _Array
    residual_rms: float
    misfit: float
    fit_probability: float
    lack: _Array
    lack_rms: float
    lack_probability: float

    @property
    def lacking(self) -> bool:
        """Whether the degree is too low for what was measured."""
        return self.lack_probability < _BY_CHANCE

    def rows(self, x: _Array, *, derivative: int = 0) -> _Array:
        """Return what gives the value (or a derivative) at x (n,) from coefficients: (n, p + 3)."""
        return _basis(np.atleast_1d(x), self.low, self.high, self.lack.size, derivative)

    def value(self, x: _Array, *, derivative: int = 0) -> _Array:
        """Return the polynomial (or a derivative) at x (n,)."""
        found: _Array = (
            self.rows(x, derivative=derivative)[:, : self.coefficients.size] @ self.coefficients
        )
        return found

    def deviations(self, rows: _Array) -> _Array:
        """Return independent standard deviations (n, q) of what `rows` (n, p + 3) give."""
        roots: _Array = rows[:, : self.coefficients.size] @ _root(self.covariance)
        return np.column_stack((roots, rows @ self.lack)) if self.lacking else roots

    def random(self, rows: _Array) -> _Array:
        """Return the standard deviation (n,) of what `rows` (n, p + 3) give, without the lack of fit."""
        found: _Array = np.linalg.norm(
            rows[:, : self.coefficients.size] @ _root(self.covariance), axis=1
        )
        return found

    def uncertainty(self, rows: _Array) -> _Array:
        """Return the standard uncertainty (n,) of what `rows` (n, p + 3) give."""
        found: _Array = np.linalg.norm(self.deviations(rows), axis=1)
        return found


def fit_band_polynomial(estimates: Estimates, *, low: float, high: float, degree: int) -> BandPolynomial:
    """Fit a polynomial by least squares weighted by 1/error².

    Parameters
    ----------
    estimates
        At least p + 4 of them, for p = degree + 1 coefficients.
    low, high
        The band; x lies in it.

    Raises
    ------
    InsufficientDataError
        Too few lines for the degree.

    Notes
    -----
    S4.6. The weights take neighbours for independent, the covariance does not: it is
    (BᵀWB)⁻¹·BᵀWCWB·(BᵀWB)⁻¹ with C_jk = r_|j−k|·ε_j·ε_k. Errors estimated from L averages make the
    weights scatter, which is allowed for by (L − 1)/(L − 3).
    """
    count, terms = estimates.x.size, degree + 1
    if count < terms + EXTRA + 1:
        raise InsufficientDataError(
            f"{count} lines in the band; a polynomial of degree {degree} needs {terms + EXTRA + 1}: lower the"
            " degree, record more coherent vibration, or set longer segments"
        )
    wide = _WeightedFit(estimates, _basis(estimates.x, low, high, terms + EXTRA, 0))
    narrow = _WeightedFit(estimates, _basis(estimates.x, low, high, terms, 0))
    lack = wide.coefficients.copy()
    lack[:terms] -= narrow.coefficients
    beyond = wide.covariance[terms:, terms:]
    squares = float(lack[terms:] @ np.linalg.solve(beyond, lack[terms:]))
    even = _basis(np.linspace(low, high, 32 * lack.size), low, high, lack.size, 0)
    misfit = narrow.misfit()
    return BandPolynomial(
        low=low,
        high=high,
        coefficients=fixed(narrow.coefficients),
        covariance=fixed(narrow.covariance),
        residual_rms=narrow.residual_rms,
        misfit=misfit.value,
        fit_probability=misfit.probability,
        lack=fixed(lack),
        lack_rms=float(np.sqrt(np.mean((even @ lack) ** 2))),
        lack_probability=_exceeded(squares, EXTRA),
    )


@dataclass(frozen=True, slots=True, kw_only=True)
class _Misfit:
    value: float
    probability: float


class _WeightedFit:
    """Weighted least squares through an orthonormal basis, neighbours correlated."""

    def __init__(self, estimates: Estimates, basis: _Array) -> None:
        self._estimates = estimates
        self._orthonormal, triangle = np.linalg.qr(basis / estimates.error[:, np.newaxis])
        scaled = estimates.y / estimates.error
        found = self._orthonormal.T @ scaled
        inverse = np.linalg.inv(triangle)
        self.coefficients: _Array = inverse @ found
        self._residual: _Array = scaled - self._orthonormal @ found
        self._smeared = _neighbours(self._orthonormal, estimates)
        common = self._orthonormal.T @ (estimates.common / estimates.error[:, np.newaxis])
        spread = self._orthonormal.T @ self._smeared * _scatter(estimates.averages)
        self.covariance: _Array = inverse @ (spread + common @ common.T) @ inverse.T

    @property
    def residual_rms(self) -> float:
        """Weighted rms of the residuals, in the unit of y."""
        return float(np.sqrt(np.sum(self._residual**2) / np.sum(self._estimates.error**-2.0)))

    def misfit(self) -> _Misfit:
        """Return Σr²/ε² over its expectation tr[(I − QQᵀ)R], and how probable as much is."""
        count = self._residual.size
        inner = self._orthonormal.T @ self._smeared
        expected = count - float(np.trace(inner))
        square = (
            _pairs(self._estimates) - 2.0 * float(np.sum(self._smeared**2)) + float(np.sum(inner**2))
        )
        ratio = float(self._residual @ self._residual) / (expected * _scatter(self._estimates.averages))
        freedom = expected**2 / square
        return _Misfit(value=ratio, probability=_exceeded(ratio * freedom, freedom))


def _neighbours(columns: _Array, estimates: Estimates) -> _Array:
    """Return R·columns, R the correlation of the lines, some of which may be left out."""
    place = estimates.line - estimates.line[0]
    full = np.zeros((int(place[-1]) + 1, columns.shape[1]))
    full[place] = columns
    found = estimates.correlation[0] * full
    for apart, correlation in enumerate(estimates.correlation[1 : full.shape[0]], start=1):
        found[apart:] += correlation * full[:-apart]
        found[:-apart] += correlation * full[apart:]
    kept: _Array = found[place]
    return kept


def _pairs(estimates: Estimates) -> float:
    """Return tr(R²): over all pairs of lines the square of their correlation."""
    place = estimates.line - estimates.line[0]
    there = np.zeros(int(place[-1]) + 1)
    there[place] = 1.0
    return float(estimates.line.size) + sum(
        2.0 * float(correlation**2 * (there[apart:] @ there[:-apart]))
        for apart, correlation in enumerate(estimates.correlation[1 : there.size], start=1)
    )


def _scatter(averages: float) -> float:
    return 1.0 if not np.isfinite(averages) else (averages - 1.0) / (averages - 3.0)


def _basis(x: _Array, low: float, high: float, terms: int, derivative: int) -> _Array:
    scale = 2.0 / (high - low)
    place = (np.asarray(x, dtype=np.float64) - low) * scale - 1.0
    if not derivative:
        return np.asarray(chebyshev.chebvander(place, terms - 1), dtype=np.float64)
    slopes = chebyshev.chebder(np.eye(terms), m=derivative, scl=scale, axis=0)
    return np.asarray(chebyshev.chebval(place, slopes).T, dtype=np.float64)


def _root(covariance: _Array) -> _Array:
    values, vectors = np.linalg.eigh(covariance)
    found: _Array = vectors * np.sqrt(np.maximum(values, 0.0))
    return found


def _exceeded(squares: float, freedom: float) -> float:
    from scipy.special import chdtrc

    return float(chdtrc(freedom, squares))
