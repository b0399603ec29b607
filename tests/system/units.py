"""Whole runs of simulated units without pytest around them and without the PDF."""

from collections.abc import Iterator
from contextlib import closing
from dataclasses import replace
from datetime import UTC, datetime
from pathlib import Path

from gyrotest.acquisition.progress import Silence
from gyrotest.errors import GyrotestError
from gyrotest.records.run import RunRecord
from gyrotest.records.spec import SpecDocument
from gyrotest.records.station import StationDocument
from gyrotest.runner.bench import Bench, SimulationChoice
from gyrotest.runner.door import Order, open_run
from gyrotest.runner.flow import UnitRun
from gyrotest.runner.places import slots_of
from gyrotest.specification.lookup import shipped_specs
from gyrotest.specification.spec import load_spec
from gyrotest.specification.station import load_station


def shipped_spec() -> SpecDocument:
    return load_spec(shipped_specs() / "mems50.yaml")


def simulated_station() -> StationDocument:
    return load_station(shipped_specs() / "stations" / "simulated.yaml")


def run_units(
    out: Path,
    serial_numbers: list[str],
    *,
    scenario: str = "nominal",
    spec: SpecDocument | None = None,
    station: StationDocument | None = None,
    place: int = 0,
) -> Iterator[RunRecord]:
    """Run the whole plan for each unit, as the pytest plugin does, and put its record together.

    `place`: in which of the slots that the spec's units take, from 0.
    """
    order = Order(
        spec=spec or shipped_spec(),
        station=station or simulated_station(),
        serial_numbers=tuple(serial_numbers),
        out=out,
    )
    for serial_number in serial_numbers:
        yield _run_unit(order, serial_number, scenario, place)


def _run_unit(order: Order, serial_number: str, scenario: str, place: int) -> RunRecord:
    slots = slots_of(order.spec.spec, order.station.station)
    folder, header = open_run(order, serial_number, slots[place])
    choice = SimulationChoice(scenario=scenario)
    bench = Bench(order.station.station, order.spec.spec, choice)
    run = UnitRun(folder=folder, header=header, bench=lambda: bench, progress=Silence(), confirm=_nobody)
    with closing(bench):
        for item in header.plan:
            try:
                if item.repeat is None:
                    run.judge_repeats(item)
                else:
                    run.judge(item, run.acquire(item))
            except GyrotestError:
                continue  # it is on record
    return replace(run.update_record(), issued_utc=datetime(2026, 1, 1, tzinfo=UTC))


def _nobody(text: str) -> None:
    raise AssertionError(f"nobody should be asked: {text}")
