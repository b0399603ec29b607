"""The temperature chamber byte by byte, and over a socket and a pseudo-terminal."""

from contextlib import closing
from typing import Any

import pytest

from gyrotest.acquisition.soaking import ChamberDrive
from gyrotest.errors import InstrumentError, InstrumentIdentityError, InstrumentProtocolError
from gyrotest.instruments.scpi_chamber import ScpiChamber, ScpiChamberSettings
from gyrotest.instruments.transport.dialogue import Dialogue, Turn
from gyrotest.records.plan import Soaking
from gyrotest.simulation.chamber import ChamberFigures, SimulatedChamber, speaker_of
from gyrotest.simulation.clock import VirtualClock
from gyrotest.simulation.dialogue import LineDialogue
from gyrotest.simulation.meter_state import Interface
from gyrotest.simulation.server import PtyServer, TcpServer, has_pty
from gyrotest.units import Quantity
from tests.instruments.meter_turns import ERRORS, StepClock

IDN: Turn = (b"*IDN?\n", b"Maker,TC-7,12345,1.0\n")


def chamber(wire: Dialogue, *, serial_number: str | None = None, **settings: Any) -> ScpiChamber:
    return ScpiChamber(
        "TCPIP::chamber::5025::SOCKET",
        ScpiChamberSettings(**settings),
        clock=StepClock(),
        serial_number=serial_number,
        connect=wire.connect,
    )


def test_a_temperature_is_set_read_and_the_chamber_left_at_rest() -> None:
    turns: list[Turn] = [
        IDN,
        (b"SOUR:TEMP -40.00\n", None),
        (b"OUTP ON\n", None),
        (b"MEAS:TEMP?\n", b"+2.31E+01\n"),
        (b"OUTP OFF\n", None),
        (b"MEAS:TEMP?\n", b"+2.31E+01\n"),
    ]
    with Dialogue(turns) as wire:
        one = chamber(wire)
        assert one.open().model == "TC-7"
        one.set_temperature(-40.0)
        assert one.temperature_degc() == 23.1
        one.close()
        one.close()


def test_a_chamber_with_commands_of_its_own_can_be_used() -> None:
    turns: list[Turn] = [
        (b"TEMP,S25.0\n", b"OK:TEMP,S25.0\n"),
        (b"TEMP?\n", b"23.4,25.0,100.0,-50.0\n"),
        (b"SET?\n", b"S 25.0 C\n"),
    ]
    standby: Turn = (b"STANDBY\n", b"OK\n")
    with Dialogue([turns[0], turns[2], turns[1], standby, turns[1]]) as wire:
        one = chamber(
            wire,
            set="TEMP,S{value:.1f}",
            ask="TEMP?",
            ask_set="SET?",
            start="",
            stop="STANDBY",
            acknowledges=True,
            identify="",
        )
        assert one.open().serial_number == "not stated"
        one.set_temperature(25.0)
        assert one.temperature_degc() == 23.4
        one.close()


def test_a_chamber_without_a_stop_is_left_at_a_temperature() -> None:
    asked: Turn = (b"MEAS:TEMP?\n", b"59.9\n")
    turns: list[Turn] = [IDN, (b"T=60\n", None), *ERRORS, (b"T=23\n", None), *ERRORS, asked]
    with Dialogue(turns) as wire:
        one = chamber(
            wire, set="T={value:.0f}", start="", stop="", at_rest=Quantity(23.0, "degC"), errors=True
        )
        one.open()
        one.set_temperature(60.0)
        one.close()


def test_a_chamber_that_was_not_set_running_here_is_left_alone() -> None:
    with Dialogue([IDN]) as wire:
        one = chamber(wire)
        one.open()
        one.close()


@pytest.mark.parametrize("temperature_degc", [-41.0, 86.0])
def test_a_temperature_beyond_what_the_station_allows_is_never_sent(temperature_degc: float) -> None:
    with Dialogue([IDN]) as wire:
        one = chamber(wire, coldest=Quantity(-40.0, "degC"), hottest=Quantity(85.0, "degC"))
        one.open()
        with pytest.raises(InstrumentError, match="the station allows -40 degC to 85 degC"):
            one.set_temperature(temperature_degc)


@pytest.mark.parametrize(
    ("turns", "message"),
    [
        ([(b"MEAS:TEMP?\n", b"ERR\n")], "MEAS:TEMP\\? gives 'ERR', expected a temperature"),
        ([(b"MEAS:TEMP?\n", TimeoutError())], "no reply to MEAS:TEMP\\? within 5 s"),
    ],
)
def test_an_answer_that_is_no_temperature_is_told(turns: list[Turn], message: str) -> None:
    with Dialogue([IDN, *turns]) as wire:
        one = chamber(wire)
        one.open()
        with pytest.raises(InstrumentError, match=message):
            one.temperature_degc()


def test_a_setting_that_was_not_taken_is_refused() -> None:
    turns: list[Turn] = [
        IDN,
        (b"SOUR:TEMP 60.00\n", None),
        (b"OUTP ON\n", None),
        (b"SOUR:TEMP?\n", b"50\n"),
    ]
    with Dialogue(turns) as wire:
        one = chamber(wire, ask_set="SOUR:TEMP?")
        one.open()
        with pytest.raises(
            InstrumentProtocolError, match=r"\(TC-7\): SOUR:TEMP\? gives 50 °C, expected 60"
        ):
            one.set_temperature(60.0)


@pytest.mark.parametrize(
    ("turn", "settings", "serial_number", "message"),
    [
        (IDN, {"identity": "Other"}, None, "found Maker TC-7 .* expected 'Other'"),
        (IDN, {}, "999", "with serial number 12345, expected 999"),
        ((b"*IDN?\n", b"?\n"), {}, None, "gives '\\?', expected the four fields"),
    ],
)
def test_another_instrument_is_refused_and_left(
    turn: Turn, settings: dict[str, Any], serial_number: str | None, message: str
) -> None:
    wire = Dialogue([turn])
    with pytest.raises((InstrumentIdentityError, InstrumentProtocolError), match=message):
        chamber(wire, serial_number=serial_number, **settings).open()
    assert wire.closed == 1


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        ({"set": "SOUR:TEMP 25"}, "has no {value}"),
        ({"set": "SOUR:TEMP {degrees}"}, "cannot be filled in"),
        ({"reading": "("}, "reading '\\(' is no regular expression"),
        ({"stop": ""}, "neither 'stop' nor 'at_rest'"),
        ({"coldest": Quantity(90.0, "degC"), "hottest": Quantity(80.0, "degC")}, "is not below hottest"),
        ({"stop_bits": 3}, "stop_bits 3"),
    ],
)
def test_settings_are_checked(settings: dict[str, Any], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        ScpiChamberSettings(**settings)


def soaked(address: str, clock: VirtualClock) -> float | None:
    """The temperature that is read back in a dwell at 60 °C."""
    driver = ScpiChamber(address, ScpiChamberSettings(ask_set="SOUR:TEMP?", errors=True), clock=clock)
    with closing(driver):
        assert driver.open().simulated
        drive = ChamberDrive(driver, clock=clock)
        drive.reach(Soaking(temperature_degc=60.0, soak_s=1200.0))
        drive.watch()
        return drive.read_back()


def test_a_temperature_is_reached_over_a_socket_and_left_at_the_end() -> None:
    clock = VirtualClock()
    simulated = SimulatedChamber(clock=clock)
    speaker = speaker_of(simulated, clock)
    with TcpServer(lambda: LineDialogue(speaker, Interface.SOCKET), clock) as server:
        found = soaked(f"TCPIP::127.0.0.1::{server.port}::SOCKET", clock)
    assert found == pytest.approx(60.0, abs=0.02)
    assert not simulated.running


@pytest.mark.skipif(not has_pty(), reason="this platform has no pseudo-terminals")
def test_a_chamber_that_does_not_move_is_told_over_a_serial_line() -> None:
    clock = VirtualClock()
    simulated = SimulatedChamber(clock=clock, figures=ChamberFigures(stuck=True))
    speaker = speaker_of(simulated, clock)
    with (
        PtyServer(lambda: LineDialogue(speaker, Interface.SERIAL), clock) as server,
        pytest.raises(InstrumentError, match=r"60 °C is asked for, found 23\.00 °C after 20 min"),
    ):
        soaked(f"ASRL{server.path}::INSTR", clock)
    assert not simulated.running
