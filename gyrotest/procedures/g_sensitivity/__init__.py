"""g-sensitivity: the drift of a gyro that follows gravity, on a level shaft."""

from gyrotest.procedures.g_sensitivity.parameters import GSensitivityParameters
from gyrotest.procedures.g_sensitivity.procedure import GSensitivity

__all__ = ["GSensitivity", "GSensitivityParameters"]
