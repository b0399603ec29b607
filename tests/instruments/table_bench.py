"""A simulated table behind a server, and the drivers for it."""

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass

from gyrotest.instruments.acutrol3000 import Acutrol3000, Acutrol3000Settings, Dialect
from gyrotest.instruments.aerosmith import Aerosmith, AerosmithSettings
from gyrotest.ports import RateTable
from gyrotest.records.station import Motion
from gyrotest.simulation.acutrol import AcutrolController, AcutrolDialogue, AcutrolInterface
from gyrotest.simulation.aerosmith import AerosmithController, AerosmithDialogue
from gyrotest.simulation.clock import VirtualClock
from gyrotest.simulation.dialogue import Dialogue
from gyrotest.simulation.occasion import Occasion
from gyrotest.simulation.server import PtyServer, TcpServer
from gyrotest.simulation.table import SimulatedTable, TableFaults, TableParameters
from gyrotest.units import Quantity

OCCASION = Occasion(serial_number="1234", case="scale_factor", repeat=1, duration_s=60.0)


def motion(*, slip_ring: bool = True, max_turns: float | None = None) -> Motion:
    return Motion(
        max_rate=Quantity(200.0, "deg/s"),
        max_acceleration=Quantity(100.0, "deg/s/s"),
        slip_ring=slip_ring,
        max_turns=max_turns,
    )


@dataclass
class Served:
    table: SimulatedTable
    clock: VirtualClock
    kind: str
    address: str

    def driver(self, limits: Motion | None = None, *, address: str = "") -> RateTable:
        limits = motion() if limits is None else limits
        where = address or self.address
        if self.kind == "aerosmith":
            return Aerosmith(where, AerosmithSettings(), clock=self.clock, motion=limits)
        settings = Acutrol3000Settings(dialect=Dialect(self.kind))
        return Acutrol3000(where, settings, clock=self.clock, motion=limits)

    def wait(self, duration_s: float) -> None:
        self.clock.advance(duration_s)


@contextmanager
def served(
    kind: str,
    *,
    pty: bool = False,
    faults: TableFaults | None = None,
    parameters: TableParameters | None = None,
) -> Iterator[Served]:
    """A table behind a controller of a kind: `plain` or `status` (ACUTROL3000), `aerosmith`."""
    clock = VirtualClock()
    table = SimulatedTable("table", parameters or TableParameters(), seed=1, clock=clock)
    table.begin(OCCASION, faults)
    acutrol = AcutrolController(table, serial_number="SIM00001")
    aerosmith = AerosmithController(table, serial_number="SIM00002")

    def dialogue() -> Dialogue:
        if kind == "aerosmith":
            return AerosmithDialogue(aerosmith, clock.now_s)
        return AcutrolDialogue(acutrol, clock.now_s, AcutrolInterface(kind))

    if pty:
        with PtyServer(dialogue, clock) as terminal:
            yield Served(table, clock, kind, f"ASRL{terminal.path}::INSTR")
    else:
        with TcpServer(dialogue, clock) as server:
            yield Served(table, clock, kind, f"TCPIP::127.0.0.1::{server.port}::SOCKET")
