"""Measurement range: the highest rates at which the output stays on the line."""

from gyrotest.procedures.full_scale.parameters import FullScaleParameters
from gyrotest.procedures.full_scale.procedure import FullScale

__all__ = ["FullScale", "FullScaleParameters"]
