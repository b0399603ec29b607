"""Scale-factor test: the output over the rate of a rate table."""

from gyrotest.procedures.scale_factor.parameters import ScaleFactorParameters
from gyrotest.procedures.scale_factor.procedure import ScaleFactor

__all__ = ["ScaleFactor", "ScaleFactorParameters"]
