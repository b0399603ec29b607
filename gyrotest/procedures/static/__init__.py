"""Static test: bias, bias stability, Allan deviation and noise coefficients of a gyro at rest."""

from gyrotest.procedures.static.parameters import StaticParameters
from gyrotest.procedures.static.procedure import Static

__all__ = ["Static", "StaticParameters"]
