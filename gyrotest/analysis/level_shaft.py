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


@dataclass(frozen=True, slots=True, kw_only=True)
class Circle:
    """Cosines and sines (n,) of angles of the shaft, or their means over the while that a value is of."""

    cosine: _Array
    sine: _Array

    @classmethod
    def of(cls, angle_deg: NDArray[np.float64]) -> "Circle":
        """Those of single angles (n,)."""
        angle = np.radians(angle_deg)
        return cls(cosine=np.cos(angle), sine=np.sin(angle))

    def shifted(self, by_deg: NDArray[np.float64] | float) -> "Circle":
        """The angles larger by as much: all by the same, or each by its own (n,)."""
        by = np.radians(by_deg)
        cosine, sine = np.cos(by), np.sin(by)
        return Circle(
            cosine=self.cosine * cosine - self.sine * sine, sine=self.sine * cosine + self.cosine * sine
        )


def specific_force_g(pose: ShaftPose, angle: NDArray[np.float64] | Circle) -> _Array:
    """Return the specific force at rest along the stage's axes, in g: +1 along one that points up.

    Parameters
    ----------
    angle
        Shape (n,), °, or the circle of n angles.

    Returns
    -------
    Shape (n, 3).

    Notes
    -----
    S5.2, with the tilt: a_x = −g·sinθ·cosτ, a_y = g·sinτ, a_z = g·cosθ·cosτ. What the turning adds is
    not in it: at 6 °/s and 0.1 m from the shaft 0.1 mg, which turns with the unit and stays constant.
    """
    return pose.gravity_g * _turned(np.array([0.0, 0.0, 1.0]), pose.tilt_deg, angle)


def earth_rate_dps(pose: ShaftPose, angle: NDArray[np.float64] | Circle) -> _Array:
    """Return the Earth's rate along the stage's axes, °/s.

    Parameters
    ----------
    angle
        Shape (n,), °, or the circle of n angles.

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
    return EARTH_RATE_DPS * _turned(level, pose.tilt_deg, angle)


def _turned(level: _Array, tilt_deg: float, angle: NDArray[np.float64] | Circle) -> _Array:
    """Return a vector (3,), given along x, y, z of a level shaft at angle 0, along the axes that turn."""
    circle = angle if isinstance(angle, Circle) else Circle.of(angle)
    tilt = math.radians(tilt_deg)
    x, y, z = level
    along = y * math.cos(tilt) + z * math.sin(tilt)
    upright = z * math.cos(tilt) - y * math.sin(tilt)
    turned: _Array = np.column_stack(
        (
            x * circle.cosine - upright * circle.sine,
            np.full(circle.cosine.shape, along),
            x * circle.sine + upright * circle.cosine,
        )
    )
    return turned
