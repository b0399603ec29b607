"""The opened bench: clock, sources by slot, and the simulated bench where the station is one."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

from gyrotest.clock import RealClock
from gyrotest.errors import RefusedError
from gyrotest.ports import Clock, Source
from gyrotest.records.plan import Plan
from gyrotest.records.run import InstrumentUse, PlannedItem
from gyrotest.records.spec import Output
from gyrotest.records.station import Accuracy, Instrument, Station
from gyrotest.registry import INSTRUMENTS, load
from gyrotest.runner.items import Moment

if TYPE_CHECKING:
    from gyrotest.simulation.bench import SimulatedBench


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
    """A station whose instruments are opened on first use and closed together.

    `powered_on_s` is when the units under test were powered on, as far as the run knows: its own start.
    """

    def __init__(self, station: Station, output: Output, choice: SimulationChoice) -> None:
        self.station = station
        self._simulated = _simulated_bench(station, output, choice)
        self.clock: Clock = self._simulated.clock if self._simulated else RealClock()
        self.powered_on_s = self.clock.now_s()
        self._open: dict[tuple[str, str], OpenSource] = {}

    def source(self, slot: str, serial_number: str) -> OpenSource:
        """The source that reads a slot, opened; raises `InstrumentError`."""
        name = self.station.slots[slot].source
        resource = self._resource(name).replace("{serial}", serial_number)
        opened = self._open.get((name, resource))
        if opened is None:
            opened = self._open[name, resource] = self._opened(name, resource)
        return opened

    def opened(self, slot: str) -> tuple[InstrumentUse, ...]:
        """The instruments that were opened for a slot."""
        name = self.station.slots[slot].source
        return tuple(one.use for (opened, _), one in self._open.items() if opened == name)

    def drop(self, opened: OpenSource) -> None:
        """Close a source that misbehaved; the next use opens it anew."""
        opened.source.close()
        self._open = {key: one for key, one in self._open.items() if one is not opened}

    def stage(
        self, slot: str, serial_number: str, item: PlannedItem, *, moment: Moment, plan: Plan
    ) -> None:
        """Tell a simulated bench what it is to play next; a real one needs no telling."""
        if self._simulated:
            self._simulated.begin(
                units={self.station.slots[slot].source: serial_number},
                case=item.case,
                power_cycle=moment.power_cycle,
                repeat=item.repeat or 1,
                elapsed_s=moment.elapsed_s,
                duration_s=plan.duration_s,
            )

    def truth(self, slot: str, plan: Plan) -> Mapping[str, float]:
        """A simulated unit's true parameters; empty on a real bench."""
        if not self._simulated:
            return {}
        return self._simulated.truth(self.station.slots[slot].source, duration_s=plan.duration_s)

    def power_was_cycled(self) -> None:
        """The units were just powered on again: warm-up starts anew."""
        self.powered_on_s = self.clock.now_s()

    def close(self) -> None:
        """Leave everything safe; idempotent, never raises."""
        for opened in self._open.values():
            opened.source.close()
        self._open = {}
        if self._simulated:
            self._simulated.close()

    def _resource(self, name: str) -> str:
        if self._simulated and name in self._simulated.addresses:
            return self._simulated.addresses[name]
        return self.station.instruments[name].resource

    def _opened(self, name: str, resource: str) -> OpenSource:
        instrument = self.station.instruments[name]
        source = make_source(self.station, name, resource, self.clock)
        try:
            identity = source.open()
        except BaseException:
            source.close()
            raise
        use = InstrumentUse(name=name, driver=instrument.driver, resource=resource, identity=identity)
        return OpenSource(source=source, use=use, accuracy=instrument.accuracy)


def make_source(station: Station, name: str, resource: str, clock: Clock) -> Source:
    """Make the driver of an instrument of the station, not opened yet."""
    from gyrotest.specification.station import instrument_settings

    instrument: Instrument = station.instruments[name]
    driver = load(INSTRUMENTS, instrument.driver)
    source: Source = driver(
        resource,
        instrument_settings(instrument, driver),
        clock=clock,
        line_frequency_hz=station.line_frequency.to("Hz") if station.line_frequency else None,
        accuracy=instrument.accuracy,
        io_timeout_s=instrument.io_timeout.to("s") if instrument.io_timeout else None,
        serial_number=instrument.serial_number,
    )
    return source


def check_choice(station: Station, choice: SimulationChoice) -> None:
    """Refuse options of the simulated bench for a real one; raises `RefusedError`."""
    if station.simulation is None and choice != SimulationChoice():
        raise RefusedError(
            f"station '{station.name}' is no simulated bench: leave the --gyro-sim-… and --gyro-real-time"
            " options out, or choose a station with a 'simulation:' section"
        )


def _simulated_bench(
    station: Station, output: Output, choice: SimulationChoice
) -> "SimulatedBench | None":
    if station.simulation is None:
        return None
    from gyrotest.simulation.bench import SimulatedBench

    return SimulatedBench(
        station, output, seed=choice.seed, scenario=choice.scenario, real_time=choice.real_time
    )
