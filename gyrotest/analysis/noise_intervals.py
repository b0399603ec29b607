"""Bounds of the coefficients of a fit, by likelihood ratio."""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from gyrotest.analysis.drift import Course
from gyrotest.analysis.interval import NORMAL_95
from gyrotest.analysis.likelihood import TERMS, Solution
from gyrotest.analysis.noise_model import NoiseTerm, TauRange
from gyrotest.analysis.profile import (
    NORMAL_95_DEVIANCE,
    ONE_SIGMA_DEVIANCE,
    lower_bound,
    upper_bound,
)

_ANGLE_WALK, _BIAS, _WALK = 1, 2, 3
_OTHERS = (0, 2, 3)
_PLAIN = (ONE_SIGMA_DEVIANCE, NORMAL_95_DEVIANCE)
_IDLE = (1.4, 5.0)  # by simulation: quantiles of the deviance of white noise alone


@dataclass(frozen=True, slots=True, kw_only=True)
class Bounds:
    """A coefficient's value and bounds, squared or not."""

    value: float
    lower_68: float
    upper_68: float
    lower_95: float
    upper_95: float

    def root(self) -> "Bounds":
        """Return the bounds of the root."""
        return Bounds(
            value=self.value**0.5,
            lower_68=self.lower_68**0.5,
            upper_68=self.upper_68**0.5,
            lower_95=self.lower_95**0.5,
            upper_95=self.upper_95**0.5,
        )

    def over(self, duration_s: float) -> "Bounds":
        """Return the bounds divided by a time."""
        return Bounds(
            value=self.value / duration_s,
            lower_68=self.lower_68 / duration_s,
            upper_68=self.upper_68 / duration_s,
            lower_95=self.lower_95 / duration_s,
            upper_95=self.upper_95 / duration_s,
        )

    def term(self, carries: TauRange | None) -> NoiseTerm:
        """Return the bounds as a term; resolved where 95 % exclude 0."""
        resolved = self.lower_95 > 0.0
        width = (self.upper_68 - self.lower_68) / 2.0
        return NoiseTerm(
            value=self.value,
            standard_uncertainty=width if resolved else self.upper_95 / NORMAL_95,
            lower_68=self.lower_68,
            upper_68=self.upper_68,
            lower_95=self.lower_95,
            upper_95=self.upper_95,
            resolved=resolved,
            carries=carries,
        )


def _none_found(sigma: float) -> Bounds:
    """Return the bounds of a squared coefficient that drowns in a filter's share: no more than could be seen."""
    return Bounds(
        value=0.0,
        lower_68=0.0,
        upper_68=ONE_SIGMA_DEVIANCE**0.5 * sigma,
        lower_95=0.0,
        upper_95=NORMAL_95 * sigma,
    )


@dataclass(frozen=True, slots=True, kw_only=True)
class Profiles:
    """A fit whose coefficients are given bounds.

    `values` is the solution whose coefficients are stated: `solution`, or one of fewer terms that is
    about as likely; an interval holds its value in any case. Deviances are divided by `widening`: by
    how much the scatter exceeds the model's. `ambiguity` is by how much of deviance the record is
    likelier than under a drift instead of a random walk.
    """

    solution: Solution
    values: Solution
    widening: float
    ambiguity: float

    def coefficients(self, sigmas: NDArray[np.float64]) -> list[Bounds]:
        """Return the bounds of all squared coefficients, given about their standard uncertainties (4,).

        Flicker noise that is not there, and cannot be negative, pulls at the angle random walk: where
        it is not resolved the walk's deviance reaches further by chance than chi-square.
        """
        about: list[float] = sigmas.tolist()
        found = {which: self._coefficient(which, about[which], _PLAIN) for which in _OTHERS}
        levels = _PLAIN if found[_BIAS].lower_95 > 0.0 else _IDLE
        found[_ANGLE_WALK] = self._coefficient(_ANGLE_WALK, about[_ANGLE_WALK], levels)
        return [found[which] for which in range(TERMS)]

    def _coefficient(self, which: int, sigma: float, levels: tuple[float, float]) -> Bounds:
        value = float(self.solution.state.squares[which])
        if value < 0.0:
            return _none_found(sigma)
        excess = self._excess(which)
        lower_68, lower_95 = (
            0.0
            if which == _WALK and self.ambiguity <= deviance * self.widening
            else lower_bound(excess, value=value, sigma=sigma, deviance=deviance)
            for deviance in levels
        )
        upper_68, upper_95 = (
            upper_bound(excess, value=value, sigma=sigma, deviance=deviance) for deviance in levels
        )
        stated = float(self.values.state.squares[which])
        return Bounds(
            value=stated,
            lower_68=min(lower_68, stated),
            upper_68=max(upper_68, stated),
            lower_95=min(lower_95, lower_68, stated),
            upper_95=max(upper_95, upper_68, stated),
        )

    def _excess(self, which: int) -> Callable[[float], float]:
        others = tuple(one for one in range(TERMS) if one != which)
        start = self.solution.state.squares.copy()

        def excess(square: float) -> float:
            start[which] = square
            found = self.solution.likelihood.minimise(start, others)
            start[:] = found.squares
            return (found.deviance - self.solution.state.deviance) / self.widening

        return excess

    def change(self, linear: Course, recognised: Course | None) -> Bounds:
        """Return the bounds of the change that a ramp makes over the record; its value is 0 unless recognised."""
        given = self.solution.likelihood
        resolved = recognised is not None and recognised.kind is linear.kind
        modes = given.modes if resolved else self.solution.noise_modes()
        likelihood = replace(given, course=linear.modes, modes=modes, restricted=False)
        best = likelihood.minimise(self.solution.state.squares, tuple(range(TERMS)))
        # Not of `best`, whose noise lacks what its ramp has taken.
        variance = self.solution.mode_variance()
        sigma = (self.widening / float(np.sum(linear.modes**2 / variance))) ** 0.5
        start = best.squares.copy()

        def excess(size: float, sign: float) -> float:
            held = replace(likelihood, held=best.drift + sign * size)
            found = held.minimise(start, tuple(range(TERMS)))
            start[:] = found.squares
            return (found.deviance - best.deviance) / self.widening

        sign = 1.0 if best.drift >= 0.0 else -1.0
        reach = {
            deviance: max(
                upper_bound(lambda size: excess(size, sign), value=0.0, sigma=sigma, deviance=deviance),
                sigma * deviance**0.5,
            )
            for deviance in (ONE_SIGMA_DEVIANCE, NORMAL_95_DEVIANCE)
        }
        size = abs(best.drift)
        lower_68, lower_95 = (
            max(size - reach[one], 0.0) if resolved else 0.0
            for one in (ONE_SIGMA_DEVIANCE, NORMAL_95_DEVIANCE)
        )
        return Bounds(
            value=size if resolved else 0.0,
            lower_68=lower_68,
            upper_68=size + reach[ONE_SIGMA_DEVIANCE],
            lower_95=lower_95,
            upper_95=size + reach[NORMAL_95_DEVIANCE],
        )
