"""What a simulated gyro makes of an input rate, without noise: the check on what procedures find."""

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True, slots=True, kw_only=True)
class Response:
    """One axis's response to an input rate.

    The output is `scale_factor · clip(R(ω) + bias, ±saturation) + zero_rate`, where
    `R(ω) = ω·(1 + sgn(ω)·asymmetry/2) + nonlinearity·full_scale·(ω/full_scale)³`.
    Both departures are ratios; the scale factor is signed, in output units per deg/s.
    """

    scale_factor: float
    zero_rate: float
    full_scale_dps: float
    nonlinearity: float
    asymmetry: float
    saturation_dps: float

    def felt_dps(self, rate_dps: NDArray[np.float64]) -> NDArray[np.float64]:
        """What the element makes of input rates, `R(ω)`, of any shape."""
        cubic = self.nonlinearity * (rate_dps / self.full_scale_dps) ** 2
        return np.asarray(rate_dps * (1.0 + 0.5 * self.asymmetry * np.sign(rate_dps) + cubic))

    def output(self, rate_dps: NDArray[np.float64], *, bias_dps: float = 0.0) -> NDArray[np.float64]:
        """The noise-free output at input rates, of any shape, in the output's unit."""
        total = np.clip(self.felt_dps(rate_dps) + bias_dps, -self.saturation_dps, self.saturation_dps)
        return np.asarray(self.scale_factor * total + self.zero_rate)


def response_of(truth: Mapping[str, float], axis: str = "") -> Response:
    """The response by the true figures that a simulated bench tells of a unit's axis."""
    prefix = f"{axis}." if axis else ""
    return Response(
        scale_factor=truth[f"{prefix}scale_factor"],
        zero_rate=truth[f"{prefix}zero_rate"],
        full_scale_dps=truth.get(f"{prefix}full_scale_dps", math.inf),
        nonlinearity=truth[f"{prefix}nonlinearity"],
        asymmetry=truth[f"{prefix}asymmetry"],
        saturation_dps=truth.get(f"{prefix}saturation_dps", math.inf),
    )
