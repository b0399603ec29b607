"""A record as it is fitted: short-time Allan variances and slow modes, and what is taken out of them."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from gyrotest.analysis.allan_fit import AllanFit
from gyrotest.analysis.drift import Course, DriftSearch, search_drift
from gyrotest.analysis.likelihood import TERMS, Likelihood, Solution
from gyrotest.analysis.slow_lines import take_slow_lines
from gyrotest.analysis.slow_modes import SlowModes
from gyrotest.analysis.spectral_lines import Excess

_FEWEST_MODES = 16
_ROUNDS = 4
_ROUNDS_ON = 2
_ALL = tuple(range(TERMS))


@dataclass(frozen=True, slots=True, kw_only=True)
class FittedRecord:
    """What is fitted, Allan variances and slow modes, and the drifts that are looked for.

    `filtered` says that short times contradict the longer ones, as a filter makes them.
    """

    fit: AllanFit
    modes: SlowModes
    candidates: tuple[Course, ...]
    filtered: bool = False

    def since(self, first: int) -> "FittedRecord":
        """Leave out the shortest averaging times; after the last of them, an octave of modes each."""
        beyond = max(first - self.fit.factors.size, 0)
        count = self.modes.mode_dps.size >> beyond
        return FittedRecord(
            fit=self.fit.since(first),
            modes=self.modes.slowest(count),
            candidates=tuple(one.slowest(count) for one in self.candidates),
        )

    @property
    def times(self) -> int:
        """How many averaging times and octaves of modes there are to leave out."""
        octaves = (self.modes.mode_dps.size // _FEWEST_MODES).bit_length() - 1
        return self.fit.factors.size + max(octaves, 0)

    @property
    def first_tau_s(self) -> float:
        """The averaging time at which the fit begins."""
        tau_s = self.fit.tau_s
        return float(tau_s[0]) if tau_s.size else self.modes.first_tau_s

    def share_at_first(self, search: DriftSearch) -> float:
        """Return a recognised drift's Allan variance where the fit begins; 0 of none."""
        if search.course is None:
            return 0.0
        tau = np.array([self.first_tau_s / self.modes.duration_s])
        return float(search.amplitude**2 * search.course.allan_variances(tau)[0])

    def less(self, search: DriftSearch) -> "FittedRecord":
        """Take a recognised drift's share out of the Allan variances."""
        if search.course is None:
            return self
        tau = self.fit.tau_s / self.modes.duration_s
        share = search.amplitude**2 * search.course.allan_variances(tau)
        return replace(self, fit=self.fit.less(share))

    def without_slow_lines(self, search: DriftSearch) -> tuple["FittedRecord", tuple[Excess, ...]]:
        """Take the slow lines out, beside a recognised drift, and return them too."""
        course = np.zeros(self.modes.mode_dps.size)
        if search.course is not None:
            course = search.amplitude * search.course.modes
        modes, lines = take_slow_lines(self.modes, course)
        return replace(self, modes=modes, fit=self.fit.less_lines(lines)), lines

    def solved(
        self, *, course: Course | None = None, start: NDArray[np.float64] | None = None
    ) -> Solution:
        """Fit the noise, and a drift's amplitude, with the covariance of the model that results."""
        squares, rounds = (self.fit.guess(), _ROUNDS) if start is None else (start, _ROUNDS_ON)
        for _ in range(rounds):
            likelihood = Likelihood(
                variances=self.fit.variances,
                columns=self.fit.columns,
                precision=self.fit.precision(squares),
                modes=self.modes.mode_dps,
                mode_variance=self.modes.variance,
                course=None if course is None else course.slowest(self.modes.mode_dps.size).modes,
                restricted=course is not None,
                filtered=self.filtered,
            )
            state = likelihood.minimise(squares, _ALL)
            squares = state.squares
        return Solution(likelihood=likelihood, state=state)

    def searched(self, solution: Solution) -> DriftSearch:
        """Look for a drift."""
        return search_drift(solution, self.modes, self.candidates)
