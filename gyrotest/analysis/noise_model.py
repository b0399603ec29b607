"""A record's noise as a model: five coefficients, spectral lines, a drift, and how well they fit."""

from dataclasses import dataclass
from enum import Enum

import numpy as np
from numpy.typing import NDArray

from gyrotest.analysis.noise_terms import Grid, allan_columns

_PRUDENCE = 0.12
_CARRIES = 1.0 / 3.0


@dataclass(frozen=True, slots=True, kw_only=True)
class TauRange:
    """Averaging times from `first_s` to `last_s`, both included."""

    first_s: float
    last_s: float


@dataclass(frozen=True, slots=True, kw_only=True)
class NoiseTerm:
    """A coefficient with its standard uncertainty and its 68 % and 95 % intervals.

    Where the record does not resolve the term (`resolved` is False) `lower_95` is 0 and `upper_95` a
    limit; `value` is then no more than the fit's best guess, which may be 0, and
    `standard_uncertainty` is `upper_95`/1.96. `lower_68` may lie above 0 all the same. `carries` are
    the averaging times at which the term makes up at least a third of the fitted Allan variance; None
    where there are none.
    """

    value: float
    standard_uncertainty: float
    lower_68: float
    upper_68: float
    lower_95: float
    upper_95: float
    resolved: bool
    carries: TauRange | None


@dataclass(frozen=True, slots=True, kw_only=True)
class SpectralLine:
    """A line that stands out of the noise: a sine of `amplitude_dps` (peak) at `frequency_hz`.

    `standard_uncertainty_dps` belongs to the amplitude.
    """

    frequency_hz: float
    amplitude_dps: float
    standard_uncertainty_dps: float


class DriftKind(Enum):
    """The course of a drift."""

    LINEAR = "linear"
    EXPONENTIAL = "exponential"


@dataclass(frozen=True, slots=True, kw_only=True)
class Drift:
    """A drift that noise does not explain.

    `change_dps` is the drift's value at the record's end less that at its begin, with its standard
    uncertainty; `time_constant_s` is None of a linear one.
    """

    kind: DriftKind
    change_dps: float
    standard_uncertainty_dps: float
    time_constant_s: float | None


@dataclass(frozen=True, slots=True, kw_only=True)
class NoiseModel:
    """A record's noise, and the fit that it comes from.

    The angle random walk is the apparent one, as the record shows it: dead time is taken out of it
    afterwards. Units: quantization noise °, angle random walk °/√s, bias instability coefficient
    °/s, rate random walk °/s/√s, rate ramp °/s². `covariance` (5, 5) belongs to their squares, in
    that order. `first_tau_s` … `last_tau_s` were fitted; `misfit` is chi-square over its degrees of
    freedom (about 1 where the model describes the record; uncertainties are widened by its root
    where it is significantly larger) and `fit_probability` how often chance alone fits no better.
    `lines` were kept out of the fit, and so was `drift`.
    """

    quantization_noise: NoiseTerm
    angle_random_walk: NoiseTerm
    bias_instability_coefficient: NoiseTerm
    rate_random_walk: NoiseTerm
    rate_ramp: NoiseTerm
    covariance: NDArray[np.float64]
    lines: tuple[SpectralLine, ...]
    drift: Drift | None
    first_tau_s: float
    last_tau_s: float
    misfit: float
    fit_probability: float
    grid: Grid

    @property
    def terms(self) -> tuple[NoiseTerm, ...]:
        """The five terms in the order of falling slope: Q, N, B, K, R."""
        return (
            self.quantization_noise,
            self.angle_random_walk,
            self.bias_instability_coefficient,
            self.rate_random_walk,
            self.rate_ramp,
        )

    @property
    def squares(self) -> NDArray[np.float64]:
        """The squared coefficients Q², N², B², K², R²."""
        return np.array([term.value**2 for term in self.terms])

    @property
    def prudent_squares(self) -> NDArray[np.float64]:
        """The squared coefficients, with K² an eighth of its standard uncertainty higher.

        For uncertainties: a walk that a record does not resolve is not a walk that is absent.
        """
        squares = self.squares
        squares[3] += _PRUDENCE * np.sqrt(self.covariance[3, 3])
        return squares

    def components_dps(self, averaging_factors: NDArray[np.int64]) -> NDArray[np.float64]:
        """Return each term's Allan deviation, shape (5, k)."""
        components: NDArray[np.float64] = np.sqrt(
            allan_columns(averaging_factors, self.grid) * self.squares
        ).T
        return components

    def allan_deviation_dps(self, averaging_factors: NDArray[np.int64]) -> NDArray[np.float64]:
        """Return the fitted curve, shape (k,)."""
        curve: NDArray[np.float64] = np.sqrt(allan_columns(averaging_factors, self.grid) @ self.squares)
        return curve


def carried_range(tau_s: NDArray[np.float64], share: NDArray[np.float64]) -> TauRange | None:
    """Return the averaging times at which a term's share of the variance is at least a third."""
    carried = tau_s[share >= _CARRIES]
    return TauRange(first_s=float(carried[0]), last_s=float(carried[-1])) if carried.size else None
