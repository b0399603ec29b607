"""A temperature that was recorded beside the output: an axis's own before one for all."""

from gyrotest.records.recording import Sampling
from gyrotest.units import same_dimension

SENSOR = "temperature"
"""The name of the auxiliary channel; that of an axis's own has the axis behind it, `temperature_x`."""


def sensor_column(sampling: Sampling, axis: str) -> int | None:
    """Return the column of a recorded temperature in °C; None where there is none."""
    for name in (f"{SENSOR}_{axis}", SENSOR):
        for place, one in enumerate(sampling.auxiliary, start=len(sampling.channels)):
            if one.name == name and same_dimension(one.unit, "degC"):
                return place
    return None
