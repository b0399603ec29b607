"""The opened bench: clock, sources, what powers the units, and the simulated bench where it is one."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

from gyrotest.clock import RealClock
from gyrotest.errors import RefusedError
from gyrotest.ports import Clock, DigitalGyro, Source
from gyrotest.records.plan import Plan
from gyrotest.records.run import InstrumentUse, PlannedItem
from gyrotest.records.spec import Case, Spec
from gyrotest.records.station import Accuracy, Station
from gyrotest.runner.drivers import Drivers
from gyrotest.runner.items import Moment
from gyrotest.runner.mounting import Mounted, mountings
from gyrotest.runner.places import slots_of
from gyrotest.runner.stimuli import Stimuli

if TYPE_CHECKING:
    from gyrotest.acquisition.power import Power
    from gyrotest.simulation.bench import SimulatedBench


SERIAL = "{serial}"
"""Stands in a resource for the unit's serial number."""


@dataclass(frozen=True, slots=True, kw_only=True)
class SimulationChoice:
    """What the command line says of the simulated bench; None: as the station says."""

    scenario: str | None = None
    seed: int | None = None
    real_time: bool = False


@dataclass(frozen=True, slots=True, kw_only=True)
class OpenSource:
    """A source that answers, and how it is entered into the record."""

    source: Source
    use: InstrumentUse
    accuracy: Accuracy | None


class Bench:
    """A station whose instruments are opened on first use and closed together, tables first."""

    def __init__(self, station: Station, spec: Spec, choice: SimulationChoice) -> None:
        self.station = station
        self._spec = spec
        self._simulated = _simulated_bench(station, spec, choice)
        self.clock: Clock = self._simulated.clock if self._simulated else RealClock()
        self._drivers = Drivers(station, self.clock, self._resource)
        self.stimuli = Stimuli(station, self.clock, self._drivers)
        self._begun_s = self.clock.now_s()
        self._powered_on_s: dict[str, float] = {}
        self._sources: dict[tuple[str, str], OpenSource] = {}
        self._supplies: dict[tuple[str, int], Power] = {}
        self._events: dict[str, list[str]] = {}
        self.mounted = Mounted()

    def source(self, slot: str, serial_number: str) -> OpenSource:
        """The source that reads a slot, opened, the slot powered; raises `InstrumentError`."""
        self.power_on(slot)
        if self._simulated:
            self._simulated.insert(slot=slot, serial_number=serial_number)
        name = self.station.slots[slot].source
        resource = self._resource(name).replace(SERIAL, serial_number)
        opened = self._sources.get((name, resource))
        if opened is None:
            if self._simulated:
                self._simulated.insert(slot=slot, serial_number=serial_number)
            driver = self._drivers.source(name, resource)
            use = self._drivers.opened(name, resource, driver)
            accuracy = self.station.instruments[name].accuracy
            opened = OpenSource(source=driver, use=use, accuracy=accuracy)
            self._sources[name, resource] = opened
        return opened

    def used(self, slot: str) -> tuple[InstrumentUse, ...]:
        """The instruments that were opened for a slot, its source first."""
        place = self.station.slots[slot]
        sources = [one.use for (name, _), one in self._sources.items() if name == place.source]
        others = (place.table, place.vibration, place.supply, place.chamber)
        return (*sources, *(self._drivers.kept[name] for name in others if name in self._drivers.kept))

    @property
    def by_hand(self) -> bool:
        """Whether there is somebody to mount units; the simulated bench mounts them itself."""
        return self._simulated is None

    def drop(self, opened: OpenSource) -> None:
        """Close a source that misbehaved; the next use opens it anew."""
        opened.source.close()
        self._sources = {key: one for key, one in self._sources.items() if one is not opened}

    # Power

    def powered_on_s(self, slot: str) -> float:
        """When the unit in a slot was powered on, as far as the run knows: its own start."""
        return self._powered_on_s.get(slot, self._begun_s)

    def power_on(self, slot: str) -> None:
        """Switch a slot's supply on, where it has one and the spec says how; raises `InstrumentError`."""
        power = self._power(slot)
        if power is not None and not power.is_on:
            self._happened(slot, power.switch_on())
            self._powered_on_s[slot] = power.switched_on_s or self.clock.now_s()

    def power_off(self, slot: str) -> None:
        """Switch a slot's supply off, where it is on; raises `InstrumentError`."""
        power = self._power(slot)
        if power is not None and power.is_on:
            power.off()

    def cycle_power(self, slot: str) -> bool:
        """Switch a slot's supply off and on; False where there is none to switch."""
        power = self._power(slot)
        if power is None:
            return False
        self._happened(slot, power.cycle())
        self._powered_on_s[slot] = power.switched_on_s or self.clock.now_s()
        # A digital gyro is another conversation after its start.
        for opened in tuple(self._sources.values()):
            if opened.use.name == self.station.slots[slot].source and isinstance(
                opened.source, DigitalGyro
            ):
                self.drop(opened)
        return True

    def power_was_cycled(self, slot: str) -> None:
        """The unit in a slot was just powered on: warm-up starts anew."""
        self._powered_on_s[slot] = self.clock.now_s()

    def take_events(self, slot: str) -> tuple[str, ...]:
        """What happened to a slot's power since this was asked last."""
        return tuple(self._events.pop(slot, ()))

    def check_power(self, slot: str) -> None:
        """See that a slot's supply still gives what it shall; raises `InstrumentError`."""
        power = self._power(slot)
        if power is not None and power.is_on:
            power.check()

    def _happened(self, slot: str, text: str) -> None:
        self._events.setdefault(slot, []).append(text)

    def _power(self, slot: str) -> "Power | None":
        place, how = self.station.slots[slot], self._spec.supply
        if place.supply is None or how is None:
            return None
        from gyrotest.acquisition.power import Power

        key = (place.supply, place.supply_output)
        if key not in self._supplies:
            supply = self._drivers.supply(*key)
            self._drivers.keep(place.supply, supply)
            self._supplies[key] = Power(supply, how, clock=self.clock, name=self._resource(place.supply))
        return self._supplies[key]

    # The simulated bench

    def stage(
        self,
        slot: str,
        serial_number: str,
        item: PlannedItem,
        *,
        moment: Moment,
        plan: Plan,
        case: Case | None,
    ) -> None:
        """Tell a simulated bench what it is to play next; a real one needs no telling."""
        if self._simulated:
            self._simulated.begin(
                slot=slot,
                serial_number=serial_number,
                case=item.case,
                power_cycle=moment.power_cycle,
                repeat=item.repeat or 1,
                elapsed_s=moment.elapsed_s,
                duration_s=plan.duration_s,
                mountings=mountings(case),
                placement=plan.placement(item.repeat),
            )

    def truth(self, slot: str, plan: Plan) -> Mapping[str, float]:
        """A simulated unit's true parameters; empty on a real bench."""
        if not self._simulated:
            return {}
        return self._simulated.truth(slot, duration_s=plan.duration_s)

    def close(self) -> None:
        """Leave everything safe: tables at rest, sources closed, outputs off; idempotent, never raises."""
        self.stimuli.rest()
        for opened in self._sources.values():
            opened.source.close()
        self._drivers.close()
        self._sources, self._supplies = {}, {}
        if self._simulated:
            self._simulated.close()

    def _resource(self, name: str) -> str:
        resource = self.station.instruments[name].resource
        if self._simulated and resource.split(":")[0] == "simulated":
            return self._simulated.address(name)
        return resource


def check_choice(station: Station, choice: SimulationChoice) -> None:
    """Refuse options of the simulated bench for a real one; raises `RefusedError`."""
    if station.simulation is None and choice != SimulationChoice():
        raise RefusedError(
            f"station '{station.name}' is no simulated bench: leave the --gyro-sim-… and --gyro-real-time"
            " options out, or choose a station with a 'simulation:' section"
        )


def _simulated_bench(station: Station, spec: Spec, choice: SimulationChoice) -> "SimulatedBench | None":
    if station.simulation is None:
        return None
    from gyrotest.simulation.bench import SimulatedBench

    return SimulatedBench(
        station,
        spec,
        seed=choice.seed,
        scenario=choice.scenario,
        real_time=choice.real_time,
        slots=slots_of(spec, station),
    )
