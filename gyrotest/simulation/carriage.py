"""How a unit's axes sit on what turns them: their shares of the turning, of the Earth's rate and of gravity.

Reckoned by vectors and with constants of its own, not by `gyrotest.analysis`, which is held against it.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gyrotest.records.station import Site

# One turn a sidereal day of 86164.0905 s.
_EARTH_DPS = 360.0 / 86164.0905
_UP = (1.0, 0.0, 0.0)
# Where the axes of a unit point whose mounting is not known, from its last axis backwards.
_PLAIN = (_UP, (0.0, 0.0, 1.0), (0.0, 1.0, 0.0))
_OWN_AXES = "xyz"
ONLY_AXIS = "x"
"""The own axis that a gyro of a single axis senses, where nothing says which."""
# Of the normal gravity (WGS 84): at the equator, in units of 9.80665 m/s², and its two constants.
_EQUATOR_G, _FORMULA, _ECCENTRICITY = 9.7803253359 / 9.80665, 0.00193185265241, 0.00669437999014

Direction = NDArray[np.float64]


@dataclass(frozen=True, slots=True, kw_only=True)
class Swing:
    """What stays in space, along an axis that turns by `θ`: `constant + cosine·cos θ + sine·sin θ`."""

    constant: float = 0.0
    cosine: float = 0.0
    sine: float = 0.0

    def mean(self, from_deg: NDArray[np.float64], to_deg: NDArray[np.float64]) -> Direction:
        """The mean while the axis turns evenly from one angle to another."""
        if self.cosine == 0.0 and self.sine == 0.0:
            return np.full(from_deg.shape, self.constant)
        middle, way = np.radians(0.5 * (from_deg + to_deg)), (to_deg - from_deg) / 360.0
        swing = self.cosine * np.cos(middle) + self.sine * np.sin(middle)
        return np.asarray(self.constant + swing * np.sinc(way))

    @property
    def at_rest(self) -> float:
        """What it is at the angle 0."""
        return self.constant + self.cosine


@dataclass(frozen=True, slots=True, kw_only=True)
class Carriage:
    """How an axis sits on the table: its share of the table's rate, and of the Earth's, deg/s.

    The latter at a table angle `θ` is `earth_dps + earth_cos_dps·cos θ + earth_sin_dps·sin θ`. `force_g`
    is the specific force along the unit's own axes, by their names, as far as it is known. `staged`: on a
    stage that turns it in gravity, whose effect is told apart from the bias there and is part of it elsewhere.
    """

    table_share: float
    earth_dps: float
    earth_cos_dps: float = 0.0
    earth_sin_dps: float = 0.0
    force_g: Mapping[str, Swing] | None = None
    staged: bool = False

    def earth_at_dps(self, from_deg: NDArray[np.float64], to_deg: NDArray[np.float64]) -> Direction:
        """The mean of the Earth's share while the table turns evenly from one angle to another."""
        return self._earth.mean(from_deg, to_deg)

    @property
    def at_rest_dps(self) -> float:
        """The Earth's share at the table's angle 0."""
        return self._earth.at_rest

    @property
    def _earth(self) -> Swing:
        return Swing(constant=self.earth_dps, cosine=self.earth_cos_dps, sine=self.earth_sin_dps)

    def felt_dps(self, sensitivity_dps_per_g: Mapping[str, float]) -> Swing:
        """What the specific force along the own axes makes of a gyro's drift with these coefficients."""
        forces = [(sensitivity_dps_per_g[name], force) for name, force in (self.force_g or {}).items()]
        return Swing(
            constant=sum(each * force.constant for each, force in forces),
            cosine=sum(each * force.cosine for each, force in forces),
            sine=sum(each * force.sine for each, force in forces),
        )


def carriages(
    axes: Sequence[str],
    mountings: Mapping[str, tuple[float, float, float]],
    *,
    table_axis: tuple[float, float, float],
    site: Site | None,
) -> tuple[Carriage, ...]:
    """How each axis of a unit sits on a table with that axis, (up, north, east).

    Of a unit whose mounting is not known the last axis lies along the table's axis, and points up for
    the Earth; those before it lie across. Gravity acts where the mounting is known: along the axis itself.
    """
    made = []
    for back, axis in enumerate(reversed(axes)):
        given = mountings.get(axis, mountings.get("") if len(axes) == 1 else None)
        known = given is not None and any(given)
        direction = unit(given if known and given is not None else _PLAIN[min(back, 2)])
        about = unit(table_axis)
        made.append(
            carriage(
                direction,
                about,
                site=site,
                share=None if known else float(back == 0),
                own={own_name(axis): direction} if known else {},
            )
        )
    return tuple(reversed(made))


def carriage(
    axis: Direction,
    about: Direction,
    *,
    site: Site | None,
    own: Mapping[str, Direction],
    share: float | None = None,
    staged: bool = False,
) -> Carriage:
    """How an axis sits on what turns about another one; `own` are axes of the unit that feel gravity.

    All are (up, north, east). `share` is that of the rate where it does not follow from the axes.
    """
    earth = _swing(axis, about, earth_dps(site))
    return Carriage(
        table_share=float(axis @ about) if share is None else share,
        earth_dps=earth.constant,
        earth_cos_dps=earth.cosine,
        earth_sin_dps=earth.sine,
        force_g={
            name: _swing(each, about, gravity_g(site) * np.array(_UP)) for name, each in own.items()
        },
        staged=staged,
    )


def own_name(axis: str) -> str:
    """The own axis that an axis of a gyro senses, by its name."""
    return axis if axis and axis in _OWN_AXES else ONLY_AXIS


def _swing(axis: Direction, about: Direction, vector: Direction) -> Swing:
    """Rodrigues' rotation of the axis about another, seen by a vector that stays."""
    along = float(axis @ about)
    across = axis - along * about
    return Swing(
        constant=along * float(about @ vector),
        cosine=float(across @ vector),
        sine=float(cross(about, axis) @ vector),
    )


def cross(left: Direction, right: Direction) -> Direction:
    """The vector product in (up, north, east), which are left-handed in this order."""
    return -np.cross(left, right)


def unit(direction: Sequence[float]) -> Direction:
    """A direction at length 1."""
    vector = np.array(direction, dtype=np.float64)
    return np.asarray(vector / np.linalg.norm(vector))


def earth_dps(site: Site | None) -> Direction:
    """The Earth's rate in the bench's frame; nothing where the station does not say where it stands."""
    if site is None:
        return np.zeros(3)
    latitude = math.radians(site.latitude.to("deg"))
    heading = math.radians(heading_deg(site))
    level = math.cos(latitude)
    return _EARTH_DPS * np.array(
        [math.sin(latitude), level * math.cos(heading), -level * math.sin(heading)]
    )


def heading_deg(site: Site | None) -> float:
    """Where the bench's north points, clockwise from true north; there where nothing is said."""
    return site.heading.to("deg") if site is not None and site.heading is not None else 0.0


def gravity_g(site: Site | None) -> float:
    """Gravity where the bench stands: 1 where the station does not say where that is."""
    if site is None:
        return 1.0
    square = math.sin(math.radians(site.latitude.to("deg"))) ** 2
    return _EQUATOR_G * (1.0 + _FORMULA * square) / math.sqrt(1.0 - _ECCENTRICITY * square)
