"""The power supply over a real socket and a pseudo-terminal, against the simulated one."""

from collections.abc import Iterator
from contextlib import closing, contextmanager
from dataclasses import dataclass

import pytest

from gyrotest.acquisition.power import Power
from gyrotest.errors import InstrumentError
from gyrotest.instruments.scpi_supply import ScpiSupply, ScpiSupplySettings, Select
from gyrotest.records.spec import Supply
from gyrotest.simulation.clock import VirtualClock
from gyrotest.simulation.dialogue import LineDialogue
from gyrotest.simulation.meter_state import Interface
from gyrotest.simulation.server import PtyServer, TcpServer, has_pty
from gyrotest.simulation.supply import OutputFault, OutputFigures, SimulatedSupply
from gyrotest.simulation.supply_commands import speaker_of
from gyrotest.units import Quantity

SPEC = Supply(
    voltage=Quantity(5.0, "V"),
    current_limit=Quantity(200.0, "mA"),
    over_voltage=Quantity(5.5, "V"),
    off_time=Quantity(10.0, "s"),
)
WAYS = [
    "tcp",
    pytest.param("pty", marks=pytest.mark.skipif(not has_pty(), reason="no pseudo-terminals here")),
]


@dataclass(frozen=True)
class Served:
    """A simulated supply behind a server."""

    supply: SimulatedSupply
    clock: VirtualClock
    address: str

    def driver(self, output: int = 1, select: Select = Select.NSEL) -> ScpiSupply:
        settings = ScpiSupplySettings(outputs=len(self.supply.outputs), select=select)
        return ScpiSupply(self.address, settings, clock=self.clock, output=output)


@contextmanager
def served(*outputs: OutputFigures, way: str = "tcp") -> Iterator[Served]:
    clock = VirtualClock(10.0)
    supply = SimulatedSupply(outputs=outputs, clock=clock)
    interface = Interface.SERIAL if way == "pty" else Interface.SOCKET
    speaker = speaker_of(supply, clock)
    if way == "pty":
        with PtyServer(lambda: LineDialogue(speaker, interface), clock) as pty:
            yield Served(supply, clock, f"ASRL{pty.path}::INSTR")
        return
    with TcpServer(lambda: LineDialogue(speaker, interface), clock) as tcp:
        yield Served(supply, clock, f"TCPIP::127.0.0.1::{tcp.port}::SOCKET")


@pytest.mark.parametrize("way", WAYS)
@pytest.mark.parametrize("select", list(Select))
def test_a_unit_is_powered_cycled_and_switched_off(way: str, select: Select) -> None:
    with served(OutputFigures(), OutputFigures(load_a=0.06), way=way) as bench:
        with closing(bench.driver(output=2, select=select)) as driver:
            assert driver.open().simulated
            power = Power(driver, SPEC, clock=bench.clock)
            assert "60 mA" in power.switch_on()
            first_s = bench.supply.output(2).on_since_s
            power.cycle()
            again_s = bench.supply.output(2).on_since_s
        assert first_s is not None
        assert again_s is not None
        assert again_s - first_s > 11.0
        assert not bench.supply.output(1).on
        assert not bench.supply.output(2).on


def test_closing_one_output_leaves_another_one_on() -> None:
    with served(OutputFigures(), OutputFigures()) as bench:
        first, second = bench.driver(1), bench.driver(2)
        with closing(second):
            for driver in (first, second):
                driver.open()
                Power(driver, SPEC, clock=bench.clock).switch_on()
            first.close()
            assert not bench.supply.output(1).on
            assert second.measure().voltage_v == pytest.approx(5.0, abs=0.01)


@pytest.mark.parametrize("way", WAYS)
@pytest.mark.parametrize(
    ("fault", "message"),
    [
        (OutputFault.NO_VOLTAGE, "the voltage does not come up: .* found 0 V and 0 A"),
        (OutputFault.SHORTED, "in current limit: .* found 0.5 V and 0.2 A"),
    ],
)
def test_a_voltage_that_does_not_come_up_is_told_with_its_cause_and_the_output_is_off(
    way: str, fault: OutputFault, message: str
) -> None:
    with served(OutputFigures(fault=fault), way=way) as bench, closing(bench.driver()) as driver:
        driver.open()
        with pytest.raises(InstrumentError, match=message):
            Power(driver, SPEC, clock=bench.clock).switch_on()
        assert not bench.supply.output(1).on


def test_a_protection_that_trips_is_told() -> None:
    with served(OutputFigures(gain=0.2)) as bench, closing(bench.driver()) as driver:
        driver.open()
        with pytest.raises(InstrumentError, match="over-voltage protection has tripped"):
            Power(driver, SPEC, clock=bench.clock).switch_on()


def test_a_setting_beyond_the_supply_is_refused_in_its_own_words() -> None:
    with served(OutputFigures()) as bench, closing(bench.driver()) as driver:
        driver.open()
        with pytest.raises(InstrumentError, match="Data out of range"):
            driver.set(voltage_v=40.0, current_limit_a=0.2, over_voltage_v=44.0)
