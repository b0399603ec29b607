"""Scale factor from what was recorded: beside a reference that moves, and over a turn by a known angle."""

from gyrotest.procedures.scale_factor_recorded.reference import ScaleFactorReference
from gyrotest.procedures.scale_factor_recorded.turn import ScaleFactorTurn

__all__ = ["ScaleFactorReference", "ScaleFactorTurn"]
