"""Compensation: fitted scale factor and bias applied to a verification run on the rate table."""

from gyrotest.procedures.compensation.parameters import CompensationParameters
from gyrotest.procedures.compensation.procedure import Compensation

__all__ = ["Compensation", "CompensationParameters"]
