"""Frequency response by sines: a frequency after the other, or swept, against the table's encoder."""

from gyrotest.procedures.sine_vibration.parameters import SineVibrationParameters
from gyrotest.procedures.sine_vibration.procedure import SineVibration

__all__ = ["SineVibration", "SineVibrationParameters"]
