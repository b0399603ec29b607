"""The simulated power supply: rise and fall, load, current limit, protection, its commands."""

import pytest

from gyrotest.simulation.clock import VirtualClock
from gyrotest.simulation.meter_state import Interface
from gyrotest.simulation.supply import OutputFault, OutputFigures, SimulatedSupply
from gyrotest.simulation.supply_commands import speaker_of


class Desk:
    """A supply and its clock."""

    def __init__(self, *outputs: OutputFigures) -> None:
        self.clock = VirtualClock(100.0)
        self.supply = SimulatedSupply(outputs=outputs or (OutputFigures(),), clock=self.clock)
        self._speaker = speaker_of(self.supply, self.clock)

    def ask(self, message: str) -> str | None:
        reply = self._speaker.execute(message, Interface.SOCKET)
        if reply is None:
            return None
        for ready_s, _ in reply.parts:
            self.clock.sleep_until(ready_s)
        return b"".join(part for _, part in reply.parts).decode().strip()

    def number(self, message: str) -> float:
        return float(self.ask(message) or "nan")

    def errors(self) -> str | None:
        return self.ask("SYST:ERR?")


def powered(desk: Desk, voltage: str = "5", limit: str = "0.2", protection: str = "5.5") -> Desk:
    desk.ask(f"VOLT:PROT {protection};:CURR {limit};:VOLT {voltage};:OUTP ON")
    return desk


def test_the_identity_says_that_it_is_simulated() -> None:
    assert (Desk().ask("*IDN?") or "").split(",")[2].startswith("SIM")


def test_the_voltage_rises_falls_and_the_unit_runs_from_four_fifths_of_it() -> None:
    desk = powered(Desk(OutputFigures(rise_s=0.02, fall_s=0.5)))
    output, began_s = desk.supply.output(1), desk.clock.now_s()
    assert output.on_since_s is None
    desk.clock.advance(0.2)
    assert desk.number("MEAS:VOLT?") == pytest.approx(5.0, abs=2e-3)
    assert output.on_since_s == pytest.approx(began_s + 0.02 * 1.609, abs=5e-3)
    desk.ask("OUTP OFF")
    off_s = desk.clock.now_s()
    desk.clock.sleep_until(off_s + 0.05)
    assert output.on_since_s is not None
    desk.clock.sleep_until(off_s + 0.2)
    assert output.on_since_s is None
    assert 2.0 < desk.number("MEAS:VOLT?") < 4.0
    desk.clock.sleep_until(off_s + 3.0)
    assert desk.number("MEAS:VOLT?") < 0.1


def test_power_that_was_away_only_for_a_moment_does_not_start_the_unit_anew() -> None:
    desk = powered(Desk(OutputFigures(fall_s=0.5)))
    desk.clock.advance(10.0)
    first_s = desk.supply.output(1).on_since_s
    desk.ask("OUTP OFF")
    desk.clock.advance(0.02)
    desk.ask("OUTP ON")
    desk.clock.advance(1.0)
    assert desk.supply.output(1).on_since_s == first_s
    desk.ask("OUTP OFF")
    desk.clock.advance(5.0)
    desk.ask("OUTP ON")
    desk.clock.advance(1.0)
    again_s = desk.supply.output(1).on_since_s
    assert first_s is not None
    assert again_s is not None
    assert again_s > first_s + 5.0


def test_the_load_draws_its_current_and_the_inrush_more() -> None:
    desk = powered(Desk(OutputFigures(load_a=0.04, capacitance_f=500e-6, rise_s=0.05)))
    assert desk.number("MEAS:CURR?") > 0.06
    desk.clock.advance(1.0)
    assert desk.number("MEAS:CURR?") == pytest.approx(0.04, abs=1e-4)


def test_a_load_beyond_the_limit_pulls_the_voltage_down() -> None:
    desk = powered(Desk(OutputFigures(load_a=0.4)))
    desk.clock.advance(1.0)
    assert desk.number("MEAS:CURR?") == pytest.approx(0.2)
    assert desk.number("MEAS:VOLT?") < 1.0
    assert int(desk.number("STAT:QUES:COND?")) & 1
    assert desk.supply.output(1).on_since_s is None


def test_the_protection_trips_and_stays_off_until_it_is_cleared() -> None:
    desk = powered(Desk(OutputFigures(fall_s=0.1)), protection="4")
    desk.clock.advance(3.0)
    assert desk.ask("VOLT:PROT:TRIP?;:OUTP?") == "1;0"
    assert desk.number("MEAS:VOLT?") < 0.1
    desk.ask("OUTP ON")
    assert desk.ask("OUTP?") == "0"
    desk.ask("VOLT:PROT 5.5;:VOLT:PROT:CLE;:OUTP ON")
    desk.clock.advance(1.0)
    assert desk.number("MEAS:VOLT?") == pytest.approx(5.0, abs=2e-3)


def test_a_protection_set_below_the_present_voltage_trips_at_once() -> None:
    desk = powered(Desk())
    desk.clock.advance(1.0)
    desk.ask("VOLT:PROT 3")
    assert desk.ask("VOLT:PROT:TRIP?") == "1"


@pytest.mark.parametrize(
    ("fault", "voltage_v", "current_a"),
    [(OutputFault.NO_VOLTAGE, 0.0, 0.0), (OutputFault.SHORTED, 0.5, 0.2)],
)
def test_a_faulty_output_gives_no_proper_voltage(
    fault: OutputFault, voltage_v: float, current_a: float
) -> None:
    desk = powered(Desk(OutputFigures(fault=fault)))
    desk.clock.advance(1.0)
    assert desk.number("MEAS:VOLT?") == pytest.approx(voltage_v, abs=2e-3)
    assert desk.number("MEAS:CURR?") == pytest.approx(current_a, abs=2e-3)
    assert desk.supply.output(1).on_since_s is None


def test_outputs_are_told_apart_by_selection_and_by_channel_list() -> None:
    desk = Desk(OutputFigures(), OutputFigures(), OutputFigures())
    desk.ask("INST:NSEL 2;:VOLT 3")
    desk.ask("VOLT 7,(@3)")
    assert desk.number("VOLT? (@1)") == 0.0
    assert desk.number("VOLT?") == 3.0
    assert desk.number("VOLT? (@3)") == 7.0
    assert desk.ask("INST:NSEL?") == "2"
    desk.ask("INST:NSEL 4")
    assert (desk.errors() or "").startswith("-222")
    desk.ask("OUTP ON,(@9)")
    assert (desk.errors() or "").startswith("-222")


@pytest.mark.parametrize(
    ("message", "code"),
    [
        ("VOLT 99", -222),
        ("VOLT", -109),
        ("OUTP MAYBE", -224),
        ("VOLT:PROT:STAT OFF", -221),
        ("POWER 1", -113),
    ],
)
def test_what_is_wrong_goes_into_the_error_queue(message: str, code: int) -> None:
    desk = Desk()
    desk.ask(message)
    assert (desk.errors() or "").startswith(f"{code},")
    assert desk.errors() == '+0,"No error"'


def test_reset_switches_everything_off() -> None:
    desk = powered(Desk())
    desk.clock.advance(1.0)
    desk.ask("*RST")
    assert desk.ask("OUTP?") == "0"
    assert desk.number("VOLT?") == 0.0
