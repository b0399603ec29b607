"""Random vibration: sensitivity and phase over a band of frequencies, against an encoder."""

from gyrotest.procedures.random_vibration.parameters import RandomVibrationParameters
from gyrotest.procedures.random_vibration.procedure import RandomVibration

__all__ = ["RandomVibration", "RandomVibrationParameters"]
