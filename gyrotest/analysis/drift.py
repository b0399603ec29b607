"""Drift: a linear or exponential course of the rate, told from a random walk by likelihood.

A drift that is taken for noise reads as a rate random walk. So the record's slow modes are fitted
with a course as well: one that makes the record much likelier is recognised and kept out of the
noise; and a random walk counts as resolved only where no drift explains the record as well.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from gyrotest.analysis.likelihood import Likelihood, Solution, State
from gyrotest.analysis.noise_model import Drift, DriftKind
from gyrotest.analysis.slow_modes import SlowModes

_RECOGNISED = 9.2
_CURVED = 4.0
_CURVED_WITHOUT_WALK = 3.0
_TIME_CONSTANTS = tuple(float(one) for one in np.geomspace(0.02, 1.5, 14))
_AROUND = np.array([-1.0, 0.0, 1.0])
_CLOSER = (0.3, 0.1, 0.03, 0.01, 0.003, 0.001)
_ALL = (0, 1, 2, 3)
_NO_WALK = (0, 1, 2)
_WALK = 3


@dataclass(frozen=True, slots=True, kw_only=True)
class Course:
    """The shape of a drift over the record: t/T, or exp(−t/(constant·T)); `modes` (m,) its slow modes."""

    kind: DriftKind
    constant: float | None
    modes: NDArray[np.float64]

    @property
    def time_constant(self) -> float:
        """The time constant of an exponential, over the record's length; `ValueError` of a linear course."""
        if self.constant is None:
            raise ValueError("a linear course has no time constant")
        return self.constant

    @property
    def change(self) -> float:
        """What a unit amplitude changes from the record's begin to its end."""
        return 1.0 if self.constant is None else float(np.expm1(-1.0 / self.constant))

    def slowest(self, count: int) -> "Course":
        """Leave out the fastest modes."""
        return replace(self, modes=self.modes[:count])

    def allan_variances(self, tau: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the Allan variances (k,) of a unit amplitude at averaging times over the record's length.

        Second differences of the angle: τ² of a ramp, and c²(1 − e^(−τ/c))²e^(−t/c)/c of an exponential.
        """
        if self.constant is None:
            return tau**2 / 2.0
        c, left = self.constant, 1.0 - 2.0 * tau
        mean_square = c**3 / 2.0 * -np.expm1(-2.0 * left / c) / left * np.expm1(-tau / c) ** 4
        variances: NDArray[np.float64] = mean_square / (2.0 * tau**2)
        return variances


@dataclass(frozen=True, slots=True, kw_only=True)
class DriftSearch:
    """The course that was recognised, if any, with its amplitude.

    `ambiguity` is by how much of deviance the record is likelier with a random walk than with a
    drift in its place: infinite where a drift was recognised, since then both are fitted.
    """

    course: Course | None
    amplitude: float
    ambiguity: float


def courses(modes: SlowModes) -> tuple[Course, ...]:
    """Return the courses that are looked for: a linear one, and exponentials of log-spaced time constants."""
    middles = (np.arange(modes.blocks) + 0.5) / modes.blocks
    linear = Course(kind=DriftKind.LINEAR, constant=None, modes=modes.of_course(middles))
    return (linear, *_exponentials(modes, np.array(_TIME_CONSTANTS)))


def _exponentials(modes: SlowModes, constants: NDArray[np.float64]) -> tuple[Course, ...]:
    edges = np.linspace(0.0, 1.0, modes.blocks + 1)
    column = constants[:, np.newaxis]
    means = -np.diff(np.exp(-edges / column)) * column * modes.blocks
    return tuple(
        Course(kind=DriftKind.EXPONENTIAL, constant=float(constant), modes=one)
        for constant, one in zip(constants, modes.of_course(means), strict=True)
    )


def search_drift(solution: Solution, modes: SlowModes, candidates: tuple[Course, ...]) -> DriftSearch:
    """Look for a drift beyond the noise of a solution that was fitted without one.

    A linear one is recognised where it makes the record likelier by a deviance of 9.2 (chance does
    once in 400), an exponential one where it does by 4 more than a linear one.
    """
    likelihood, state = solution.likelihood, solution.state
    still = likelihood.minimise(_without_walk(state.squares), _NO_WALK)
    linear, *curved = candidates
    likeliest = {_likeliest(likelihood, one, curved) for one in (state, still)}
    straight = _with(likelihood, linear).minimise(state.squares, _ALL)
    bent = [
        (curved[which], _with(likelihood, curved[which]).minimise(state.squares, _ALL))
        for which in likeliest
    ]
    best = min(bent, key=lambda one: one[1].deviance)
    gained, bending = state.deviance - straight.deviance, straight.deviance - best[1].deviance
    if gained + bending > _RECOGNISED + _CURVED and bending > _CURVED:
        course, fitted = _refined(likelihood, modes, *best)
        return DriftSearch(course=course, amplitude=fitted.drift, ambiguity=np.inf)
    if gained > _RECOGNISED:
        return DriftSearch(course=linear, amplitude=straight.drift, ambiguity=np.inf)
    without_walk = min(_deviances_without_walk(likelihood, still, linear, curved))
    return DriftSearch(course=None, amplitude=0.0, ambiguity=without_walk - state.deviance)


def _deviances_without_walk(
    likelihood: Likelihood, still: State, linear: Course, curved: list[Course]
) -> Iterator[float]:
    bent = curved[_likeliest(likelihood, still, curved)]
    for course, penalty in ((linear, 0.0), (bent, _CURVED_WITHOUT_WALK)):
        yield _with(likelihood, course).minimise(still.squares, _NO_WALK).deviance + penalty


def _likeliest(likelihood: Likelihood, state: State, candidates: list[Course]) -> int:
    return int(np.argmax(_explained(likelihood, state, candidates)))


def _explained(
    likelihood: Likelihood, state: State, candidates: Sequence[Course]
) -> NDArray[np.float64]:
    """Return how much of chi-square each course (k,) explains, the noise as it is."""
    variance = likelihood.mode_variance @ state.squares
    shapes = np.array([one.modes for one in candidates])
    explained: NDArray[np.float64] = (shapes @ (likelihood.modes / variance)) ** 2
    return explained / ((shapes**2) @ (1.0 / variance))


def _refined(
    likelihood: Likelihood, modes: SlowModes, course: Course, state: State
) -> tuple[Course, State]:
    """Find the time constant between those looked for, by parabolas through ever closer ones."""
    for reach in _CLOSER:
        around = _exponentials(modes, course.time_constant * np.exp(reach * _AROUND))
        low, middle, high = _explained(likelihood, state, around)
        bend = max(2.0 * middle - low - high, abs(high - low) / 2.0)
        move = 0.5 * reach * (high - low) / bend if bend > 0.0 else 0.0
        (course,) = _exponentials(modes, np.array([course.time_constant * np.exp(move)]))
        state = _with(likelihood, course).minimise(state.squares, _ALL)
    return course, state


def _with(likelihood: Likelihood, course: Course) -> Likelihood:
    return replace(likelihood, course=course.modes)


def _without_walk(squares: NDArray[np.float64]) -> NDArray[np.float64]:
    start = squares.copy()
    start[_WALK] = 0.0
    return start


def found_drift(course: Course, solution: Solution, duration_s: float) -> Drift:
    """Return a recognised course as a drift of the record."""
    sigma = float(np.sum(course.modes**2 / solution.mode_variance())) ** -0.5
    return Drift(
        kind=course.kind,
        change_dps=solution.state.drift * course.change,
        standard_uncertainty_dps=sigma * abs(course.change),
        time_constant_s=None if course.constant is None else course.constant * duration_s,
    )
