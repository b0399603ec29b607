"""A level shaft that turns: gravity and the Earth's rate in the axes of what turns with it.

At the angle 0 the stage's z axis points up and its x axis horizontally to an azimuth; y is the shaft,
about which angles count right-handed.
"""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gyrotest.analysis.earth import EARTH_RATE_DPS
from gyrotest.analysis.gravity import normal_gravity_g

_Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True, kw_only=True)
class ShaftPose:
    """Where a shaft is and how it lies: `tilt_deg` is how far its y end lies above the horizontal.

    `azimuth_deg` is where x points at angle 0, clockwise from true north.
    """

    latitude_deg: float
    azimuth_deg: float
    tilt_deg: float = 0.0

    @property
    def gravity_g(self) -> float:
        """The gravity here, in units of standard gravity."""
        return normal_gravity_g(self.latitude_deg)


def specific_force_g(pose: ShaftPose, angle_deg: NDArray[np.float64]) -> _Array:
    """Return the specific force at rest along the stage's axes, in g: +1 along one that points up.

    Parameters
    ----------
    angle_deg
        Shape (n,).

    Returns
    -------
    Shape (n, 3).

    Notes
    -----
    S5.2, with the tilt: a_x = −g·sinθ·cosτ, a_y = g·sinτ, a_z = g·cosθ·cosτ. What the turning adds is
    not in it: at 6 °/s and 0.1 m from the shaft 0.1 mg, which turns with the unit and stays constant.
    """
    return pose.gravity_g * _turned(np.array([0.0, 0.0, 1.0]), pose.tilt_deg, angle_deg)


def earth_rate_dps(pose: ShaftPose, angle_deg: NDArray[np.float64]) -> _Array:
    """Return the Earth's rate along the stage's axes, °/s.

    Parameters
    ----------
    angle_deg
        Shape (n,).

    Returns
    -------
    Shape (n, 3).

    Notes
    -----
    S5.4, with the tilt: of a level shaft Ω_x = Ω_E(cosφ·cosA·cosθ − sinφ·sinθ),
    Ω_z = Ω_E(cosφ·cosA·sinθ + sinφ·cosθ), and Ω_y = Ω_E·cosφ·sinA.
    """
    latitude, azimuth = math.radians(pose.latitude_deg), math.radians(pose.azimuth_deg)
    north, up = math.cos(latitude), math.sin(latitude)
    level = np.array([north * math.cos(azimuth), north * math.sin(azimuth), up])
    return EARTH_RATE_DPS * _turned(level, pose.tilt_deg, angle_deg)


def _turned(level: _Array, tilt_deg: float, angle_deg: NDArray[np.float64]) -> _Array:
    """Return a vector (3,), given along x, y, z of a level shaft at angle 0, along the axes that turn."""
    tilt = math.radians(tilt_deg)
    x, y, z = level
    along = y * math.cos(tilt) + z * math.sin(tilt)
    upright = z * math.cos(tilt) - y * math.sin(tilt)
    angle = np.radians(angle_deg)
    cosine, sine = np.cos(angle), np.sin(angle)
    turned: _Array = np.column_stack(
        (x * cosine - upright * sine, np.full(angle.shape, along), x * sine + upright * cosine)
    )
    return turned
