"""An accelerometer by gravity: scale factor, bias and cross-axis sensitivity, on a shaft or in positions."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gyrotest.analysis.g_sensitivity import ShaftFit, Term
from gyrotest.analysis.six_positions import Positions
from gyrotest.errors import InsufficientDataError

_Array = NDArray[np.float64]
_DEAF = 5.0


@dataclass(frozen=True, slots=True, kw_only=True)
class Accelerometer:
    """U = `scale_factor`·(a + `bias_g` + Σ `cross_axis`·a across), each with its standard uncertainty.

    The scale factor is in the output's unit per g, `cross_axis` (k,) numbers: about the angles, in
    radians, by which the sensitive axis leans towards the others.
    """

    scale_factor: float
    scale_factor_uncertainty: float
    bias_g: float
    bias_uncertainty_g: float
    cross_axis: _Array
    cross_axis_uncertainty: _Array


def accelerometer_on_shaft(found: ShaftFit, sensitive: _Array) -> Accelerometer:
    """Return what a shaft that turned or stood shows of an accelerometer across it.

    Parameters
    ----------
    found
        The fit of its output by a model whose own `sensitive` is None: it senses no rotation.
    sensitive
        Shape (3,): its sensitive axis by its components along the stage's axes.

    Raises
    ------
    InsufficientDataError
        The output does not follow gravity along that axis.

    Notes
    -----
    S5.6. The one axis across that the shaft shows beside it is at a right angle to both.
    """
    across = np.array([-sensitive[2], 0.0, sensitive[0]])
    rows = np.zeros((3, found.coefficients.size))
    rows[0, Term.BIAS] = 1.0
    rows[1], rows[2] = found.along(sensitive), found.along(across)
    return _of(rows @ found.coefficients, rows @ found.fit.covariance @ rows.T)


def accelerometer_in_positions(found: Positions, channel: int, sensitive: int) -> Accelerometer:
    """Return what positions show of the accelerometer of a channel, the place of whose own axis is `sensitive`.

    Raises
    ------
    InsufficientDataError
        The output does not follow gravity along that axis.
    """
    order = [0, 1 + sensitive, *(1 + place for place in range(3) if place != sensitive)]
    coefficients = np.append(found.bias[channel], found.sensitivity[channel])[order]
    return _of(coefficients, found.covariance[channel][np.ix_(order, order)])


def _of(coefficients: _Array, covariance: _Array) -> Accelerometer:
    """Divide offset and cross-axis sensitivities, which stand about it, by the scale factor in place 1."""
    scale_factor, standard = float(coefficients[1]), float(np.sqrt(covariance[1, 1]))
    if abs(scale_factor) < _DEAF * standard:
        raise InsufficientDataError(
            f"the output follows gravity along its axis by {scale_factor:.3g} a g, with a standard uncertainty of"
            f" {standard:.2g}: is it an accelerometer, and this its axis?"
        )
    ratios = coefficients / scale_factor
    # Of each ratio r = c/SF: u² = (V_cc − 2r·V_c,SF + r²·V_SF)/SF².
    variance = np.diag(covariance) - 2.0 * ratios * covariance[1] + ratios**2 * covariance[1, 1]
    uncertainty = np.sqrt(np.maximum(variance, 0.0)) / abs(scale_factor)
    return Accelerometer(
        scale_factor=scale_factor,
        scale_factor_uncertainty=standard,
        bias_g=float(ratios[0]),
        bias_uncertainty_g=float(uncertainty[0]),
        cross_axis=ratios[2:],
        cross_axis_uncertainty=uncertainty[2:],
    )
