"""The simulated scanner: sweeps in time, memory, set-up of channels, and its place on the bench."""

import numpy as np
import pytest

from gyrotest.errors import StationError
from gyrotest.records.station import Accuracy, Instrument, Simulation, Slot, Station
from gyrotest.simulation.clock import VirtualClock
from gyrotest.simulation.converter import Converter, MeterErrors
from gyrotest.simulation.faults import Faults
from gyrotest.simulation.gyro import SteadyOutput
from gyrotest.simulation.meter_state import Interface
from gyrotest.simulation.occasion import Occasion
from gyrotest.simulation.peer import Making, Reading, Talking
from gyrotest.simulation.peers import make_peer, peer_class
from gyrotest.simulation.scanner import MEMORY, SimulatedScanner
from gyrotest.simulation.scanner_commands import speaker_of
from gyrotest.simulation.scenarios import SCENARIOS
from gyrotest.simulation.streams import Normals, generator
from gyrotest.units import Quantity

QUIET = Faults((), start_s=0.0, duration_s=0.0)
FORM = "FORM:READ:TIME ON;:FORM:READ:CHAN ON"


class Desk:
    """A scanner with a steady voltage of a hundredth of its number on each channel, and its clock."""

    def __init__(self, *channels: int, hurried: bool = False) -> None:
        self.clock = VirtualClock(50.0)
        scanner = SimulatedScanner(clock=self.clock, line_frequency_hz=50.0, hurried=hurried)
        exact = MeterErrors(gain=0.0, offset_of_range=0.0, noise_v=0.0)
        scanner.connect(
            {
                number: Converter(
                    SteadyOutput(0.01 * number), exact, Normals(generator(1, "test")), QUIET
                )
                for number in channels
            },
            QUIET,
        )
        self.scanner = scanner
        self._speaker = speaker_of(scanner, self.clock)

    def ask(self, message: str) -> str | None:
        reply = self._speaker.execute(message, Interface.SOCKET)
        return None if reply is None else b"".join(part for _, part in reply.parts).decode().strip()

    def readings(self) -> list[tuple[float, float, int]]:
        """What `R?` gives: value, time, channel of each."""
        text = self.ask("R?") or ""
        fields = text[2 + int(text[1]) :].split(",") if text != "#10" else []
        rows = np.reshape(fields, (-1, 3))
        return [(float(value), float(time), int(channel)) for value, time, channel in rows]


def test_the_identity_says_that_it_is_simulated() -> None:
    assert (Desk().ask("*IDN?") or "").split(",")[2].startswith("SIM")


def test_channels_are_read_one_after_another_and_sweeps_follow_the_timer() -> None:
    desk = Desk(101, 102)
    desk.ask(f"CONF:VOLT:DC 10,(@101,102);:TRIG:SOUR TIM;:TRIG:TIM 2;:TRIG:COUN INF;:{FORM}")
    desk.ask("INIT")
    assert desk.ask("R?") == "#10"
    begun_s = desk.clock.now_s()
    desk.clock.sleep_until(begun_s + 4.06)
    found = desk.readings()
    # A relay of 12 ms and a delay of 1 ms before each reading of two times 20 ms.
    assert [time for _, time, _ in found] == pytest.approx([0.013, 0.066, 2.013, 2.066, 4.013], abs=1e-3)
    assert [channel for _, _, channel in found] == [101, 102, 101, 102, 101]
    assert [value for value, _, _ in found][:2] == pytest.approx([1.01, 1.02], abs=3e-6)
    desk.ask("ABOR")
    desk.clock.advance(100.0)
    assert desk.readings() == []


def test_without_a_timer_sweeps_follow_at_once_as_many_as_were_asked_for() -> None:
    desk = Desk(101)
    desk.ask(f"CONF:VOLT:DC 10,(@101);:TRIG:COUN 3;:{FORM};:INIT")
    assert desk.ask("DATA:POIN?") == "+0"
    desk.clock.advance(10.0)
    assert [round(time, 3) for _, time, _ in desk.readings()] == [0.013, 0.066, 0.119]
    assert not desk.scanner.scanning


def test_the_scan_list_is_in_the_order_of_the_numbers() -> None:
    desk = Desk()
    desk.ask("ROUT:SCAN (@205,101:103)")
    assert desk.ask("ROUT:SCAN?") == "#218(@101,102,103,205)"
    assert desk.ask("ROUT:SCAN:SIZE?") == "+4"


def test_configuring_defines_the_scan_list_and_turns_time_and_channel_off() -> None:
    desk = Desk()
    desk.ask(f"{FORM};:CONF:VOLT:DC 1,(@104)")
    assert desk.ask("FORM:READ:TIME?;:FORM:READ:CHAN?;:ROUT:SCAN?") == "0;0;#16(@104)"
    assert desk.ask("VOLT:DC:RANG? (@104)") == "+1.00000000E+00"


def test_a_temperature_probe_gives_degrees_and_an_open_one_an_overload() -> None:
    desk = Desk(101)
    desk.ask(f"CONF:TEMP TC,K,(@101,102);:{FORM};:INIT")
    desk.clock.advance(1.0)
    assert [value for value, _, _ in desk.readings()] == pytest.approx([101.0, 9.9e37], abs=0.01)


def test_a_memory_that_is_full_keeps_the_newest_and_says_so() -> None:
    desk = Desk(101)
    desk.ask(
        "CONF:VOLT:DC 10,(@101);:VOLT:DC:NPLC 0.02,(@101);:ZERO:AUTO OFF,(@101);:TRIG:COUN INF;:INIT"
    )
    desk.clock.advance(0.014 * (MEMORY + 100))
    assert desk.ask("DATA:POIN?") == f"{MEMORY:+d}"
    assert desk.ask("STAT:QUES?") == "+4096"
    assert desk.ask("STAT:QUES?") == "+0"


def test_a_hurried_scanner_moves_on_to_the_next_sweep() -> None:
    desk = Desk(101, hurried=True)
    desk.ask(f"CONF:VOLT:DC 10,(@101);:TRIG:SOUR TIM;:TRIG:TIM 60;:TRIG:COUN INF;:{FORM};:INIT")
    assert [len(desk.readings()) for _ in range(3)] == [1, 1, 1]


@pytest.mark.parametrize(
    ("message", "code"),
    [
        ("CONF:VOLT:DC 10,(@121)", -222),
        ("CONF:VOLT:DC 10,(@401)", -222),
        ("CONF:VOLT:DC 1000,(@101)", -222),
        ("CONF:TEMP TC,Q,(@101)", -224),
        ("CONF:TEMP TC", -109),
        ("ROUT:SCAN (@1x1)", -102),
        ("VOLT:DC:NPLC 500,(@101)", -222),
        ("UNIT:TEMP F,(@101)", -224),
        ("FORM:READ:TIME:TYPE ABS", -221),
        ("INIT", -221),
        ("INP:IMP 1", -113),
    ],
)
def test_what_is_wrong_goes_into_the_error_queue(message: str, code: int) -> None:
    desk = Desk()
    desk.ask(message)
    assert (desk.ask("SYST:ERR?") or "").startswith(f"{code},")


def test_a_scan_under_way_is_not_begun_again() -> None:
    desk = Desk(101)
    desk.ask("CONF:VOLT:DC 10,(@101);:TRIG:COUN INF;:INIT")
    assert (desk.ask("INIT;:SYST:ERR?") or "").startswith("-213,")


def making(driver: str = "keysight34970a", **figures: str) -> Making:
    accuracy = Accuracy(of_reading=Quantity(40.0, "ppm"), of_range=Quantity(6.0, "ppm"))
    station = Station(
        name="bench",
        instruments={"scan": Instrument(driver=driver, resource="simulated", accuracy=accuracy)},
        slots={"a": Slot(source="scan", channel="101")},
        simulation=Simulation(instruments={"scan": figures} if figures else {}),
    )
    return Making(
        station=station, name="scan", clock=VirtualClock(), seed=1, scenario=SCENARIOS["nominal"]
    )


def told(peer: object, message: str) -> str:
    assert isinstance(peer, Talking)
    parts = peer.dialogue(Interface.SOCKET).receive(f"{message}\n".encode())
    return b"".join(part for _, part in parts).decode().strip()


def test_slots_are_connected_side_by_side_and_read_with_the_same_errors() -> None:
    made = making(noise="0 V")
    peer = make_peer(made)
    assert isinstance(peer, Reading)
    occasion = Occasion(serial_number="1")
    peer.begin(occasion)
    peer.connect(occasion, {"101": SteadyOutput(5.0)}, QUIET)
    peer.connect(occasion, {"102": SteadyOutput(5.0), "110": SteadyOutput(0.25)}, QUIET)
    told(peer, "CONF:TEMP RTD,85,(@110)")
    told(peer, "CONF:VOLT:DC 10,(@101,102);:ROUT:SCAN (@101,102,110);:INIT")
    made.clock.sleep_until(2.0)
    first, second, third = (float(one) for one in told(peer, "R?")[4:].split(","))
    truth = peer.truth()
    assert first == second == pytest.approx(5.0, abs=5.0 * 40e-6 + 10.0 * 6e-6)
    wanted = 5.0 * (1 + truth["meter_gain_error"]) + 10.0 * truth["meter_offset_of_range"]
    assert first == pytest.approx(wanted, abs=2e-6)
    assert third == pytest.approx(25.0, abs=0.01)


@pytest.mark.parametrize("model", ["34970A", "34972A", "DAQ970A", "DAQ973A"])
def test_each_model_of_the_family_can_stand_there(model: str) -> None:
    peer = make_peer(making(model=model))
    _, named, serial, _ = told(peer, "*IDN?").split(",", 3)
    assert named == model
    assert serial.startswith("SIM")
    word = "VOLT:DC:ZERO:AUTO" if model.startswith("DAQ") else "ZERO:AUTO"
    told(peer, f"{word} OFF,(@101)")
    assert told(peer, f"{word}? (@101);:SYST:ERR?") == '0;+0,"No error"'


@pytest.mark.parametrize(
    ("figures", "message"),
    [
        ({"noise": "3 A"}, "simulation.instruments.scan.noise"),
        ({"gain": "1 %"}, "simulation.instruments.scan.gain: unknown key"),
    ],
)
def test_wrong_figures_are_complained_of(figures: dict[str, str], message: str) -> None:
    made = making(**figures)
    with pytest.raises(StationError, match=message):
        peer_class(made.station, "scan").check(made.station, "scan")
    with pytest.raises(StationError, match=message):
        make_peer(made)


def test_a_slot_without_a_channel_number_is_complained_of() -> None:
    peer = make_peer(making())
    assert isinstance(peer, Reading)
    with pytest.raises(StationError, match="reads channels by number, and a slot names ''"):
        peer.connect(Occasion(serial_number="1"), {"": SteadyOutput(1.0)}, QUIET)
