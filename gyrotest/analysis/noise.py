"""Noise identification: N, B and K of a record from its Allan variance curve, with uncertainties.

The squared coefficients are fitted to log-spaced overlapping Allan variances by generalised least
squares with the covariance that the model itself gives between averaging times, none of them
negative. The fit begins at the shortest averaging time from which the model describes the record,
so that a sensor's filter or a spectral line does not pass for angle random walk.
"""

import itertools
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from gyrotest.analysis.allan import AllanDeviation, log_spaced_factors, overlapping_allan_deviation
from gyrotest.analysis.interval import NORMAL_95, chi_square_quantile
from gyrotest.analysis.noise_terms import Grid, allan_columns, allan_response, spectrum_columns
from gyrotest.errors import InsufficientDataError

SHORTEST_RECORD = 36
"""Samples below which no noise model is fitted."""

_FITTED_GROUPS = 4

_ONE_SIDED_95 = 1.6448536269514722
_ITERATIONS = 3
_PRUDENCE = 0.12
_PER_DECADE = 5
_POINTS_PER_DECADE = 300
_FEWEST_TIMES = 8
_MISFIT = 0.995


@dataclass(frozen=True, slots=True, kw_only=True)
class NoiseTerm:
    """A coefficient with its standard uncertainty and 95 % interval.

    Where the record does not resolve the term (`resolved` is False) `upper_95` is a one-sided
    upper limit and `lower_95` is 0.
    """

    value: float
    standard_uncertainty: float
    lower_95: float
    upper_95: float
    resolved: bool


@dataclass(frozen=True, slots=True, kw_only=True)
class NoiseModel:
    """A record's noise: apparent angle random walk, °/√s, bias instability, °/s, rate random walk, °/s/√s.

    `covariance` (3, 3) belongs to the squared coefficients. `first_tau_s` … `last_tau_s` were
    fitted; `misfit` is chi-square over its degrees of freedom (about 1 where the model describes
    the record; uncertainties are widened by its root where it is significantly larger).
    """

    angle_random_walk: NoiseTerm
    bias_instability_coefficient: NoiseTerm
    rate_random_walk: NoiseTerm
    covariance: NDArray[np.float64]
    first_tau_s: float
    last_tau_s: float
    misfit: float
    grid: Grid

    @property
    def squares(self) -> NDArray[np.float64]:
        """The squared coefficients N², B², K²."""
        terms = (self.angle_random_walk, self.bias_instability_coefficient, self.rate_random_walk)
        return np.array([term.value**2 for term in terms])

    @property
    def prudent_squares(self) -> NDArray[np.float64]:
        """The squared coefficients, with K² an eighth of its standard uncertainty higher.

        For uncertainties: a walk that a record does not resolve is not a walk that is absent.
        """
        squares = self.squares
        squares[2] += _PRUDENCE * np.sqrt(self.covariance[2, 2])
        return squares

    def allan_deviation_dps(self, averaging_factors: NDArray[np.int64]) -> NDArray[np.float64]:
        """Return the fitted curve."""
        curve: NDArray[np.float64] = np.sqrt(allan_columns(averaging_factors, self.grid) @ self.squares)
        return curve


@dataclass(frozen=True, slots=True, kw_only=True)
class _Fit:
    squares: NDArray[np.float64]
    active: NDArray[np.bool_]
    free: NDArray[np.float64]
    covariance: NDArray[np.float64]
    chi_square: float
    freedom: int


@dataclass(frozen=True, slots=True, kw_only=True)
class _Problem:
    """Allan variances, the terms' columns, and what the variances' covariance is made of."""

    factors: NDArray[np.int64]
    variances: NDArray[np.float64]
    columns: NDArray[np.float64]
    response: NDArray[np.float64]
    spectra: NDArray[np.float64]
    weights: NDArray[np.float64]
    overlap_s: NDArray[np.float64]

    def since(self, first: int) -> "_Problem":
        """Leave out the shortest averaging times."""
        return _Problem(
            factors=self.factors[first:],
            variances=self.variances[first:],
            columns=self.columns[first:],
            response=self.response[first:],
            spectra=self.spectra,
            weights=self.weights,
            overlap_s=self.overlap_s[first:, first:],
        )

    def covariance(self, squares: NDArray[np.float64]) -> NDArray[np.float64]:
        """Compute 1/T_ij ∫ S² H_i H_j df of the model with these squared coefficients."""
        density = self.spectra @ squares
        weighted = self.response * (density**2 * self.weights)
        covariance: NDArray[np.float64] = (weighted @ self.response.T) / self.overlap_s
        return covariance


def identify_noise(
    rate_dps: ArrayLike,
    *,
    sample_rate_hz: float,
    duty: float = 1.0,
    deviation: AllanDeviation | None = None,
) -> NoiseModel:
    """Identify angle random walk, bias instability and rate random walk.

    Parameters
    ----------
    rate_dps
        Shape (n,): rate samples, evenly spaced, °/s.
    sample_rate_hz
        Samples a second.
    duty
        Share of each interval over which a sample is averaged, 0 … 1.
    deviation
        The record's overlapping Allan deviation, where it is at hand already.

    Returns
    -------
    NoiseModel
        Its angle random walk is the apparent one where the duty is below 1.

    Raises
    ------
    InsufficientDataError
        Fewer than 36 samples, a sample that is not finite, or a constant record.
    """
    samples = int(np.shape(rate_dps)[0])
    if samples < SHORTEST_RECORD:
        raise InsufficientDataError(
            f"the record has {samples} samples; a noise model needs at least {SHORTEST_RECORD}"
        )
    factors = fitted_factors(samples)
    if deviation is None or not np.isin(factors, deviation.averaging_factor).all():
        deviation = overlapping_allan_deviation(
            rate_dps, sample_rate_hz=sample_rate_hz, averaging_factors=[int(m) for m in factors]
        )
    chosen = np.isin(deviation.averaging_factor, factors)
    grid = Grid(interval_s=1.0 / sample_rate_hz, aperture_s=duty / sample_rate_hz)
    problem = _problem(factors, deviation.deviation_dps[chosen] ** 2, samples, grid)
    first, fit = _consistent_fit(problem)
    return _model(fit, problem.since(first), grid)


def fitted_factors(samples: int) -> NDArray[np.int64]:
    """Return the averaging factors of the fit: five a decade, to a quarter of the record.

    The last ones are uncertain, but the fit knows how uncertain, and they say most about a rate
    random walk.
    """
    return log_spaced_factors(samples // _FITTED_GROUPS, per_decade=_PER_DECADE)


def _problem(
    factors: NDArray[np.int64], variances: NDArray[np.float64], samples: int, grid: Grid
) -> _Problem:
    p = grid.interval_s
    lowest, highest = 0.02 / (float(factors[-1]) * p), 0.5 / p
    edges = np.geomspace(lowest, highest, int(_POINTS_PER_DECADE * np.log10(highest / lowest)) + 2)
    frequency = np.sqrt(edges[1:] * edges[:-1])
    tau = factors * p
    return _Problem(
        factors=factors,
        variances=variances,
        columns=allan_columns(factors, grid),
        response=allan_response(frequency, factors, grid),
        spectra=spectrum_columns(frequency, grid),
        weights=np.diff(edges),
        overlap_s=samples * p - (tau[:, np.newaxis] + tau[np.newaxis, :]),
    )


def _consistent_fit(problem: _Problem) -> tuple[int, _Fit]:
    """Leave out short averaging times while they contradict the longer ones.

    They do where chi-square falls by more than chance when half a decade, or a whole one, goes.
    """
    step = _PER_DECADE // 2
    last = max(problem.factors.size - _FEWEST_TIMES, 0)
    fits = {first: _fit(problem.since(first)) for first in range(0, last + 1, step)}
    first = 0
    while any(_contradicts(fits, first, first + reach) for reach in (step, 2 * step)):
        first += step
    return first, fits[first]


def _contradicts(fits: dict[int, _Fit], first: int, later: int) -> bool:
    if later not in fits:
        return False
    fall = fits[first].chi_square - fits[later].chi_square
    return fall > chi_square_quantile(_MISFIT, later - first)


def _fit(problem: _Problem) -> _Fit:
    relative = problem.variances * np.sqrt(problem.factors)
    squares = _non_negative(problem, np.diag(relative**2)).squares
    for _ in range(_ITERATIONS - 1):
        squares = _non_negative(problem, problem.covariance(squares)).squares
    return _non_negative(problem, problem.covariance(squares))


def _non_negative(problem: _Problem, covariance: NDArray[np.float64]) -> _Fit:
    """Solve generalised least squares, no coefficient negative: the best of all subsets of the terms."""
    scale = np.sqrt(np.diag(covariance))
    root = np.linalg.cholesky(covariance / np.outer(scale, scale))
    columns = np.linalg.solve(root, problem.columns / scale[:, np.newaxis])
    target = np.linalg.solve(root, problem.variances / scale)
    size = np.sqrt(np.sum(columns**2, axis=0))
    columns = columns / size
    best: tuple[float, NDArray[np.float64], NDArray[np.bool_]] | None = None
    for subset in itertools.product((True, False), repeat=columns.shape[1]):
        active = np.array(subset)
        if not active.any():
            continue
        found = np.zeros(active.size)
        found[active] = np.linalg.lstsq(columns[:, active], target, rcond=None)[0]
        residual = float(np.sum((target - columns @ found) ** 2))
        if (found >= 0.0).all() and (best is None or residual < best[0]):
            best = residual, found, active
    if best is None:
        raise InsufficientDataError(
            "no combination of noise terms describes the record's Allan variance"
        )
    free = np.linalg.lstsq(columns, target, rcond=None)[0]
    inverse = np.linalg.inv(columns.T @ columns)
    return _Fit(
        squares=best[1] / size,
        active=best[2],
        free=free / size,
        covariance=inverse / np.outer(size, size),
        chi_square=best[0],
        freedom=max(problem.factors.size - int(best[2].sum()), 1),
    )


def _model(fit: _Fit, problem: _Problem, grid: Grid) -> NoiseModel:
    misfit = fit.chi_square / fit.freedom
    significant = fit.chi_square > chi_square_quantile(0.999, fit.freedom)
    covariance = fit.covariance * (misfit if significant else 1.0)
    covariance.setflags(write=False)
    angle, bias, walk = (_term(fit, covariance, which) for which in range(3))
    return NoiseModel(
        angle_random_walk=angle,
        bias_instability_coefficient=bias,
        rate_random_walk=walk,
        covariance=covariance,
        first_tau_s=float(problem.factors[0]) * grid.interval_s,
        last_tau_s=float(problem.factors[-1]) * grid.interval_s,
        misfit=misfit,
        grid=grid,
    )


def _term(fit: _Fit, covariance: NDArray[np.float64], which: int) -> NoiseTerm:
    """Make a term whose interval is symmetric in the squared coefficient; the root is taken last."""
    square = max(float(fit.squares[which]), 0.0)
    sigma = float(np.sqrt(_variance(fit, covariance, which)))
    value = float(np.sqrt(square))
    if square > NORMAL_95 * sigma:
        lower, upper = np.sqrt(square - NORMAL_95 * sigma), np.sqrt(square + NORMAL_95 * sigma)
        return NoiseTerm(
            value=value,
            standard_uncertainty=sigma / (2.0 * value),
            lower_95=float(lower),
            upper_95=float(upper),
            resolved=True,
        )
    upper = float(np.sqrt(square + _ONE_SIDED_95 * sigma))
    return NoiseTerm(
        value=value, standard_uncertainty=upper / NORMAL_95, lower_95=0.0, upper_95=upper, resolved=False
    )


def _variance(fit: _Fit, covariance: NDArray[np.float64], which: int) -> float:
    """Variance of a squared coefficient: among the terms in the fit, or, of one left out, among all."""
    if not fit.active[which]:
        return float(covariance[which, which])
    information = np.linalg.inv(covariance)
    inside = np.flatnonzero(fit.active)
    reduced = np.linalg.inv(information[np.ix_(inside, inside)])
    place = int(np.flatnonzero(inside == which)[0])
    return float(reduced[place, place])
