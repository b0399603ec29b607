"""What acts on the unit in a slot: the table's turning, the Earth's, temperature and power."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gyrotest.records.station import Site, Slot
from gyrotest.simulation.peer import Heating, Peer, Powered, Powering, Turning

REFERENCE_DEGC = 23.0
# One turn a sidereal day of 86164.0905 s.
_EARTH_DPS = 360.0 / 86164.0905
_UP = (1.0, 0.0, 0.0)
# Where the axes of a unit point whose mounting is not known, from its last axis backwards.
_PLAIN = (_UP, (0.0, 0.0, 1.0), (0.0, 1.0, 0.0))

Direction = NDArray[np.float64]


@dataclass(frozen=True, slots=True, kw_only=True)
class Carriage:
    """How an axis sits on the table: its share of the table's rate, and of the Earth's, deg/s.

    The latter at a table angle `θ` is `earth_dps + earth_cos_dps·cos θ + earth_sin_dps·sin θ`.
    """

    table_share: float
    earth_dps: float
    earth_cos_dps: float = 0.0
    earth_sin_dps: float = 0.0

    def earth_at_dps(self, from_deg: NDArray[np.float64], to_deg: NDArray[np.float64]) -> Direction:
        """The mean of the Earth's share while the table turns evenly from one angle to another."""
        middle, way = np.radians(0.5 * (from_deg + to_deg)), (to_deg - from_deg) / 360.0
        swing = self.earth_cos_dps * np.cos(middle) + self.earth_sin_dps * np.sin(middle)
        return np.asarray(self.earth_dps + swing * np.sinc(way))

    @property
    def at_rest_dps(self) -> float:
        """The Earth's share at the table's angle 0."""
        return self.earth_dps + self.earth_cos_dps


@dataclass(frozen=True, slots=True, kw_only=True)
class Acting:
    """What acted during some apertures: table angles at their ends (None: no table), temperatures."""

    aperture_s: float
    from_deg: NDArray[np.float64] | None
    to_deg: NDArray[np.float64] | None
    temperature_degc: NDArray[np.float64]


class Surroundings:
    """The instruments around a slot, as far as they are in use yet; `powered`: its supply feeds the unit."""

    def __init__(self, slot: Slot, peers: Mapping[str, Peer], *, powered: bool) -> None:
        self._slot = slot
        self._peers = peers
        self._powered = powered and slot.supply is not None

    def _of(self, name: str | None) -> Peer | None:
        return self._peers.get(name) if name is not None else None

    @property
    def quiet(self) -> bool:
        """Whether nothing but the Earth acts on the unit, and nobody switches its power."""
        return self.still and not self._powered

    @property
    def still(self) -> bool:
        """Whether nothing but the Earth acts on the unit, whoever switches its power."""
        slot, peers = self._slot, self._peers
        return not (slot.table in peers or slot.chamber in peers)

    def acting(self, starts_s: NDArray[np.float64], aperture_s: float) -> Acting:
        """What acts during apertures that begin at these times."""
        return Acting(
            aperture_s=aperture_s,
            from_deg=self._angles_deg(starts_s),
            to_deg=self._angles_deg(starts_s + aperture_s),
            temperature_degc=self.temperatures_degc(starts_s),
        )

    def acting_through(self, edges_s: NDArray[np.float64], aperture_s: float) -> Acting:
        """What acts during apertures without gaps, between these edges."""
        angles = self._angles_deg(edges_s)
        return Acting(
            aperture_s=aperture_s,
            from_deg=None if angles is None else angles[:-1],
            to_deg=None if angles is None else angles[1:],
            temperature_degc=self.temperatures_degc(edges_s[:-1]),
        )

    def _angles_deg(self, times_s: NDArray[np.float64]) -> NDArray[np.float64] | None:
        table = self._of(self._slot.table)
        if table is None or not isinstance(table, Turning):
            return None
        return table.angle_deg(times_s)

    def temperatures_degc(self, times_s: NDArray[np.float64]) -> NDArray[np.float64]:
        """The unit's temperatures."""
        chamber = self._of(self._slot.chamber)
        if chamber is not None and isinstance(chamber, Heating):
            return chamber.temperature_degc(times_s)
        return np.full(times_s.shape, REFERENCE_DEGC)

    @property
    def power(self) -> Powered | None:
        """The output that feeds the unit; None where it has power whatever the supply does."""
        supply = self._of(self._slot.supply) if self._powered else None
        if supply is None or not isinstance(supply, Powering):
            return None
        return supply.output(self._slot.supply_output)


def carriages(
    axes: Sequence[str],
    mountings: Mapping[str, tuple[float, float, float]],
    *,
    table_axis: tuple[float, float, float],
    site: Site | None,
) -> tuple[Carriage, ...]:
    """How each axis of a unit sits on a table with that axis, (up, north, east).

    Of a unit whose mounting is not known the last axis lies along the table's axis, and points up for
    the Earth; those before it lie across.
    """
    made = []
    for back, axis in enumerate(reversed(axes)):
        given = mountings.get(axis, mountings.get("") if len(axes) == 1 else None)
        known = given is not None and any(given)
        made.append(
            _carriage(
                _unit(given if known and given is not None else _PLAIN[min(back, 2)]),
                _unit(table_axis),
                _earth_dps(site),
                share=None if known else float(back == 0),
            )
        )
    return tuple(reversed(made))


def _carriage(axis: Direction, table: Direction, earth: Direction, *, share: float | None) -> Carriage:
    """Rodrigues' rotation of the axis about the table's, seen by the Earth's vector."""
    along = float(axis @ table)
    across = axis - along * table
    turned = _cross(table, axis)
    return Carriage(
        table_share=along if share is None else share,
        earth_dps=along * float(table @ earth),
        earth_cos_dps=float(across @ earth),
        earth_sin_dps=float(turned @ earth),
    )


def _cross(left: Direction, right: Direction) -> Direction:
    """The vector product in (up, north, east), which are left-handed in this order."""
    return -np.cross(left, right)


def _unit(direction: Sequence[float]) -> Direction:
    vector = np.array(direction, dtype=np.float64)
    return np.asarray(vector / np.linalg.norm(vector))


def _earth_dps(site: Site | None) -> Direction:
    """The Earth's rate in the bench's frame; nothing where the station does not say where it stands."""
    if site is None:
        return np.zeros(3)
    latitude = math.radians(site.latitude.to("deg"))
    heading = math.radians(site.heading.to("deg")) if site.heading is not None else 0.0
    level = math.cos(latitude)
    return _EARTH_DPS * np.array(
        [math.sin(latitude), level * math.cos(heading), -level * math.sin(heading)]
    )
