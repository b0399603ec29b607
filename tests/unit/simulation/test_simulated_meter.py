"""The simulated multimeters: dialogue, timing, memory, errors, overload."""

import struct

import numpy as np
import pytest

from gyrotest.simulation.clock import VirtualClock
from gyrotest.simulation.converter import Converter, MeterErrors
from gyrotest.simulation.faults import Faults
from gyrotest.simulation.gyro import SteadyOutput
from gyrotest.simulation.meter import Meter
from gyrotest.simulation.meter_peer import new_meter
from gyrotest.simulation.meter_state import Interface
from gyrotest.simulation.scenarios import SCENARIOS, Strike
from gyrotest.simulation.streams import Normals, generator


class Desk:
    """A meter on a steady voltage, and its clock."""

    def __init__(
        self,
        model: str = "34401A",
        *,
        voltage_v: float = 2.5,
        interface: Interface = Interface.SOCKET,
        noise_v: float = 0.0,
        gain: float = 0.0,
        strikes: tuple[Strike, ...] = (),
    ) -> None:
        self.clock = VirtualClock()
        self.interface = interface
        self.meter: Meter = new_meter(
            model, serial_number="SIM00001", line_frequency_hz=50.0, clock=self.clock, live=False
        )
        self.meter.connect(
            Converter(
                SteadyOutput(voltage_v),
                MeterErrors(gain=gain, offset_of_range=0.0, noise_v=noise_v),
                Normals(generator(1, "test")),
                Faults(strikes, start_s=0.0, duration_s=100.0),
            )
        )

    def ask(self, message: str) -> bytes | None:
        reply = self.meter.execute(message, self.interface)
        if reply is None:
            return None
        said = b""
        for ready_s, part in reply.parts:
            self.clock.sleep_until(ready_s)
            said += part
        return said

    def error(self) -> bytes | None:
        return self.ask("SYST:ERR?")


NO_ERROR = b'+0,"No error"\n'


@pytest.mark.parametrize("model", ["34401A", "34465A"])
def test_the_identity_says_that_it_is_simulated(model: str) -> None:
    _, named, serial, _ = (Desk(model).ask("*idn?") or b"").decode().split(",")
    assert named == model
    assert serial.startswith("SIM")


def test_a_reading_is_printed_as_the_real_meter_prints_it() -> None:
    desk = Desk()
    desk.ask("CONF:VOLT:DC 10,1E-5")
    assert desk.ask("READ?") == b"+2.50000000E+00\n"
    assert desk.error() == NO_ERROR


@pytest.mark.parametrize(
    ("set_up", "busy_s"),
    [
        ("VOLT:DC:NPLC 10;:ZERO:AUTO ON;:TRIG:DEL 0", 0.4),
        ("VOLT:DC:NPLC 10;:ZERO:AUTO OFF;:TRIG:DEL 0", 0.2),
        ("VOLT:DC:NPLC 100;:ZERO:AUTO ON;:TRIG:DEL 0", 4.0),
        ("VOLT:DC:NPLC 0.02;:ZERO:AUTO OFF;:TRIG:DEL 0", 0.001),
        ("VOLT:DC:NPLC 10;:ZERO:AUTO OFF;:TRIG:DEL 0.5", 0.7),
        ("VOLT:DC:NPLC 1;:ZERO:AUTO ON;:TRIG:DEL 0;:SAMP:COUN 20", 0.8),
        ("VOLT:DC:NPLC 1;:ZERO:AUTO OFF;:TRIG:DEL 0.01;:SAMP:COUN 1000", 30.0),
    ],
)
def test_readings_take_their_time(set_up: str, busy_s: float) -> None:
    desk = Desk()
    desk.ask(set_up)
    desk.ask("READ?")
    assert desk.clock.now_s() == pytest.approx(busy_s)


def test_configure_resets_trigger_samples_and_autozero() -> None:
    desk = Desk()
    desk.ask("SAMP:COUN 7;:TRIG:COUN 3;DEL 1;:ZERO:AUTO OFF")
    desk.ask("CONF:VOLT:DC 10,3E-6")
    assert desk.ask("SAMP:COUN?;:TRIG:COUN?;:TRIG:DEL:AUTO?;:ZERO:AUTO?;:VOLT:DC:NPLC?") == (
        b"+1.00000000E+00;+1.00000000E+00;1;1;+1.00000000E+02\n"
    )


def test_settings_are_read_back() -> None:
    desk = Desk()
    desk.ask("VOLT:DC:RANG 3;NPLC 0.5;:INP:IMP:AUTO ON;:TRIG:SOUR BUS")
    assert desk.ask("VOLT:DC:RANG?;NPLC?;:INP:IMP:AUTO?;:TRIG:SOUR?") == (
        b"+1.00000000E+01;+1.00000000E+00;1;BUS\n"
    )


def test_an_unknown_command_is_put_in_the_queue_and_answers_nothing() -> None:
    desk = Desk()
    assert desk.ask("FOO:BAR?") is None
    assert desk.error() == b'-113,"Undefined header"\n'
    assert desk.error() == NO_ERROR


@pytest.mark.parametrize(
    ("message", "code"),
    [
        ("VOLT:DC:NPLC 1000", b"-222"),
        ("VOLT:DC:NPLC ten", b"-104"),
        ("VOLT:DC:NPLC", b"-109"),
        ("VOLT:DC:NPLC 1,2", b"-108"),
        ("SAMP:COUN 50001", b"-222"),
        ("TRIG:SOUR NEVER", b"-224"),
        ("CONF:VOLT:DC 10,1E-9", b"+532"),
        ("FETC?", b"-230"),
        ("*TRG", b"-211"),
        ("SAMP:TIM 1", b"-113"),
        ("TRIG:SOUR EXT;:READ?", b"-214"),
    ],
)
def test_a_refused_command_leaves_its_code(message: str, code: bytes) -> None:
    desk = Desk()
    assert desk.ask(message) is None
    assert (desk.error() or b"").split(b",")[0] == code


def test_the_34401a_keeps_512_readings_and_no_more() -> None:
    desk = Desk()
    desk.ask("ZERO:AUTO OFF;:TRIG:DEL 0;:VOLT:NPLC 1;:SAMP:COUN 513;:INIT")
    assert desk.error() == b'+531,"Insufficient memory"\n'
    desk.ask("SAMP:COUN 512;:INIT")
    assert desk.ask("DATA:POIN?") == b"+0\n"
    assert (desk.ask("FETC?") or b"").count(b",") == 511
    assert desk.ask("DATA:POIN?") == b"+512\n"
    assert desk.clock.now_s() == pytest.approx(512 * 0.02)


def test_read_is_not_limited_by_the_memory() -> None:
    desk = Desk()
    desk.ask("ZERO:AUTO OFF;:TRIG:DEL 0;:VOLT:NPLC 1;:SAMP:COUN 3000")
    assert (desk.ask("READ?") or b"").count(b",") == 2999


def test_init_measures_while_the_host_does_something_else() -> None:
    desk = Desk()
    desk.ask("TRIG:DEL 0;:SAMP:COUN 4;:INIT")
    desk.clock.sleep_until(0.9)
    assert desk.ask("DATA:POIN?") == b"+2\n"
    desk.ask("INIT")
    assert desk.error() == b'-213,"Init ignored"\n'
    assert desk.ask("*OPC?") == b"1\n"
    assert desk.clock.now_s() == pytest.approx(1.6)


def test_a_bus_trigger_starts_the_readings() -> None:
    desk = Desk()
    desk.ask("TRIG:SOUR BUS;:INIT")
    desk.clock.sleep_until(5.0)
    assert desk.ask("DATA:POIN?") == b"+0\n"
    desk.ask("*TRG")
    assert desk.ask("FETC?") == b"+2.50000000E+00\n"


@pytest.mark.parametrize(
    ("voltage_v", "reading"), [(12.5, b"+9.90000000E+37\n"), (-12.5, b"-9.90000000E+37\n")]
)
def test_more_than_120_percent_of_the_range_is_an_overload(voltage_v: float, reading: bytes) -> None:
    desk = Desk(voltage_v=voltage_v)
    desk.ask("CONF:VOLT:DC 10")
    assert desk.ask("READ?") == reading
    desk.ask("SAMP:COUN 20")
    assert desk.ask("READ?") == b",".join([reading.strip()] * 20) + b"\n"


def test_autorange_finds_the_range() -> None:
    desk = Desk(voltage_v=12.5)
    desk.ask("CONF:VOLT:DC")
    assert desk.ask("READ?") == b"+1.25000000E+01\n"


def test_noise_falls_with_the_integration_time() -> None:
    def spread(nplc: str) -> float:
        desk = Desk(noise_v=1e-3)
        desk.ask(f"CONF:VOLT:DC 10;:VOLT:NPLC {nplc};:SAMP:COUN 4000")
        return float(np.std([float(one) for one in (desk.ask("READ?") or b"").split(b",")]))

    assert spread("10") == pytest.approx(1e-3, rel=0.05)
    assert spread("1") == pytest.approx(1e-3 * 10**0.5, rel=0.05)


def test_readings_over_rs_232_need_remote_first() -> None:
    desk = Desk(interface=Interface.SERIAL)
    assert desk.ask("READ?") is None
    assert desk.error() == b'+550,"Command not allowed in local"\r\n'
    desk.ask("SYST:REM")
    assert desk.ask("READ?") == b"+2.50000000E+00\r\n"


def timed(desk: Desk, *, count: int = 3600, timer: str = "1") -> None:
    desk.ask("CONF:VOLT:DC 10;:VOLT:DC:NPLC 10;ZERO:AUTO ON;:TRIG:SOUR IMM;COUN 1;DEL 0;:SAMP:SOUR TIM")
    desk.ask(f"SAMP:TIM {timer};COUN {count};:FORM:DATA REAL,64;:INIT")


def test_the_34465a_paces_its_samples_itself() -> None:
    desk = Desk("34465A")
    timed(desk)
    assert desk.error() == NO_ERROR
    desk.clock.sleep_until(10.0)
    reply = desk.ask("R?") or b""
    # The tenth began at 9 s and was ready at 9.4 s.
    assert reply[:4] == b"#280"
    assert struct.unpack(">10d", reply[4:-1]) == pytest.approx((2.5,) * 10)
    assert desk.ask("R?") == b"#10\n"
    assert desk.clock.now_s() == 10.0


def test_the_34465a_tells_how_many_are_there_and_stops() -> None:
    desk = Desk("34465A")
    timed(desk, count=5)
    desk.clock.sleep_until(3.0)
    assert desk.ask("DATA:POIN?;:STAT:OPER:COND?") == b"+3;+16\n"
    desk.clock.sleep_until(30.0)
    assert desk.ask("DATA:POIN?;:STAT:OPER:COND?") == b"+5;+0\n"


def test_the_34465a_tells_that_its_memory_overflowed() -> None:
    desk = Desk("34465A")
    desk.ask(
        "CONF:VOLT:DC 10;:VOLT:DC:NPLC 0.02;ZERO:AUTO OFF;:SAMP:SOUR TIM;TIM 0.002;COUN 60000;:INIT"
    )
    desk.clock.sleep_until(200.0)
    assert desk.ask("DATA:POIN?;:STAT:QUES?;:STAT:QUES:COND?") == b"+50000;+16384;+16384\n"
    assert desk.ask("STAT:QUES?") == b"+0\n"


def test_the_sample_timer_is_quantised_and_its_minimum_is_known() -> None:
    desk = Desk("34465A")
    desk.ask("VOLT:DC:NPLC 10;ZERO:AUTO ON;:SAMP:TIM 0.5000004")
    assert desk.ask("SAMP:TIM?;TIM? MIN") == b"+5.00000000E-01;+4.00020000E-01\n"


def test_ascii_blocks_and_swapped_bytes() -> None:
    desk = Desk("34465A")
    timed(desk, count=2)
    desk.clock.sleep_until(10.0)
    desk.ask("FORM:BORD SWAP")
    assert (desk.ask("FETC?") or b"")[4:-1] == struct.pack("<2d", 2.5, 2.5)
    desk.ask("FORM:DATA ASC")
    assert desk.ask("R?") == b"#231+2.50000000E+00,+2.50000000E+00\n"


def test_abort_ends_the_samples_and_keeps_what_is_there() -> None:
    desk = Desk("34465A")
    timed(desk)
    desk.clock.sleep_until(5.0)
    desk.ask("ABOR")
    desk.clock.sleep_until(50.0)
    assert desk.ask("DATA:POIN?") == b"+5\n"


def test_remove_waits_for_the_readings_asked_for() -> None:
    desk = Desk("34465A")
    timed(desk)
    assert len(desk.ask("DATA:REM? 4,WAIT") or b"") == 4 + 32 + 1
    assert desk.clock.now_s() == pytest.approx(3.4)


def test_a_lost_reply_is_lost_once() -> None:
    desk = Desk(strikes=SCENARIOS["meter-timeout"].strikes)
    desk.clock.sleep_until(41.0)
    assert desk.ask("*IDN?") is not None
    assert desk.ask("READ?") is None
    assert desk.ask("READ?") == b"+2.50000000E+00\n"


def test_a_dead_meter_answers_nothing_ever_again() -> None:
    desk = Desk(strikes=SCENARIOS["meter-dead"].strikes)
    desk.clock.sleep_until(41.0)
    assert desk.ask("READ?") is None
    assert desk.ask("*IDN?") is None


def test_garbled_replies_are_no_numbers() -> None:
    desk = Desk(strikes=SCENARIOS["garbled-replies"].strikes)
    replies = []
    for k in range(100):
        desk.clock.sleep_until(float(k))
        replies.append(desk.ask("READ?"))
    assert len([reply for reply in replies if reply != b"+2.50000000E+00\n"]) == 3


def test_a_stuck_meter_repeats_its_last_reading() -> None:
    desk = Desk(noise_v=1e-3, strikes=SCENARIOS["stuck-reading"].strikes)
    desk.ask("CONF:VOLT:DC 10;:TRIG:DEL 0;:SAMP:COUN 200")
    values = (desk.ask("READ?") or b"").strip().split(b",")
    assert len(set(values[:120])) > 100
    assert len(set(values[126:])) == 1
    desk.ask("SAMP:COUN 1")
    assert desk.ask("READ?") == values[-1] + b"\n"


def test_status_registers_tell_of_errors() -> None:
    desk = Desk()
    desk.ask("*ESE 60;*SRE 32;FOO")
    assert desk.ask("*STB?;*ESR?;*ESR?") == b"+96;+32;+0\n"


@pytest.mark.parametrize(
    ("message", "reply"),
    [
        ("CONF:VOLT:DC 10,1E-5;:CONF?", b'"VOLT +1.000000E+01,+1.000000E-05"\n'),
        ("CONF:VOLT:DC 10,MAX;:VOLT:NPLC?", b"+2.00000000E-02\n"),
        ("CONF:VOLT:DC 10,MIN;:VOLT:NPLC?", b"+1.00000000E+02\n"),
        ("VOLT:RANG 10;RES 1E-4;NPLC?", b"+2.00000000E-01\n"),
        ("VOLT:RANG 10;RES? MAX", b"+1.00000000E-03\n"),
        ("VOLT:RANG:AUTO OFF;AUTO?", b"0\n"),
        ("VOLT:RANG:AUTO ON;AUTO?", b"1\n"),
        ("VOLT:NPLC? MIN;NPLC? MAX", b"+2.00000000E-02;+1.00000000E+02\n"),
        ("ZERO:AUTO ONCE;AUTO?", b"0\n"),
        ("TRIG:COUN INF;COUN?", b"+9.90000000E+37\n"),
        ("TRIG:DEL:AUTO OFF;AUTO?", b"0\n"),
        ('FUNC "VOLT:DC";FUNC?', b'"VOLT"\n'),
        ("MEAS:VOLT:DC? 10,1E-5", b"+2.50000000E+00\n"),
        ("*OPC;*ESR?", b"+1\n"),
        ("*WAI;*TST?", b"+0\n"),
        ("*ESE 4;*ESE?;*SRE 8;*SRE?", b"+4;+8\n"),
        ("*RST;*CLS;:SYST:ERR?", NO_ERROR),
        ('DISP OFF;DISP:TEXT "hi";TEXT:CLE;:SYST:BEEP;LOC;:SYST:ERR?', NO_ERROR),
        ("STAT:QUES:ENAB 512;ENAB?", b"+512\n"),
        ('DISP:TEXT "hi";TEXT?;:DISP OFF;:DISP?', b'"hi";0\n'),
        ("ROUT:TERM?;:CALC:STAT OFF;STAT?", b"FRON;0\n"),
    ],
)
def test_the_34401a_answers(message: str, reply: bytes) -> None:
    desk = Desk()
    assert desk.ask(message) == reply
    assert desk.error() == NO_ERROR


@pytest.mark.parametrize(
    ("message", "reply"),
    [
        ("VOLT:DC:IMP:AUTO ON;AUTO?", b"1\n"),
        ("SAMP:SOUR TIM;SOUR?", b"TIM\n"),
        ("SAMP:TIM MIN;TIM?", b"+4.00020000E-01\n"),
        ("SAMP:TIM? MAX", b"+3.60000000E+03\n"),
        ("FORM:DATA?", b"ASC,9\n"),
        ("FORM:DATA REAL,64;DATA?", b"REAL,64\n"),
        ("FORM:BORD SWAP;BORD?", b"SWAP\n"),
        ("DATA:LAST?", b"+9.91000000E+37 VDC\n"),
        ("SAMP:COUN 3;:INIT;*OPC?;:DATA:LAST?", b"1;+2.50000000E+00 VDC\n"),
        (
            "SAMP:COUN 3;:INIT;*OPC?;:R? 2;R?",
            b"1;#231" + b"+2.50000000E+00,+2.50000000E+00;#215+2.50000000E+00\n",
        ),
        ("SAMP:COUN 2;:READ?", b"+2.50000000E+00,+2.50000000E+00\n"),
        ("TRIG:SOUR BUS;:INIT;:STAT:OPER:COND?", b"+32\n"),
        ("STAT:QUES:ENAB 9;:STAT:PRES;QUES:ENAB?", b"+0\n"),
        ("SYST:LFR?", b"+50\n"),
    ],
)
def test_the_34465a_answers(message: str, reply: bytes) -> None:
    desk = Desk("34465A")
    desk.ask("CONF:VOLT:DC 10")
    assert desk.ask(message) == reply
    assert desk.error() == NO_ERROR


@pytest.mark.parametrize(
    ("message", "code"),
    [
        ("FORM:DATA REAL,32", b"-224"),
        ("FORM:DATA", b"-109"),
        ("DATA:REM? 3", b"-222"),
        ("DATA:REM? 3,WAIT", b"-222"),
        ("DATA:REM?", b"-109"),
        ("ZERO:AUTO OFF", b"-113"),
        ("TRIG:COUN INF;:INIT;:FETC?", b"-214"),
    ],
)
def test_the_34465a_refuses(message: str, code: bytes) -> None:
    desk = Desk("34465A")
    desk.ask(message)
    assert (desk.error() or b"").split(b",")[0] == code
