"""Gravity where a bench stands: the normal one, by the latitude."""

import math

STANDARD_GRAVITY = 9.80665
"""What 1 g is, m/s²."""

_EQUATOR, _POLE = 9.7803253359, 9.8321849379
_SEMI_MAJOR, _SEMI_MINOR = 6378137.0, 6356752.3142


def normal_gravity_g(latitude_deg: float) -> float:
    """Return the normal gravity at sea level, in units of standard gravity.

    Parameters
    ----------
    latitude_deg
        Geographic latitude; its sign does not matter.

    Notes
    -----
    Somigliana's formula on the ellipsoid of WGS 84. A thousand metres of height take 0.03 % off it, and
    what the ground adds is smaller.
    """
    square = math.sin(math.radians(latitude_deg)) ** 2
    ratio = (_SEMI_MINOR * _POLE) / (_SEMI_MAJOR * _EQUATOR) - 1.0
    eccentricity = 1.0 - (_SEMI_MINOR / _SEMI_MAJOR) ** 2
    gravity = _EQUATOR * (1.0 + ratio * square) / math.sqrt(1.0 - eccentricity * square)
    return gravity / STANDARD_GRAVITY
