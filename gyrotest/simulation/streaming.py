"""Simulated instruments that send by themselves."""

from typing import Protocol, runtime_checkable

from gyrotest.records.spec import OutputKind
from gyrotest.records.station import Slot
from gyrotest.simulation.housed import Housed
from gyrotest.simulation.outlet import Outlet


@runtime_checkable
class Sending(Protocol):
    """A peer that sends by itself."""

    def transmit(self, now_s: float, outlet: Outlet) -> None:
        """Answer what was asked, and send all that is due by now."""


@runtime_checkable
class Digitizing(Sending, Protocol):
    """A peer that samples what the units in its slots give, and what measures their motion."""

    def seat(self, slot: Slot, housed: Housed) -> None:
        """Have this unit in a slot from now on, for its next record."""


@runtime_checkable
class Streaming(Sending, Protocol):
    """A peer that is itself the unit under test, and sends its samples as they come.

    `kinds` are the outputs that it can have.
    """

    kinds: frozenset[OutputKind]

    def house(self, housed: Housed) -> None:
        """Be this unit from now on, for its next record."""
