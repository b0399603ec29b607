"""A sensor of several axes at rest in six positions: bias and what goes with gravity, by least squares."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gyrotest.errors import InsufficientDataError

_Array = NDArray[np.float64]
_FEWEST = 4
_RANK = 1e-6


@dataclass(frozen=True, slots=True, kw_only=True)
class Positions:
    """What each of c channels gives at rest: U = `bias` + `sensitivity`·a, a in g along the own axes.

    `bias` (c,) and `sensitivity` (c, 3), per g, are in the channels' unit; `covariance` (c, 4, 4) is that
    of the bias and the three sensitivities of each channel. `residuals` (k, c) are what the positions
    leave, `residual_freedom` their degrees of freedom, by which `misfit` (c,) is their reduced χ².
    """

    bias: _Array
    sensitivity: _Array
    covariance: _Array
    residuals: _Array
    residual_freedom: int
    misfit: _Array


def six_positions(
    outputs: _Array, forces_g: _Array, covariance: _Array, *, unknown_rate: _Array | None = None
) -> Positions:
    """Fit the mean outputs in positions with each own axis up and down: the conventional static method.

    Parameters
    ----------
    outputs
        Shape (k, c): the mean of each channel in each of k positions, four at least, commonly six.
    forces_g
        Shape (k, 3): the specific force along the own axes, in g; +1 along an axis that points up.
    covariance
        Shape (c, k, k): covariance of each channel's means by their noise.
    unknown_rate
        Shape (c,): half-width of what each channel gives in every position by a rate that is not taken off,
        such as the Earth's where the positions are not related to north; None: nothing.

    Raises
    ------
    InsufficientDataError
        Fewer than four positions, or positions that do not tell the three axes and the bias apart.

    Notes
    -----
    S5.1 at rest, with weights V⁻¹; of a gyro `sensitivity` is ζ, of an accelerometer its diagonal are the
    scale factors and the rest is cross-axis sensitivity. Where the positions leave more than their noise
    (reduced χ² above 1) the covariance is larger in proportion: what moved the positions is in it. A rate
    that is not known adds a third of its square to the variance of each coefficient: up and down it may
    have opposite signs, as gravity has.
    """
    count = outputs.shape[0]
    if count < _FEWEST:
        raise InsufficientDataError(f"{count} positions for four coefficients; commonly there are six")
    design = np.column_stack((np.ones(count), forces_g))
    sizes = np.linalg.svd(design, compute_uv=False)
    if not sizes[-1] > _RANK * sizes[0]:
        raise InsufficientDataError(
            "the positions do not tell bias and three axes apart: each axis must point up in one and down in"
            " another"
        )
    rates = np.zeros(outputs.shape[1]) if unknown_rate is None else unknown_rate
    fits = [
        _fitted(channel, design, noise, float(rate))
        for channel, noise, rate in zip(outputs.T, covariance, rates, strict=True)
    ]
    found = np.stack([one.coefficients for one in fits])
    return Positions(
        bias=found[:, 0],
        sensitivity=found[:, 1:],
        covariance=np.stack([one.covariance for one in fits]),
        residuals=outputs - design @ found.T,
        residual_freedom=count - _FEWEST,
        misfit=np.array([one.misfit for one in fits]),
    )


@dataclass(frozen=True, slots=True, kw_only=True)
class _Channel:
    coefficients: _Array
    covariance: _Array
    misfit: float


def _fitted(outputs: _Array, design: _Array, noise: _Array, unknown_rate: float) -> _Channel:
    precision = np.linalg.inv(noise)
    covariance = np.linalg.inv(design.T @ precision @ design)
    coefficients = covariance @ design.T @ precision @ outputs
    left = outputs - design @ coefficients
    freedom = outputs.size - design.shape[1]
    misfit = float(left @ precision @ left) / freedom if freedom else 0.0
    return _Channel(
        coefficients=coefficients,
        covariance=covariance * max(misfit, 1.0) + np.eye(_FEWEST) * unknown_rate**2 / 3.0,
        misfit=misfit,
    )
