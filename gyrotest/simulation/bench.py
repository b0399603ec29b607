"""The simulated bench: one physical world, one clock, a server for each simulated instrument."""

from collections.abc import Mapping, Sequence
from types import TracebackType
from typing import Self

from gyrotest.clock import RealClock
from gyrotest.errors import StationError
from gyrotest.ports import Clock
from gyrotest.records.plan import Placement
from gyrotest.records.spec import OutputKind, Spec
from gyrotest.records.station import Simulation, Station
from gyrotest.simulation.clock import VirtualClock
from gyrotest.simulation.figures import fault
from gyrotest.simulation.gyro_settings import gyro_parameters, unfit
from gyrotest.simulation.occasion import Occasion
from gyrotest.simulation.peer import Making, Peer
from gyrotest.simulation.peers import is_simulated, make_peer
from gyrotest.simulation.scenarios import SCENARIOS, Scenario
from gyrotest.simulation.settings import unknown_instruments
from gyrotest.simulation.streaming import Streaming
from gyrotest.simulation.wires import Wires, check_way
from gyrotest.simulation.workplace import Workplace


class SimulatedBench:
    """Simulates every instrument of a station whose resource begins with `simulated`, on first use.

    `slots` are those that the spec's units take (none given: those for its model). Raises `StationError`
    for a complaint about the station's `simulation`, or where such a slot has no source that could read
    the unit.
    """

    def __init__(
        self,
        station: Station,
        spec: Spec,
        *,
        seed: int | None = None,
        scenario: str | None = None,
        real_time: bool = False,
        slots: Sequence[str] = (),
    ) -> None:
        simulation = station.simulation or Simulation()
        self._station = station
        self._spec = spec
        self._scenario = find_scenario(scenario or simulation.scenario)
        self._seed = simulation.seed if seed is None else seed
        self._live = real_time
        self._gyro = gyro_parameters(simulation, spec, self._scenario.factors)
        if faults := unknown_instruments(station):
            raise StationError(faults)
        self.clock: Clock = RealClock() if real_time else VirtualClock()
        self._wires = Wires(self.clock)
        self._peers: dict[str, Peer] = {}
        self._workplaces: dict[str, Workplace] = {}
        self._addresses: dict[str, str] = {}
        for slot in slots or station.slots_for(spec.model):
            self._check(station.slots[slot].source)

    def _check(self, source: str) -> None:
        resource = self._station.instruments[source].resource
        if is_simulated(resource):
            check_way(source, resource)
            kind, peer = self._spec.output.kind, self._peer(source)
            fits = peer.kinds if isinstance(peer, Streaming) else {OutputKind.VOLTAGE}
            if kind not in fits:
                raise StationError([fault("simulation", self._unfit(source, peer))])

    def _unfit(self, source: str, peer: Peer) -> str:
        if isinstance(peer, Streaming):
            kind = self._spec.output.kind.value
            return f"the spec's output.kind is '{kind}', which '{source}' does not have; name another station"
        return unfit(self._spec.output)

    def simulates(self, name: str) -> bool:
        """Whether an instrument of the station is simulated."""
        return is_simulated(self._station.instruments[name].resource)

    def address(self, name: str) -> str:
        """Where a simulated instrument is to be found; its server starts when it is first asked for."""
        address = self._addresses.get(name)
        if address is None:
            resource = self._station.instruments[name].resource
            address = self._addresses[name] = self._wires.serve(name, resource, self._peer(name))
        return address

    def _peer(self, name: str) -> Peer:
        peer = self._peers.get(name)
        if peer is None:
            peer = make_peer(
                Making(
                    station=self._station,
                    name=name,
                    clock=self.clock,
                    seed=self._seed,
                    scenario=self._scenario,
                    live=self._live,
                )
            )
            self._peers[name] = peer
            for slot, workplace in self._workplaces.items():
                if workplace.occasion is not None and name in self._around(slot):
                    peer.begin(workplace.occasion)
        return peer

    def _around(self, slot: str) -> tuple[str, ...]:
        """The instruments that a slot uses, its source first."""
        place = self._station.slots[slot]
        around = (place.source, place.table, place.vibration, place.supply, place.chamber)
        return tuple(name for name in around if name is not None)

    def insert(self, *, slot: str, serial_number: str) -> None:
        """Put a unit into a slot before its first record: a digital one can be asked who it is."""
        self._begin(slot, Occasion(serial_number=serial_number))

    def begin(
        self,
        *,
        slot: str,
        serial_number: str,
        case: str,
        power_cycle: int,
        repeat: int,
        elapsed_s: float,
        duration_s: float,
        mountings: Mapping[str, tuple[float, float, float]] | None = None,
        placement: Placement | None = None,
    ) -> None:
        """Prepare the next record of the unit in a slot, and the random streams of all around it.

        `elapsed_s` is the time since power-on at the record's start, which is now. `mountings` has the
        direction (up, north, east) of each axis where it is known, by the axis's name (empty for a gyro
        of one axis). `placement` is how the unit is turned in its slot.
        """
        self._begin(
            slot,
            Occasion(
                serial_number=serial_number,
                case=case,
                power_cycle=power_cycle,
                repeat=repeat,
                elapsed_s=elapsed_s,
                duration_s=duration_s,
                mountings=mountings or {},
                placement=placement,
            ),
        )

    def _begin(self, slot: str, occasion: Occasion) -> None:
        place = self._station.slots[slot]
        if not self.simulates(place.source):
            return
        source = self._peer(place.source)
        for name in self._around(slot):
            if name in self._peers:
                self._peers[name].begin(occasion)
        self._workplace(slot).begin(occasion, source)

    def _workplace(self, slot: str) -> Workplace:
        if slot not in self._workplaces:
            self._workplaces[slot] = Workplace(
                self._station,
                self._station.slots[slot],
                self._gyro,
                peers=self._peers,
                powered=self._spec.supply is not None,
                seed=self._seed,
                scenario=self._scenario,
                clock=self.clock,
            )
        return self._workplaces[slot]

    def truth(self, slot: str, *, duration_s: float) -> Mapping[str, float]:
        """The true figures of the unit in a slot and of the instruments around it, for the record begun last.

        Empty where nothing is simulated or begun.
        """
        workplace = self._workplaces.get(slot)
        if workplace is None:
            return {}
        found = workplace.truth(duration_s)
        for name in self._around(slot):
            if name in self._peers:
                found |= self._peers[name].truth()
        return found

    def close(self) -> None:
        """Stop all servers; idempotent."""
        self._wires.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()


def find_scenario(name: str) -> Scenario:
    """The scenario of that name; raises `StationError`."""
    if name not in SCENARIOS:
        message = f"'{name}' is no scenario; write one of {', '.join(SCENARIOS)}"
        raise StationError([fault("simulation.scenario", message)])
    return SCENARIOS[name]
