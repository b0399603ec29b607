"""Scale factor and zero-rate output by least squares over step means, as weights of these means.

Everything found is linear in the means, so that their covariance carries over exactly.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gyrotest.errors import InsufficientDataError

_Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True, kw_only=True)
class Linear:
    """A sum of step means, each with its weight (m + r,): the turning steps, then those at rest."""

    value: float
    weights: _Array

    def variance(self, covariance: _Array) -> float:
        """Return its variance by the covariance (m + r, m + r) of the means."""
        return float(self.weights @ covariance @ self.weights)

    def per_square(self, covariances: _Array) -> _Array:
        """Return its variances (k,) by several covariances (k, m + r, m + r)."""
        variances: _Array = np.einsum("i,kij,j->k", self.weights, covariances, self.weights)
        return variances


@dataclass(frozen=True, slots=True, kw_only=True)
class StepFit:
    """A line through step means: output per °/s, output at rate 0, and what each step leaves.

    `forward` and `backward` are the slopes over the steps of one sign, each with an intercept of its own;
    None where there are not two rates of that sign. `rest_difference` is the last output at rest less the
    first; None where there is but one.
    """

    scale_factor: Linear
    offset: Linear
    residuals: tuple[Linear, ...]
    forward: Linear | None
    backward: Linear | None
    rest_difference: Linear | None

    @property
    def residual(self) -> _Array:
        """The residuals (m,), in the output's unit."""
        return np.array([one.value for one in self.residuals])

    @property
    def bias(self) -> Linear:
        """The output at rate 0 as a rate, °/s; the weights are its derivatives by the means."""
        slope = self.scale_factor
        bias_dps = self.offset.value / slope.value
        weights = (self.offset.weights - bias_dps * slope.weights) / slope.value
        return Linear(value=bias_dps, weights=weights)

    @property
    def asymmetry(self) -> Linear | None:
        """Forward less backward slope over the size of their mean, signed; None where one is not there."""
        if self.forward is None or self.backward is None:
            return None
        size = abs(0.5 * (self.forward.value + self.backward.value))
        difference = self.forward.weights - self.backward.weights
        return Linear(value=(self.forward.value - self.backward.value) / size, weights=difference / size)


def fit_steps(
    *,
    rates_dps: _Array,
    outputs: _Array,
    times_s: _Array,
    rest_outputs: _Array,
    rest_times_s: _Array,
    line_to_dps: float = np.inf,
) -> StepFit:
    """Fit a line to the outputs of steps, the output at rest taken out by interpolation in time.

    Parameters
    ----------
    rates_dps, outputs, times_s
        Shape (m,): the table's rates, signed; the mean outputs, any unit; the middles of the means.
    rest_outputs, rest_times_s
        Shape (r,), r ≥ 1, in the order of time: the same of the steps at rest. Before the first and after
        the last one its output stands.
    line_to_dps
        The lines are fitted to the steps up to this rate of either sign; residuals are of all steps.

    Raises
    ------
    InsufficientDataError
        Fewer than two different rates, none at rest, or no slope at all.

    Notes
    -----
    S3.3: SF = (Σω_iF_i − ΣωΣF/M)/(Σω² − (Σω)²/M), F0 = mean(F) − SF·mean(ω), F_i less the interpolated
    output at rest, whose mean is added back to F0. Unweighted, as there.
    """
    fitted = np.abs(rates_dps) <= line_to_dps
    if np.unique(rates_dps[fitted]).size < 2:
        raise InsufficientDataError(
            f"{np.unique(rates_dps[fitted]).size} rate; a line needs steps at two different rates at least"
        )
    if not rest_outputs.size:
        raise InsufficientDataError("no step at rest; its output is subtracted from every other step's")
    means = np.concatenate((outputs, rest_outputs))
    above_rest = np.hstack((np.eye(outputs.size), -_interpolation(times_s, rest_times_s)))
    slope, intercept = _line(rates_dps, fitted) @ above_rest  # S3.3
    at_rest = np.zeros(means.size)
    at_rest[outputs.size :] = 1.0 / rest_outputs.size
    line = np.outer(rates_dps, slope) + intercept
    fit = StepFit(
        scale_factor=_linear(slope, means),
        offset=_linear(intercept + at_rest, means),
        residuals=tuple(_linear(row, means) for row in above_rest - line),
        forward=_one_sided(fitted & (rates_dps > 0.0), rates_dps, above_rest, means),
        backward=_one_sided(fitted & (rates_dps < 0.0), rates_dps, above_rest, means),
        rest_difference=_difference(outputs.size, means),
    )
    if fit.scale_factor.value == 0.0:
        raise InsufficientDataError("the output does not follow the rate at all: the slope is 0")
    return fit


def _linear(weights: _Array, means: _Array) -> Linear:
    return Linear(value=float(weights @ means), weights=weights)


def _line(rates_dps: _Array, chosen: NDArray[np.bool_]) -> _Array:
    """Return the weights (2, m) of slope and intercept of the unweighted line through some steps."""
    mean_dps = rates_dps[chosen].mean()
    about = np.where(chosen, rates_dps - mean_dps, 0.0)
    slope = about / float(about @ about)
    return np.stack((slope, chosen / np.count_nonzero(chosen) - mean_dps * slope))


def _one_sided(
    chosen: NDArray[np.bool_], rates_dps: _Array, above_rest: _Array, means: _Array
) -> Linear | None:
    if np.unique(rates_dps[chosen]).size < 2:
        return None
    return _linear(_line(rates_dps, chosen)[0] @ above_rest, means)


def _interpolation(times_s: _Array, rest_times_s: _Array) -> _Array:
    """Return the weights (m, r) by which steps at rest stand for the output at rest at other times."""
    weights: _Array = np.stack(
        [np.interp(times_s, rest_times_s, row) for row in np.eye(rest_times_s.size)], axis=1
    )
    return weights


def _difference(steps: int, means: _Array) -> Linear | None:
    if means.size - steps < 2:
        return None
    weights = np.zeros(means.size)
    weights[steps], weights[-1] = -1.0, 1.0
    return _linear(weights, means)
