"""What acts on the unit in a slot: the table's turning, the Earth's, temperature and power."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gyrotest.records.station import Slot
from gyrotest.simulation.peer import Exciting, Heating, Peer, Powered, Powering, Turning

REFERENCE_DEGC = 23.0


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

    @property
    def table(self) -> Turning | None:
        """The rate table that carries the unit."""
        table = self._of(self._slot.table)
        return table if isinstance(table, Turning) else None

    @property
    def drive(self) -> Exciting | None:
        """What drives the vibration table that carries the unit."""
        drive = self._of(self._slot.vibration)
        return drive if isinstance(drive, Exciting) else None

    def _angles_deg(self, times_s: NDArray[np.float64]) -> NDArray[np.float64] | None:
        return None if self.table is None else self.table.angle_deg(times_s)

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
