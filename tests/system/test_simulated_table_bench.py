"""A gyro on a rate table on the simulated bench: what the table turns, the meter reads; its scenarios."""

from collections.abc import Iterator, Mapping
from contextlib import closing, contextmanager
from typing import Any

import numpy as np
import pytest

from gyrotest.acquisition.turning import TableDrive
from gyrotest.errors import InstrumentError, StationError
from gyrotest.instruments.acutrol3000 import Acutrol3000, Acutrol3000Settings, Dialect
from gyrotest.instruments.aerosmith import Aerosmith, AerosmithSettings
from gyrotest.instruments.keysight34465a import Keysight34465A, Keysight34465ASettings
from gyrotest.ports import RateTable
from gyrotest.records.plan import Turning
from gyrotest.records.recording import Identity
from gyrotest.records.spec import Output, OutputKind, Spec
from gyrotest.records.station import Accuracy, Instrument, Motion, Simulation, Slot, Station
from gyrotest.simulation.bench import SimulatedBench
from gyrotest.simulation.peer import Making
from gyrotest.simulation.scenarios import SCENARIOS
from gyrotest.simulation.server import has_pty
from gyrotest.simulation.table_peer import TablePeer
from gyrotest.units import Quantity

MOTION = Motion(
    max_rate=Quantity(200.0, "deg/s"), max_acceleration=Quantity(100.0, "deg/s/s"), slip_ring=True
)
ACCURACY = Accuracy(of_reading=Quantity(50.0, "ppm"), of_setting=Quantity(0.0005, "deg/s"))
SPEC = Spec(
    model="SIM50",
    output=Output(
        kind=OutputKind.VOLTAGE,
        scale_factor=Quantity(50.0, "mV/(deg/s)"),
        zero_rate=Quantity(2.5, "V"),
        bandwidth=Quantity(50.0, "Hz"),
    ),
    cases={},
)
DURATION_S = 20.0
TABLES = [
    ("acutrol3000", "simulated:tcp", {}),
    ("acutrol3000", "simulated:tcp", {"dialect": "status"}),
    pytest.param(
        ("aerosmith", "simulated:pty", {}),
        marks=pytest.mark.skipif(not has_pty(), reason="this platform has no pseudo-terminals"),
    ),
]
Entry = tuple[str, str, Mapping[str, Any]]


def station(entry: Entry, scenario: str = "nominal", table: Mapping[str, Any] | None = None) -> Station:
    driver, resource, settings = entry
    return Station(
        name="bench",
        instruments={
            "meter": Instrument(driver="keysight34465a", resource="simulated:tcp"),
            "table": Instrument(
                driver=driver,
                resource=resource,
                settings=settings,
                accuracy=ACCURACY,
                motion=MOTION,
            ),
        },
        slots={"a": Slot(source="meter", table="table")},
        line_frequency=Quantity(50.0, "Hz"),
        simulation=Simulation(scenario=scenario, instruments={} if table is None else {"table": table}),
    )


@contextmanager
def bench(entry: Entry, scenario: str = "nominal", seed: int = 1) -> Iterator[SimulatedBench]:
    with SimulatedBench(station(entry, scenario), SPEC, seed=seed) as served:
        served.begin(
            slot="a",
            serial_number="1234",
            case="scale_factor",
            power_cycle=1,
            repeat=1,
            elapsed_s=600.0,
            duration_s=DURATION_S,
        )
        yield served


def table_driver(served: SimulatedBench, entry: Entry) -> RateTable:
    driver, _, settings = entry
    address = served.address("table")
    if driver == "aerosmith":
        return Aerosmith(address, AerosmithSettings(), clock=served.clock, motion=MOTION)
    chosen = Acutrol3000Settings(dialect=Dialect(settings.get("dialect", "plain")))
    return Acutrol3000(address, chosen, clock=served.clock, motion=MOTION)


def read_mean_v(served: SimulatedBench, drive: TableDrive, count: int) -> float:
    meter = Keysight34465A(
        served.address("meter"),
        Keysight34465ASettings(),
        clock=served.clock,
        line_frequency_hz=50.0,
    )
    values: list[float] = []
    with closing(meter):
        meter.open()
        meter.configure(1.0)
        meter.start(0, count)
        while (block := meter.fetch()) is not None:
            values += block.values[:, 0].tolist()
            drive.watch()
    return float(np.mean(values))


@pytest.mark.parametrize("entry", TABLES)
def test_the_gyro_feels_what_the_table_turns(entry: Entry) -> None:
    with bench(entry) as served, closing(table_driver(served, entry)) as table:
        identity: Identity = table.open()
        drive = TableDrive(table, clock=served.clock, motion=MOTION)
        means = {}
        for rate_dps in (40.0, -40.0):
            drive.reach(Turning(rate_dps=rate_dps, settle_s=2.0))
            means[rate_dps] = read_mean_v(served, drive, 10)
            assert drive.read_back() == pytest.approx(rate_dps, abs=0.01)
        drive.rest()
        truth = served.truth("a", duration_s=DURATION_S)
    assert identity.simulated
    found = (means[40.0] - means[-40.0]) / 80.0
    expected = truth["scale_factor_v_per_dps"] * (1.0 + truth["table_gain_error"])
    # 0.5 °/√h over 10 s twice, against 80 °/s; the setting's own error.
    assert found == pytest.approx(expected, rel=2e-4)
    assert 0.0 < abs(truth["table_gain_error"]) <= 50e-6


def test_the_same_seed_turns_the_same_way_another_one_does_not() -> None:
    def turned(seed: int) -> float:
        entry: Entry = ("acutrol3000", "simulated:tcp", {})
        with bench(entry, seed=seed) as served, closing(table_driver(served, entry)) as table:
            table.open()
            drive = TableDrive(table, clock=served.clock, motion=MOTION)
            drive.reach(Turning(rate_dps=80.0, settle_s=2.0))
            return table.position_deg()

    assert turned(1) == turned(1)
    assert turned(1) != turned(2)


@pytest.mark.parametrize("entry", TABLES)
@pytest.mark.parametrize(
    ("scenario", "said"),
    [
        ("table-does-not-reach-rate", r"80 deg/s is demanded, 4[78]\.\d* deg/s read back"),
        ("table-refuses", "refused"),
    ],
)
def test_a_table_that_fails_from_the_start_is_an_error_and_rests(
    entry: Entry, scenario: str, said: str
) -> None:
    with bench(entry, scenario) as served, closing(table_driver(served, entry)) as table:
        table.open()
        drive = TableDrive(table, clock=served.clock, motion=MOTION)
        with pytest.raises(InstrumentError, match=said):
            drive.reach(Turning(rate_dps=80.0))


@pytest.mark.parametrize("entry", TABLES)
def test_an_interlock_in_the_middle_of_a_record_is_an_error(entry: Entry) -> None:
    said = "interlock fault" if entry[0] == "acutrol3000" else "left its rate"
    with bench(entry, "table-interlock") as served, closing(table_driver(served, entry)) as table:
        table.open()
        drive = TableDrive(table, clock=served.clock, motion=MOTION)
        drive.reach(Turning(rate_dps=40.0))
        with pytest.raises(InstrumentError, match=said):
            read_mean_v(served, drive, 20)


def test_every_wrong_figure_of_the_table_is_said_at_once() -> None:
    given = {"ripples": "1 %", "ripple": "1 deg/s", "settling_time_constant": "0 s"}
    with pytest.raises(StationError) as caught:
        TablePeer.check(station(("acutrol3000", "simulated", {}), table=given), "table")
    said = str(caught.value)
    assert "simulation.instruments.table.ripples: unknown key; did you mean 'ripple'?" in said
    assert "simulation.instruments.table.ripple: " in said
    assert "simulation.instruments.table.settling_time_constant: " in said


def test_a_table_without_a_word_on_its_motion_is_refused() -> None:
    silent = Station(
        name="bench",
        instruments={"table": Instrument(driver="aerosmith", resource="simulated:pty")},
        slots={"a": Slot(source="table")},
        simulation=Simulation(),
    )
    with pytest.raises(StationError, match=r"instruments\.table\.motion: a rate table needs it"):
        TablePeer.check(silent, "table")


def test_the_station_s_accuracy_is_what_the_errors_are_drawn_within() -> None:
    stated = station(("acutrol3000", "simulated", {}))
    with SimulatedBench(stated, SPEC) as served:
        peer = TablePeer(
            Making(
                station=stated,
                name="table",
                clock=served.clock,
                seed=1,
                scenario=SCENARIOS["nominal"],
            )
        )
    assert peer.table.parameters.gain_error == pytest.approx(50e-6)
    assert peer.table.parameters.setting_error_dps == pytest.approx(0.0005)
