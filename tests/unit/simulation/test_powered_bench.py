"""Units on a supply, read by one scanner beside their temperature: what the simulated bench makes of them."""

from collections.abc import Iterator
from contextlib import ExitStack, closing

import numpy as np
import pytest

from gyrotest.acquisition.power import Power
from gyrotest.acquisition.soaking import ChamberDrive
from gyrotest.instruments.keysight34970a import Keysight34970A
from gyrotest.instruments.scanner_settings import BesideChannel, Function, Keysight34970ASettings
from gyrotest.instruments.scpi_chamber import ScpiChamber, ScpiChamberSettings
from gyrotest.instruments.scpi_supply import ScpiSupply, ScpiSupplySettings
from gyrotest.records.plan import Soaking
from gyrotest.records.spec import Output, OutputKind, Spec, Supply
from gyrotest.records.station import Instrument, Simulation, Slot, Station
from gyrotest.simulation.bench import SimulatedBench
from gyrotest.units import Quantity

SPEC = Spec(
    model="SIM50",
    output=Output(
        kind=OutputKind.VOLTAGE,
        scale_factor=Quantity(50.0, "mV/(deg/s)"),
        zero_rate=Quantity(2.5, "V"),
    ),
    cases={},
    supply=Supply(
        voltage=Quantity(5.0, "V"),
        current_limit=Quantity(100.0, "mA"),
        over_voltage=Quantity(5.5, "V"),
        off_time=Quantity(20.0, "s"),
    ),
)
UNITS = {"a": "1001", "b": "1002"}


def slot(channel: str, output: int) -> Slot:
    return Slot(
        source="scan",
        channel=channel,
        auxiliary={"temperature": "110"},
        supply="psu",
        supply_output=output,
        chamber="oven",
    )


@pytest.fixture
def bench() -> Iterator[SimulatedBench]:
    names = {"scan": "keysight34970a", "psu": "scpi_supply", "oven": "scpi_chamber"}
    station = Station(
        name="bench",
        instruments={
            name: Instrument(driver=driver, resource="simulated") for name, driver in names.items()
        },
        slots={"a": slot("101", 1), "b": slot("102", 2)},
        simulation=Simulation(
            instruments={"oven": {"offset_error": "0 degC"}, "psu": {"load_current": "30 mA"}}
        ),
    )
    with SimulatedBench(station, SPEC) as made:
        yield made


def begin(bench: SimulatedBench, case: str = "c") -> None:
    for name, serial_number in UNITS.items():
        bench.begin(
            slot=name,
            serial_number=serial_number,
            case=case,
            power_cycle=1,
            repeat=1,
            elapsed_s=600.0,
            duration_s=30.0,
        )


def power(bench: SimulatedBench, output: int, until: ExitStack) -> Power:
    settings = ScpiSupplySettings(outputs=2)
    supply = ScpiSupply(bench.address("psu"), settings, clock=bench.clock, output=output)
    until.enter_context(closing(supply))
    supply.open()
    assert SPEC.supply is not None
    return Power(supply, SPEC.supply, clock=bench.clock)


def scanner(bench: SimulatedBench) -> Keysight34970A:
    settings = Keysight34970ASettings(beside={"110": BesideChannel(function=Function.THERMOCOUPLE)})
    return Keysight34970A(bench.address("scan"), settings, clock=bench.clock, line_frequency_hz=50.0)


def means(source: Keysight34970A) -> list[float]:
    """The mean of 30 samples of both units and the temperature."""
    source.start(0, 30)
    values = []
    while (block := source.fetch()) is not None:
        values.append(block.values)
    found: list[float] = np.concatenate(values).mean(axis=0).tolist()
    return found


def test_units_answer_while_they_are_powered_and_share_a_sensor_in_the_chamber(
    bench: SimulatedBench,
) -> None:
    oven = ScpiChamber(bench.address("oven"), ScpiChamberSettings(), clock=bench.clock)
    with closing(scanner(bench)) as source, closing(oven), ExitStack() as until:
        oven.open()
        source.open()
        source.select(("101", "102"), ("110", "110"))
        first, second = power(bench, 1, until), power(bench, 2, until)
        assert "30 mA" in first.switch_on()
        second.switch_on()
        source.configure(1.0)
        begin(bench)
        both = means(source)
        for value, name in zip(both, UNITS, strict=False):
            truth = bench.truth(name, duration_s=30.0)
            wanted = truth["zero_rate"] + truth["scale_factor"] * truth["bias_dps"]
            assert value == pytest.approx(wanted, abs=2e-3)
        assert both[2] == pytest.approx(23.0, abs=0.01)

        second.off()
        bench.clock.sleep_until(bench.clock.now_s() + 10.0)
        ChamberDrive(oven, clock=bench.clock).reach(Soaking(temperature_degc=40.0, soak_s=1800.0))
        begin(bench, "d")
        one = means(source)
    assert one[0] == pytest.approx(both[0], abs=0.1)
    assert one[1] == pytest.approx(0.0, abs=0.01)
    assert one[2] == pytest.approx(40.0, abs=0.05)
