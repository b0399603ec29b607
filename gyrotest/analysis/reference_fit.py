"""The straight line of an output over a reference that moves, sample by sample."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gyrotest.analysis.correlation import correlation_time
from gyrotest.errors import InsufficientDataError

FEWEST_SAMPLES = 64
_FEWEST_BLOCKS = 8
_MOST_BLOCKS = 32
_TIMES_PER_BLOCK = 8.0


@dataclass(frozen=True, slots=True, kw_only=True)
class ReferenceFit:
    """Output = `slope`·reference + `intercept`, with standard uncertainties by the scatter alone.

    `residuals` (n,), read-only, and their `rms` are in the output's unit; each uncertainty and the rms
    has its degrees of freedom. `effective_samples` are the independent ones among those of the slope.
    """

    slope: float
    intercept: float
    slope_uncertainty: float
    intercept_uncertainty: float
    slope_freedom: float
    intercept_freedom: float
    residuals: NDArray[np.float64]
    rms: float
    rms_freedom: float
    effective_samples: float


def reference_fit(output: NDArray[np.float64], reference: NDArray[np.float64]) -> ReferenceFit:
    """Fit output over reference by least squares, sample by sample.

    Parameters
    ----------
    output, reference
        Shape (n,), in the order of time; gaps do not matter. All scatter is taken as the output's.

    Raises
    ------
    InsufficientDataError
        Fewer than 64 samples, or a reference that does not move.

    Notes
    -----
    S3.3, over samples in the place of step means. Residuals of a moving reference are not white: they
    follow the drive where a delay or a nonlinearity is left in them, and slow drift. So the uncertainties
    come from a jackknife that leaves out one block of consecutive samples after another (Efron and
    Stein, 1981; Künsch, 1989, for dependent data). For the slope the blocks are cut so that each holds
    as much of Σ(ω − ω̄)², and are at least eight times as long as the correlation time of
    (ω − ω̄)·residual; for the intercept they hold as many samples, and the residual's correlation time
    counts. There are eight blocks at least and 32 at most.
    """
    if output.size < FEWEST_SAMPLES:
        raise InsufficientDataError(
            f"{output.size} samples are left for the line; {FEWEST_SAMPLES} are needed"
        )
    if reference.min() == reference.max():
        raise InsufficientDataError(
            f"the reference does not move: all {reference.size} samples are {float(reference[0]):.6g} °/s"
        )
    away = reference - reference.mean()
    leverage = away**2
    slope = float(away @ output) / float(leverage.sum())
    intercept = float(output.mean() - slope * reference.mean())
    residuals = output - (slope * reference + intercept)
    residuals.setflags(write=False)
    of_slope = output.size / correlation_time(away * residuals)
    of_intercept = output.size / correlation_time(residuals)
    slopes = _jackknife(reference, residuals, _cuts(leverage, _blocks(of_slope)))
    levels = _jackknife(reference, residuals, _cuts(np.ones_like(away), _blocks(of_intercept)))
    mean_square = float(residuals @ residuals) / (output.size - 2)
    return ReferenceFit(
        slope=slope,
        intercept=intercept,
        slope_uncertainty=slopes.slope,
        intercept_uncertainty=levels.intercept,
        slope_freedom=_freedom(slopes.blocks, of_slope),
        intercept_freedom=_freedom(levels.blocks, of_intercept),
        residuals=residuals,
        rms=float(np.sqrt(mean_square)),
        rms_freedom=_spread_freedom(mean_square, levels, output.size),
        effective_samples=of_slope,
    )


@dataclass(frozen=True, slots=True, kw_only=True)
class _LeftOut:
    """Standard uncertainties from leaving out one block after another."""

    slope: float
    intercept: float
    mean_square: float
    blocks: int


def _blocks(effective_samples: float) -> int:
    return int(np.clip(effective_samples / _TIMES_PER_BLOCK, _FEWEST_BLOCKS, _MOST_BLOCKS))


def _cuts(weight: NDArray[np.float64], blocks: int) -> NDArray[np.intp]:
    """Return where blocks of equal weight begin; those that would be empty fall together."""
    cumulated = np.cumsum(weight)
    shares = np.arange(1, blocks) * (cumulated[-1] / blocks)
    inner = np.searchsorted(cumulated, shares, side="right")
    return np.unique(np.concatenate(([0], np.minimum(inner, weight.size - 1))))


def _jackknife(
    reference: NDArray[np.float64], residuals: NDArray[np.float64], cuts: NDArray[np.intp]
) -> _LeftOut:
    counts = np.diff(np.append(cuts, residuals.size)).astype(np.float64)
    middle = float(reference.mean())
    x, y = reference - middle, residuals

    def without(values: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the sum over all blocks but one, for each block."""
        sums = np.add.reduceat(values, cuts)
        rest: NDArray[np.float64] = sums.sum() - sums
        return rest

    n = residuals.size - counts
    sx, sy = without(x), without(y)
    slopes = (without(x * y) - sx * sy / n) / (without(x * x) - sx**2 / n)
    # At the reference's zero, where the intercept stands.
    intercepts = sy / n - slopes * (sx / n + middle)
    squares = without(y * y) / n
    return _LeftOut(
        slope=_deviation(slopes),
        intercept=_deviation(intercepts),
        mean_square=_deviation(squares),
        blocks=cuts.size,
    )


def _deviation(left_out: NDArray[np.float64]) -> float:
    """Return the jackknife's standard uncertainty of what is computed without each block in turn."""
    blocks = left_out.size
    return float(np.sqrt((blocks - 1) / blocks * np.sum((left_out - left_out.mean()) ** 2)))


def _freedom(blocks: int, effective_samples: float) -> float:
    """Return the degrees of freedom: fewer where the blocks are short beside the correlation time."""
    return max(min(float(blocks), effective_samples / (_TIMES_PER_BLOCK / 2.0)) - 1.0, 2.0)


def _spread_freedom(mean_square: float, left_out: _LeftOut, samples: int) -> float:
    """Return the degrees of freedom 2·m²/u² of a mean square m with standard uncertainty u."""
    if left_out.mean_square == 0.0:
        return float(samples - 2)
    return min(max(2.0 * (mean_square / left_out.mean_square) ** 2, 1.0), float(samples - 2))


def delay_s(
    fit: ReferenceFit,
    reference_dps: NDArray[np.float64],
    place: NDArray[np.int64],
    *,
    interval_s: float,
) -> float | None:
    """Estimate by how much the output lags the reference; negative where it leads, None where nothing tells.

    Parameters
    ----------
    reference_dps, place
        Shape (n,): the reference that was fitted, and the samples' places on the grid.

    Notes
    -----
    To first order U = SF·ω(t − δ) + U0 is the line with −SF·δ·dω/dt left over, which least squares
    finds in the residuals. The slope comes out low by about (2πfδ)²/2 for a drive of frequency f.
    """
    inside = np.flatnonzero((np.diff(place[:-1]) == 1) & (np.diff(place[1:]) == 1)) + 1
    change = (reference_dps[inside + 1] - reference_dps[inside - 1]) / (2.0 * interval_s)
    power = float(change @ change)
    if power == 0.0:
        return None
    return -float(fit.residuals[inside] @ change) / (fit.slope * power)
