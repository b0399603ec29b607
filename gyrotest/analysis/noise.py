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
from gyrotest.analysis.noise_model import NoiseModel, NoiseTerm, carried_range
from gyrotest.analysis.noise_terms import Grid, allan_columns, allan_response, spectrum_columns
from gyrotest.errors import InsufficientDataError

__all__ = ["SHORTEST_RECORD", "NoiseModel", "NoiseTerm", "fitted_factors", "identify_noise"]

SHORTEST_RECORD = 36
"""Samples below which no noise model is fitted."""

_FITTED_GROUPS = 4

_ONE_SIDED_95 = 1.6448536269514722
_ONE_SIDED_68 = 0.4752995
_ITERATIONS = 3
_PER_DECADE = 5
_POINTS_PER_DECADE = 300
_FEWEST_TIMES = 8
_MISFIT = 0.995


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
    from scipy.special import chdtrc

    misfit = fit.chi_square / fit.freedom
    significant = fit.chi_square > chi_square_quantile(0.999, fit.freedom)
    covariance = fit.covariance * (misfit if significant else 1.0)
    covariance.setflags(write=False)
    tau_s = np.asarray(problem.factors * grid.interval_s, dtype=np.float64)
    parts = problem.columns * fit.squares
    shares = parts / parts.sum(axis=1, keepdims=True)
    terms = [
        _term(fit, covariance, which, tau_s, np.asarray(shares[:, which], dtype=np.float64))
        for which in range(5)
    ]
    return NoiseModel(
        quantization_noise=terms[0],
        angle_random_walk=terms[1],
        bias_instability_coefficient=terms[2],
        rate_random_walk=terms[3],
        rate_ramp=terms[4],
        covariance=covariance,
        lines=(),
        drift=None,
        first_tau_s=float(tau_s[0]),
        last_tau_s=float(tau_s[-1]),
        misfit=misfit,
        fit_probability=float(chdtrc(fit.freedom, fit.chi_square)),
        grid=grid,
    )


def _term(
    fit: _Fit,
    covariance: NDArray[np.float64],
    which: int,
    tau_s: NDArray[np.float64],
    share: NDArray[np.float64],
) -> NoiseTerm:
    """Make a term whose interval is symmetric in the squared coefficient; the root is taken last."""
    square = max(float(fit.squares[which]), 0.0)
    sigma = float(np.sqrt(_variance(fit, covariance, which)))
    resolved = square > NORMAL_95 * sigma
    widths = (1.0, NORMAL_95) if resolved else (_ONE_SIDED_68, _ONE_SIDED_95)
    upper_68, upper_95 = (float(np.sqrt(square + width * sigma)) for width in widths)
    lower_68, lower_95 = (
        float(np.sqrt(square - width * sigma)) if resolved else 0.0 for width in widths
    )
    value = float(np.sqrt(square))
    return NoiseTerm(
        value=value,
        standard_uncertainty=sigma / (2.0 * value) if resolved else upper_95 / NORMAL_95,
        lower_68=lower_68,
        upper_68=upper_68,
        lower_95=lower_95,
        upper_95=upper_95,
        resolved=resolved,
        carries=carried_range(tau_s, share),
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
