"""The Earth's rate along a gyro's axis."""

import math

EARTH_RATE_DPS = 15.041 / 3600.0


def earth_share_dps(
    axis: tuple[float, float, float] | None, *, latitude_deg: float | None, heading_deg: float | None
) -> float | None:
    """Return the Earth's rate along an axis, °/s; None where what is known does not settle it.

    Parameters
    ----------
    axis
        The sensitive axis in the bench's frame (up, north, east); of any length but 0.
    latitude_deg
        North positive.
    heading_deg
        Where the bench's north points, clockwise from true north; needed for a horizontal part.
    """
    if axis is None or latitude_deg is None:
        return None
    up, north, east = axis
    length = math.sqrt(up**2 + north**2 + east**2)
    if length == 0.0:
        return None
    vertical = up * math.sin(math.radians(latitude_deg))
    if math.hypot(north, east) <= 1e-9 * length:
        return EARTH_RATE_DPS * vertical / length
    if heading_deg is None:
        return None
    heading = math.radians(heading_deg)
    true_north = north * math.cos(heading) - east * math.sin(heading)
    return EARTH_RATE_DPS * (vertical + true_north * math.cos(math.radians(latitude_deg))) / length
