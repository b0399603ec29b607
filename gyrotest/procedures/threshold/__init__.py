"""Threshold and resolution: the smallest input, and the smallest change of one, that the output follows."""

from gyrotest.procedures.threshold.parameters import ResolutionParameters, ThresholdParameters
from gyrotest.procedures.threshold.procedure import Resolution, Threshold

__all__ = ["Resolution", "ResolutionParameters", "Threshold", "ThresholdParameters"]
