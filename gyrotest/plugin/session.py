"""What one pytest process knows of the runs that it works on."""

import functools
from collections.abc import Iterable
from dataclasses import dataclass, field

import pytest

from gyrotest.acquisition.progress import Progress
from gyrotest.plugin.prompt import Prompt
from gyrotest.records.run import InstrumentUse, PlannedItem, RunHeader
from gyrotest.runner.bench import SERIAL, Bench, SimulationChoice, check_choice
from gyrotest.runner.door import Order
from gyrotest.runner.flow import UnitRun
from gyrotest.runner.folder import RunFolder
from gyrotest.runner.locks import ResourceLocks

GYRO = pytest.StashKey["GyroSession"]()
PLANNED = pytest.StashKey[PlannedItem]()


@dataclass
class GyroSession:
    """The order, the runs by serial number, and the bench, opened when first needed."""

    config: pytest.Config
    order: Order
    choice: SimulationChoice
    observes_only: bool
    is_worker: bool
    progress: Progress
    prompt: Prompt
    runs: dict[str, UnitRun] = field(default_factory=dict)
    locks: ResourceLocks | None = None
    _bench: Bench | None = None
    _unit_on_bench: str | None = None

    def take_runs(self, opened: Iterable[tuple[RunFolder, RunHeader]]) -> None:
        """Work on these runs."""
        for folder, header in opened:
            self.runs[header.serial_number] = UnitRun(
                folder=folder,
                header=header,
                bench=self.bench,
                progress=self.progress,
                confirm=self.prompt.confirm,
            )
            run = self.runs[header.serial_number]
            run.partners = functools.partial(self._partners, run)
            if not self.is_worker:
                self.runs[header.serial_number].note_progress()

    def bench(self) -> Bench:
        """The bench, opened and owned."""
        if self._bench is None:
            self.lock_bench()
            self._bench = Bench(self.order.station.station, self.order.spec.spec, self.choice)
        return self._bench

    def prepare_bench(self) -> None:
        """Refuse at the door what can be refused there; real instruments are not touched yet."""
        check_choice(self.order.station.station, self.choice)
        if self.order.station.station.simulation is not None:
            self.bench()
        else:
            self.lock_bench()

    def lock_bench(self) -> None:
        """Own the station's resources; a simulated bench is nobody else's anyway."""
        if self.locks is not None or self.order.station.station.simulation is not None:
            return
        locks = ResourceLocks(f"the test of {', '.join(self.order.serial_numbers)}")
        instruments = self.order.station.station.instruments.values()
        locks.acquire(one.resource for one in instruments if one.driver != "replay")
        self.locks = locks

    def put_on_bench(self, serial_number: str) -> UnitRun:
        """The run of a unit, which the operator puts into its slot where another one was before."""
        run = self.runs[serial_number]
        before = self._unit_on_bench
        if (
            before is not None
            and before != serial_number
            and self.runs[before].header.slot == run.header.slot
        ):
            self.bench().power_off(run.header.slot)
            self.prompt.confirm(
                f"Put unit {serial_number} into slot {run.header.slot} in place of {before}"
            )
            self.bench().power_was_cycled(run.header.slot)
        self._unit_on_bench = serial_number
        return run

    def instruments_used(self, slot: str) -> tuple[InstrumentUse, ...]:
        """What was opened so far for a slot; opens nothing."""
        return self._bench.used(slot) if self._bench is not None else ()

    def _partners(self, run: UnitRun) -> tuple[UnitRun, ...]:
        """The runs of the units that the same source reads on other channels, in this process."""
        station = self.order.station.station
        slots = station.slots
        # A resource with the serial number in it is another one for each unit.
        if self.is_worker or SERIAL in station.instruments[slots[run.header.slot].source].resource:
            return ()
        return tuple(
            other
            for other in self.runs.values()
            if other.header.slot != run.header.slot
            and slots[other.header.slot].source == slots[run.header.slot].source
        )

    def close_bench(self) -> None:
        """Leave the bench safe and give it back."""
        if self._bench is not None:
            self._bench.close()
            self._bench = None
        if self.locks is not None:
            self.locks.release()
            self.locks = None
