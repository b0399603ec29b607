"""A whole run of one unit on a simulated bench that can be looked into: its table, its supply, its clock."""

import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from gyrotest.acquisition.progress import Silence
from gyrotest.errors import GyrotestError
from gyrotest.records.run import Attempt, PlannedItem, RunRecord
from gyrotest.runner.bench import Bench, SimulationChoice
from gyrotest.runner.door import Order, check_order, open_run
from gyrotest.runner.flow import UnitRun
from gyrotest.runner.places import slots_of
from gyrotest.simulation.bench import SimulatedBench
from gyrotest.simulation.supply import SimulatedOutput
from gyrotest.simulation.supply_peer import SupplyPeer
from gyrotest.simulation.table import SimulatedTable
from gyrotest.simulation.table_peer import TablePeer
from gyrotest.specification.spec import load_spec
from gyrotest.specification.station import load_station

SERIAL_NUMBER = "1234"
# The stage turns 12 degrees a second, so that a turn lasts 30 s.
SHORT_TURN = """
model: SHORT50
output:
  kind: voltage
  scale_factor: 50 mV/(deg/s)
  scale_factor_uncertainty: 0.5 %
  zero_rate: 2.5 V
  full_scale: 100 deg/s
  bandwidth: 50 Hz
cases:
  gravity:
    procedure: g_sensitivity
    duration: 2 s
    interval: 20 ms
    repeats: 2
    parameters: {rate: 12 deg/s, run_up: 15 deg, turns: 1}
    limits: {g_sensitivity_x: {min: -0.5 deg/s/g, max: 0.5 deg/s/g, over: repeats}}
"""


@dataclass
class BenchRun:
    """A run item by item; what each raised by the item's name."""

    bench: Bench
    run: UnitRun
    said: dict[str, str] = field(default_factory=dict)
    took_s: dict[str, float] = field(default_factory=dict)

    def carry_out(self, *, before: Callable[[PlannedItem], None] = lambda _: None) -> RunRecord:
        """Every item, as the plugin does it."""
        for item in self.run.header.plan:
            before(item)
            begun_s = time.monotonic()
            try:
                if item.repeat is None:
                    self.run.judge_repeats(item)
                else:
                    self.run.judge(item, self.run.acquire(item))
            except GyrotestError as fault:
                self.said[item.name] = str(fault)
            self.took_s[item.name] = time.monotonic() - begun_s
        return self.run.update_record()

    def attempt(self, item: str) -> Attempt:
        """The last attempt at an item."""
        return self.run.folder.attempts(item)[-1]

    @property
    def simulated(self) -> SimulatedBench:
        """The simulated bench."""
        assert self.bench._simulated is not None
        return self.bench._simulated

    @property
    def table(self) -> SimulatedTable:
        """The simulated table itself."""
        peer = self.simulated._peers["table"]
        assert isinstance(peer, TablePeer)
        return peer.table

    @property
    def output(self) -> SimulatedOutput:
        """The supply's output itself."""
        peer = self.simulated._peers["supply"]
        assert isinstance(peer, SupplyPeer)
        return peer.output(1)

    def turned_deg(self, during_s: float) -> float:
        """How far the table truly turns from now on; virtual time passes."""
        clock = self.bench.clock
        begun_s = clock.now_s()
        clock.sleep_until(begun_s + during_s)
        before, after = self.table.angle_deg(np.array([begun_s, begun_s + during_s]))
        return abs(float(after - before))


@contextmanager
def bench_run(
    folder: Path, spec: str, station: str | Path, *, scenario: str = "nominal"
) -> Iterator[BenchRun]:
    """A unit's run by a spec on a station, through the door; the bench is closed at the end."""
    folder.mkdir(exist_ok=True)
    (folder / "spec.yaml").write_text(spec, encoding="utf-8")
    if isinstance(station, str):
        (folder / "station.yaml").write_text(station, encoding="utf-8")
        station = folder / "station.yaml"
    order = Order(
        spec=load_spec(folder / "spec.yaml"),
        station=load_station(station),
        serial_numbers=(SERIAL_NUMBER,),
        out=folder / "out",
    )
    check_order(order)
    slot = slots_of(order.spec.spec, order.station.station)[0]
    run_folder, header = open_run(order, SERIAL_NUMBER, slot)
    bench = Bench(order.station.station, order.spec.spec, SimulationChoice(scenario=scenario))
    run = UnitRun(
        folder=run_folder, header=header, bench=lambda: bench, progress=Silence(), confirm=_nobody
    )
    try:
        yield BenchRun(bench=bench, run=run)
    finally:
        bench.close()


def _nobody(text: str) -> None:
    raise AssertionError(f"nobody should be asked: {text}")
