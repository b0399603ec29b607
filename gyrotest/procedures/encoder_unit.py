"""The unit in which an encoder's angle is recorded."""

from gyrotest.errors import InsufficientDataError
from gyrotest.records.plan import Context
from gyrotest.records.recording import ENCODER_ANGLE, Sampling
from gyrotest.units import Dimension, conversion_factor, printed_unit, same_dimension


def encoder_unit_deg(sampling: Sampling, context: Context) -> float:
    """Return what 1 of the encoder's angle is, °; raises `InsufficientDataError` where it is none of an angle."""
    unit = next(one.unit for one in sampling.auxiliary if one.name == ENCODER_ANGLE)
    if not same_dimension(unit, Dimension.ANGLE):
        raise InsufficientDataError(
            f"{context.case_name}: the encoder's angle comes in '{printed_unit(unit)}', which is none of an angle;"
            " correct the channel's unit, or its name, in the station"
        )
    return conversion_factor(unit, "deg")
