"""Bias repeatability: the bias after each of several power cycles, and how it scatters."""

from gyrotest.procedures.bias_repeatability.procedure import (
    BiasRepeatability,
    BiasRepeatabilityParameters,
)

__all__ = ["BiasRepeatability", "BiasRepeatabilityParameters"]
