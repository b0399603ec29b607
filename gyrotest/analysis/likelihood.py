"""How likely a record is under a noise model: its Allan variances and its slow modes together.

The Allan variances of short averaging times enter as in generalised least squares, with the
covariance that the model itself gives them. Longer times enter by the record's slow modes: few
Allan variances of few averages are neither normal nor independent, and intervals that take them so
do not hold the truth.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

_MOST_STEPS = 60
_CONVERGED = 1e-4
_SHORTEST_STEP = 1e-6
_TINY = 1e-300
_RIDGE = 1e-12 * np.eye(4)
_NOT_NEGATIVE = np.zeros(4)
_FILTERED = np.array([-np.inf, 0.0, 0.0, 0.0])

TERMS = 4
"""Noise terms with a spectrum: Q, N, B, K. A ramp has none: it is a drift."""


@dataclass(frozen=True, slots=True, kw_only=True)
class State:
    """Squared coefficients (4,), the drift's amplitude under them, and twice the negative log-likelihood."""

    squares: NDArray[np.float64]
    drift: float
    deviance: float


@dataclass(frozen=True, slots=True, kw_only=True)
class Likelihood:
    """Data of a record and how the squared coefficients Q², N², B², K² make them up.

    `columns` (k, 4) and `precision` (k, k), the inverse covariance, belong to the Allan variances
    (k,), `mode_variance` (m, 4) to the `modes` (m,). `course` (m,) are the modes of a drift of unit
    amplitude; the amplitude is always the most likely one unless `held` fixes it. A `restricted`
    likelihood allows for what the estimated amplitude takes from the noise (restricted maximum
    likelihood: H. D. Patterson and R. Thompson, Biometrika 58, 545, 1971); its deviance does not
    compare with that of another course. Of a `filtered` record Q² may be negative: what a low-pass
    filter takes from the Allan variances of white noise falls as 1/τ² beyond it, as quantization noise
    does, and would else be taken from the angle random walk.
    """

    variances: NDArray[np.float64]
    columns: NDArray[np.float64]
    precision: NDArray[np.float64]
    modes: NDArray[np.float64]
    mode_variance: NDArray[np.float64]
    course: NDArray[np.float64] | None = None
    held: float | None = None
    filtered: bool = False
    restricted: bool = False

    def state(self, squares: NDArray[np.float64]) -> State:
        """Return the deviance of squared coefficients; infinite where they leave a mode no variance."""
        variance = self.mode_variance @ squares
        if float(variance.min()) <= 0.0:
            return State(squares=squares, drift=0.0, deviance=np.inf)
        drift = self.amplitude(variance)
        residual = self.variances - self.columns @ squares
        modal = np.sum(np.log(variance) + self.noise_modes(drift) ** 2 / variance)
        if self.restricted and self.course is not None:
            modal += np.log(np.sum(self.course**2 / variance))
        return State(
            squares=squares,
            drift=drift,
            deviance=float(residual @ self.precision @ residual + modal),
        )

    @property
    def least(self) -> NDArray[np.float64]:
        """The least squared coefficients (4,) allowed."""
        return _FILTERED if self.filtered else _NOT_NEGATIVE

    def amplitude(self, variance: NDArray[np.float64]) -> float:
        """Return the drift's amplitude by weighted least squares."""
        if self.course is None:
            return 0.0
        if self.held is not None:
            return self.held
        weighted = self.course / variance
        return float(weighted @ self.modes) / max(float(weighted @ self.course), _TINY)

    def noise_modes(self, drift: float) -> NDArray[np.float64]:
        """Return the modes less the drift's."""
        return self.modes if self.course is None else self.modes - drift * self.course

    def information(self, squares: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the Fisher information (4, 4) on the squared coefficients."""
        relative = self.mode_variance / (self.mode_variance @ squares)[:, np.newaxis]
        information: NDArray[np.float64] = (
            self.columns.T @ self.precision @ self.columns + 0.5 * relative.T @ relative
        )
        return information

    def covariance(self, squares: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the covariance (4, 4) of the squared coefficients: the inverse of the information."""
        information = self.information(squares)
        scale = 1.0 / np.sqrt(np.diag(information))
        scales = np.outer(scale, scale)
        covariance: NDArray[np.float64] = np.linalg.inv(information * scales) * scales
        return covariance

    def minimise(self, start: NDArray[np.float64], free: tuple[int, ...]) -> State:
        """Find the most likely squared coefficients, none negative, by Fisher scoring.

        Those not `free` stay as `start` has them.
        """
        chosen = np.array(free)
        state = self.state(self._with_variance(start, chosen))
        for _ in range(_MOST_STEPS):
            found = self._improved(state, self._step(state, chosen), chosen)
            if found is None:
                break
            gained, state = state.deviance - found.deviance, found
            if gained < _CONVERGED:
                break
        return state

    def _with_variance(
        self, squares: NDArray[np.float64], chosen: NDArray[np.intp]
    ) -> NDArray[np.float64]:
        """Give the modes some variance to begin with, where they have none."""
        if float((self.mode_variance @ squares).min()) > 0.0:
            return squares
        some = squares.copy()
        for which in chosen:
            some[which] += float(self.modes @ self.modes) / float(self.mode_variance[:, which].sum())
        return some

    def _step(self, state: State, chosen: NDArray[np.intp]) -> NDArray[np.float64]:
        squares = state.squares
        variance = self.mode_variance @ squares
        relative = self.mode_variance / variance[:, np.newaxis]
        excess = self.noise_modes(state.drift) ** 2 / variance - 1.0
        if self.restricted and self.course is not None:
            leverage = self.course**2 / variance
            excess += leverage / leverage.sum()
        residual = self.variances - self.columns @ squares
        gradient = self.columns.T @ (self.precision @ residual) + 0.5 * (relative.T @ excess)
        # A coefficient at its least that the data push below it takes no part.
        moving = chosen[(squares[chosen] > self.least[chosen]) | (gradient[chosen] > 0.0)]
        step = np.zeros(TERMS)
        if moving.size:
            information = self.information(squares)[moving][:, moving]
            scale = 1.0 / np.sqrt(np.diag(information))
            scaled = information * (scale[:, np.newaxis] * scale) + _RIDGE[: moving.size, : moving.size]
            step[moving] = scale * np.linalg.solve(scaled, scale * gradient[moving])
        return step

    def _improved(
        self, state: State, step: NDArray[np.float64], chosen: NDArray[np.intp]
    ) -> State | None:
        """Go along a step as far as the deviance falls; None where it nowhere does."""
        length = 1.0
        while length > _SHORTEST_STEP:
            squares = state.squares.copy()
            squares[chosen] = np.maximum(squares[chosen] + length * step[chosen], self.least[chosen])
            found = self.state(squares)
            if found.deviance < state.deviance:
                return found
            length /= 2.0
        return None


@dataclass(frozen=True, slots=True, kw_only=True)
class Solution:
    """A likelihood and its most likely state."""

    likelihood: Likelihood
    state: State

    def covariance(self) -> NDArray[np.float64]:
        """Return the covariance (4, 4) of the squared coefficients."""
        return self.likelihood.covariance(self.state.squares)

    def without(self, which: int) -> "Solution":
        """Return the most likely state without a term."""
        start = self.state.squares.copy()
        start[which] = 0.0
        others = tuple(one for one in range(TERMS) if one != which)
        return Solution(likelihood=self.likelihood, state=self.likelihood.minimise(start, others))

    def noise_modes(self) -> NDArray[np.float64]:
        """Return the modes less the drift's."""
        return self.likelihood.noise_modes(self.state.drift)

    def mode_variance(self) -> NDArray[np.float64]:
        """Return the fitted variance of each mode."""
        variance: NDArray[np.float64] = self.likelihood.mode_variance @ self.state.squares
        return variance
