"""Acceleration-sensitive drift on a level shaft: the model, and its fit to the output over the angle."""

from dataclasses import dataclass
from enum import IntEnum

import numpy as np
from numpy.typing import NDArray

from gyrotest.analysis.level_shaft import Circle, ShaftPose, earth_rate_dps, specific_force_g
from gyrotest.analysis.wandering_fit import Spans, WanderingFit, wandering_fit

_Array = NDArray[np.float64]
_TURNS = 1e-3


class Term(IntEnum):
    """The columns of the model: bias, what goes with the force along the stage's x and z, the turning."""

    BIAS = 0
    ALONG_X = 1
    ALONG_Z = 2
    TURNING = 3


@dataclass(frozen=True, slots=True, kw_only=True)
class Arcs:
    """Where the shaft was while each of the values (m,) was averaged.

    `circle` are the means of cosine and sine of its angle over the `spans`, `rate_dps` (m,) the mean
    rate at which it turned.
    """

    spans: Spans
    circle: Circle
    rate_dps: _Array

    @property
    def turns(self) -> bool:
        """Whether the shaft turned at different rates, so that what follows the rate can be told."""
        return float(np.ptp(self.rate_dps)) > _TURNS


@dataclass(frozen=True, slots=True, kw_only=True)
class ShaftModel:
    """What a sensor on a shaft gives out: bias + p·a_x + q·a_z + ε·ω, and the Earth's rate along it.

    `sensitive` (3,) is its sensitive axis by its components along the stage's axes; None: it senses no
    rotation, as an accelerometer.
    """

    pose: ShaftPose
    sensitive: _Array | None

    def earth_dps(self, arcs: Arcs) -> _Array:
        """Return the Earth's rate along the sensitive axis (m,)."""
        if self.sensitive is None:
            return np.zeros(arcs.rate_dps.size)
        share: _Array = earth_rate_dps(self.pose, arcs.circle) @ self.sensitive
        return share

    def design(self, arcs: Arcs) -> _Array:
        """Return the columns of the model (m, 4), or (m, 3) where the shaft stood at every angle."""
        force = specific_force_g(self.pose, arcs.circle)
        columns = [np.ones(arcs.rate_dps.size), force[:, 0], force[:, 2]]
        if arcs.turns:
            columns.append(arcs.rate_dps)
        return np.column_stack(columns)


@dataclass(frozen=True, slots=True, kw_only=True)
class ShaftFit:
    """A model fitted to the values over some arcs; `values` are less the Earth's rate.

    The coefficients are those of `Term`, in the unit of the values, those along x and z per g.
    """

    model: ShaftModel
    arcs: Arcs
    values: _Array
    fit: WanderingFit

    @property
    def coefficients(self) -> _Array:
        """The coefficients (4,), or (3,) where the shaft did not turn."""
        return self.fit.coefficients

    @property
    def drift(self) -> _Array:
        """What is left of the values (m,) without bias and cross-axis term: the drift by gravity, and noise."""
        kept = [place for place in range(self.coefficients.size) if place not in _BY_GRAVITY]
        design = self.model.design(self.arcs)[:, kept]
        left: _Array = self.values - design @ self.coefficients[kept]
        return left

    def along(self, own_axis: _Array) -> _Array:
        """Return the factors of the coefficients that give the one along an axis (3,) across the shaft."""
        functional = np.zeros(self.coefficients.size)
        functional[Term.ALONG_X], functional[Term.ALONG_Z] = own_axis[0], own_axis[2]
        return functional


_BY_GRAVITY = (Term.ALONG_X, Term.ALONG_Z)


def fit_shaft(values: _Array, arcs: Arcs, model: ShaftModel, *, since_s: float = 0.0) -> ShaftFit:
    """Fit the output of a sensor on a level shaft over the angle, turning or standing.

    Parameters
    ----------
    values
        Shape (m,): means of the output as a rate, °/s, or of an accelerometer's in any unit.
    arcs
        Where the shaft was meanwhile.
    model
        How the shaft lies and which axis senses.
    since_s
        Time from power-on to the first value.

    Raises
    ------
    InsufficientDataError
        Too few values, or angles that do not tell the coefficients apart.

    Notes
    -----
    S5.1 to S5.4: F/SF − Ω(θ) = B + p·a_x + q·a_z + ε·ω + noise, where p and q are the coefficients along
    the stage's axes. The force along the shaft is constant, and its part of the drift is in the bias.
    Least squares among noise that wanders (`gyrotest.analysis.wandering_fit`).
    """
    left = values - model.earth_dps(arcs)
    fit = wandering_fit(left, model.design(arcs), arcs.spans, since_s=since_s)
    return ShaftFit(model=model, arcs=arcs, values=left, fit=fit)


@dataclass(frozen=True, slots=True, kw_only=True)
class Harmonic:
    """The amplitude of a harmonic of the angle in what a fit leaves, and its standard uncertainty."""

    amplitude: float
    uncertainty: float


def second_harmonic(found: ShaftFit) -> Harmonic:
    """Return what goes with twice the angle: drift that follows the square of gravity, or an encoder's error.

    Fitted with the other coefficients and the same weights.
    """
    circle = found.arcs.circle
    square = circle.cosine**2 + circle.sine**2
    twice = np.column_stack(
        ((circle.cosine**2 - circle.sine**2) / square, 2.0 * circle.cosine * circle.sine / square)
    )
    design = np.column_stack((found.model.design(found.arcs), twice))
    precision = np.linalg.inv(found.fit.noise_covariance)
    covariance = np.linalg.pinv(design.T @ precision @ design)[-2:, -2:]
    both = (np.linalg.pinv(design.T @ precision @ design) @ design.T @ precision @ found.values)[-2:]
    return Harmonic(
        amplitude=float(np.hypot(*both)), uncertainty=float(np.sqrt(np.linalg.eigvalsh(covariance)[-1]))
    )
