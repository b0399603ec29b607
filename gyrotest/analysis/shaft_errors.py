"""What errors of a level shaft do to the coefficients that are fitted on it: change the model, fit again.

The fit is linear: where the true model is M' and M was fitted, the coefficients are wrong by W·(M' − M).
"""

import math
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from gyrotest.analysis.g_sensitivity import Arcs, ShaftFit, ShaftModel, Term
from gyrotest.analysis.level_shaft import specific_force_g
from gyrotest.analysis.mounting import SHAFT

_Array = NDArray[np.float64]
_HARMONICS = (1, 2)


@dataclass(frozen=True, slots=True, kw_only=True)
class FittedShaft:
    """A model over arcs, its coefficients (p,) and the weights (p, m) that gave them."""

    model: ShaftModel
    arcs: Arcs
    coefficients: _Array
    weights: _Array

    @classmethod
    def of(cls, found: ShaftFit) -> "FittedShaft":
        """A fit that was made."""
        return cls(
            model=found.model,
            arcs=found.arcs,
            coefficients=found.coefficients,
            weights=np.asarray(found.fit.weights),
        )

    @classmethod
    def even(cls, model: ShaftModel, arcs: Arcs, coefficients: _Array) -> "FittedShaft":
        """A fit that weighs all arcs alike."""
        return cls(
            model=model,
            arcs=arcs,
            coefficients=coefficients,
            weights=np.asarray(np.linalg.pinv(model.design(arcs))),
        )

    def given(self, model: ShaftModel, arcs: Arcs) -> _Array:
        """Return what a sensor with these coefficients would give (m,), as a model has it over arcs."""
        given: _Array = (
            model.earth_dps(arcs) + model.design(arcs)[:, : self.coefficients.size] @ self.coefficients
        )
        return given

    def changed(self, model: ShaftModel, arcs: Arcs) -> _Array:
        """Return by how much the coefficients (p,) are wrong where these were the true ones."""
        apart: _Array = self.weights @ (self.given(model, arcs) - self.given(self.model, self.arcs))
        return apart


def azimuth_error(fitted: FittedShaft, half_width_deg: float) -> _Array:
    """Return the effect (p,) of an azimuth that is larger: the Earth's rate has the shape of gravity (S5.4)."""
    return _posed(fitted, azimuth_deg=fitted.model.pose.azimuth_deg + half_width_deg)


def index_error(fitted: FittedShaft, half_width_deg: float) -> _Array:
    """Return the effect (p,) of angles that are all larger: it mixes the coefficients along x and z."""
    return fitted.changed(fitted.model, _shifted(fitted.arcs, half_width_deg))


def tilt_error(fitted: FittedShaft, half_width_deg: float, along_shaft: float) -> _Array:
    """Return the effect (p,) of a shaft tilted more, to whichever side: gravity along it moves the bias.

    `along_shaft` is the coefficient along the shaft, which no turn about it can tell.
    """
    tilt_deg = fitted.model.pose.tilt_deg
    tilted = replace(fitted.model.pose, tilt_deg=tilt_deg + math.copysign(half_width_deg, tilt_deg))
    effect = _posed(fitted, tilt_deg=tilted.tilt_deg)
    force = specific_force_g(tilted, fitted.arcs.circle)[:, SHAFT]
    moved: _Array = effect + fitted.weights @ (abs(along_shaft) * force)
    return moved


def encoder_errors(fitted: FittedShaft, half_width_deg: float) -> tuple[_Array, ...]:
    """Return the effects (2, p) of errors of the angle that go with it or with twice it, of either phase.

    What the error does to the measured rate of turning is in it.
    """
    mid = np.arctan2(fitted.arcs.circle.sine, fitted.arcs.circle.cosine)
    return tuple(
        np.stack(
            [_encoded(fitted, half_width_deg, order, order * mid + phase) for phase in (0.0, np.pi / 2)]
        )
        for order in _HARMONICS
    )


def timing_error(fitted: FittedShaft, half_width_s: float) -> _Array:
    """Return the effect (p,) of an angle that is sampled later than the output."""
    return fitted.changed(fitted.model, _shifted(fitted.arcs, -half_width_s * fitted.arcs.rate_dps))


def gain_error(fitted: FittedShaft, share: float, offset: float = 0.0) -> _Array:
    """Return the effect (p,) of outputs that are larger in proportion, `offset` having been taken off them."""
    effect: _Array = share * (fitted.weights @ (fitted.given(fitted.model, fitted.arcs) + offset))
    return effect


def placement_error(
    fitted: FittedShaft, half_width_deg: float, axes: _Array, own: _Array, about: int
) -> _Array:
    """Return the effect (p,) of a unit that is turned more about its own sensitive axis.

    Parameters
    ----------
    axes
        Shape (3, 3): its own axes in the stage's.
    own
        Shape (3,): its coefficients along its own axes.
    about
        Place of the sensitive axis among them.
    """
    angle = math.radians(half_width_deg)
    first, second = (about + 1) % 3, (about + 2) % 3
    turned = axes.copy()
    turned[first] = math.cos(angle) * axes[first] + math.sin(angle) * axes[second]
    turned[second] = math.cos(angle) * axes[second] - math.sin(angle) * axes[first]
    along_stage = own @ turned - own @ axes
    effect = np.zeros(fitted.coefficients.size)
    effect[Term.ALONG_X], effect[Term.ALONG_Z] = along_stage[0], along_stage[2]
    return effect


def _posed(fitted: FittedShaft, **changes: float) -> _Array:
    model = replace(fitted.model, pose=replace(fitted.model.pose, **changes))
    return fitted.changed(model, fitted.arcs)


def _shifted(arcs: Arcs, by_deg: _Array | float) -> Arcs:
    return replace(arcs, circle=arcs.circle.shifted(by_deg))


def _encoded(fitted: FittedShaft, half_width_deg: float, order: int, phase: _Array) -> _Array:
    steeper = order * math.radians(half_width_deg) * np.cos(phase)
    arcs = replace(
        _shifted(fitted.arcs, half_width_deg * np.sin(phase)),
        rate_dps=fitted.arcs.rate_dps * (1.0 + steeper),
    )
    return fitted.changed(fitted.model, arcs)
