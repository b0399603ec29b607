"""Power on, power cycles and what can go wrong with them."""

from typing import Any

import pytest

from gyrotest.acquisition.power import Power
from gyrotest.errors import InstrumentError
from gyrotest.records.bench import Supplied
from gyrotest.records.recording import Identity
from gyrotest.records.spec import Supply
from gyrotest.simulation.clock import VirtualClock
from gyrotest.simulation.supply import OutputFault, OutputFigures, SimulatedOutput
from gyrotest.units import Quantity

SPEC = Supply(
    voltage=Quantity(5.0, "V"),
    current_limit=Quantity(200.0, "mA"),
    over_voltage=Quantity(5.5, "V"),
    off_time=Quantity(10.0, "s"),
)


class Bench:
    """A supply that is one simulated output, and a list of what was done with it."""

    def __init__(self, figures: OutputFigures | None = None) -> None:
        self.clock = VirtualClock(50.0)
        self.output = SimulatedOutput(figures or OutputFigures(), self.clock)
        self.done: list[str] = []
        self.power = Power(self, SPEC, clock=self.clock)

    def open(self) -> Identity:
        return Identity(manufacturer="Maker", model="P1", serial_number="1")

    def set(self, *, voltage_v: float, current_limit_a: float, over_voltage_v: float) -> None:
        self.done.append(f"set {voltage_v:g} {current_limit_a:g} {over_voltage_v:g}")
        now_s = self.clock.now_s()
        self.output.set_protection(now_s, over_voltage_v)
        self.output.set_limit(now_s, current_limit_a)
        self.output.set_voltage(now_s, voltage_v)

    def on(self) -> None:
        self.done.append("on")
        self.output.switch(self.clock.now_s(), on=True)

    def off(self) -> None:
        self.done.append("off")
        self.output.switch(self.clock.now_s(), on=False)

    def measure(self) -> Supplied:
        now_s = self.clock.now_s()
        voltage_v = self.output.voltage_v(now_s)
        return Supplied(
            voltage_v=voltage_v,
            current_a=self.output.current_a(now_s),
            limiting=self.output.limiting(now_s),
            tripped=self.output.tripped,
        )

    def close(self) -> None:
        self.off()


def test_power_on_waits_for_the_voltage_and_says_what_was_found() -> None:
    bench = Bench(OutputFigures(load_a=0.042))
    text = bench.power.switch_on()
    assert bench.done == ["set 5 0.2 5.5", "on"]
    assert bench.power.is_on
    assert bench.power.switched_on_s == 50.0
    assert bench.output.voltage_v(bench.clock.now_s()) == pytest.approx(5.0, rel=0.05)
    assert "power on: " in text
    assert "mA" in text
    assert 50.0 < bench.clock.now_s() < 50.5


def test_a_power_cycle_waits_for_the_fall_and_then_for_the_off_time() -> None:
    bench = Bench(OutputFigures(fall_s=2.0))
    bench.power.switch_on()
    began_s = bench.clock.now_s()
    text = bench.power.cycle()
    fall_s = 2.0 * 3.9
    assert bench.done == ["set 5 0.2 5.5", "on", "off", "set 5 0.2 5.5", "on"]
    assert fall_s + 10.0 < bench.clock.now_s() - began_s < fall_s + 11.5
    since_s = bench.output.on_since_s
    assert since_s is not None
    assert since_s > began_s + fall_s + 10.0
    assert "off for 1" in text
    assert bench.power.is_on


def test_an_output_that_was_on_before_is_told() -> None:
    bench = Bench()
    bench.power.switch_on()
    assert "the output was at" in Power(bench, SPEC, clock=bench.clock).switch_on()


@pytest.mark.parametrize(
    ("figures", "message"),
    [
        (
            {"fault": OutputFault.NO_VOLTAGE},
            r"does not come up: 5 V at up to 0.2 A is asked for, found 0 V and 0 A",
        ),
        (
            {"fault": OutputFault.SHORTED},
            r"in current limit: 5 V at up to 0.2 A .* found 0.5 V and 0.2 A",
        ),
        ({"load_a": 0.3}, r"in current limit: .* is the unit connected with the right polarity"),
        ({"gain": 0.2}, r"over-voltage protection has tripped: .* protection at 5.5 V"),
        ({"gain": 0.09}, r"does something else feed the unit"),
        ({"rise_s": 60.0}, r"found 0.\d+ V and 0.\d+ A 5.* s after switching on"),
    ],
)
def test_a_power_on_that_fails_says_what_was_found_and_leaves_the_output_off(
    figures: dict[str, Any], message: str
) -> None:
    bench = Bench(OutputFigures(**figures))
    with pytest.raises(InstrumentError, match=message):
        bench.power.switch_on()
    assert bench.done[-1] == "off"
    assert not bench.power.is_on
    assert bench.clock.now_s() < 60.0


def test_an_inrush_at_the_limit_is_no_fault_when_it_passes() -> None:
    bench = Bench(OutputFigures(capacitance_f=10e-3, rise_s=0.1, load_a=0.05))
    assert "at most 200 mA seen" in bench.power.switch_on()


def test_a_unit_that_stays_in_current_limit_at_full_voltage_is_an_error() -> None:
    bench = Bench(OutputFigures(load_a=0.2))
    with pytest.raises(InstrumentError, match=r"in current limit: .* found 5 V and 0.2 A"):
        bench.power.switch_on()


def test_a_voltage_that_does_not_fall_is_an_error_and_the_unit_is_not_powered_again() -> None:
    bench = Bench(OutputFigures(fall_s=1e5))
    bench.power.switch_on()
    with pytest.raises(InstrumentError, match=r"5 V remain 60 s after switching off"):
        bench.power.cycle()
    assert bench.done[-1] == "off"
    assert not bench.power.is_on


def test_off_raises_nothing() -> None:
    class Gone(Bench):
        def off(self) -> None:
            raise InstrumentError("gone")

    bench = Gone()
    bench.power.switch_on()
    bench.power.off()
    assert not bench.power.is_on


def test_a_supply_that_still_gives_what_it_shall_is_left_on() -> None:
    bench = Bench(OutputFigures(load_a=0.042))
    bench.power.switch_on()
    bench.power.check()
    assert bench.power.is_on


def test_a_supply_that_failed_in_the_meantime_is_said_and_switched_off() -> None:
    bench = Bench(OutputFigures(load_a=0.042))
    bench.power.switch_on()
    bench.output.set_voltage(bench.clock.now_s(), 3.0)
    bench.clock.advance(60.0)
    with pytest.raises(InstrumentError, match="failed in the meantime: 5 V at up to"):
        bench.power.check()
    assert bench.done[-1] == "off"
    assert not bench.power.is_on
