"""The scanner byte by byte: how channels are set up in either generation, and what its memory may hold."""

from typing import Any

import pytest

from gyrotest.errors import InstrumentError, InstrumentProtocolError, InstrumentTimeoutError
from gyrotest.instruments.keysight34970a import Keysight34970A
from gyrotest.instruments.scanner_settings import BesideChannel, Function, Keysight34970ASettings
from gyrotest.instruments.transport.dialogue import Dialogue, Turn
from gyrotest.units import Quantity
from tests.instruments.meter_turns import ERRORS, NO_ERROR, StepClock, opening

OLD = b"HEWLETT-PACKARD,34970A,0,13-2-2\n"
NEW = b"Keysight Technologies,DAQ970A,MY58001234,A.03.01-01.00-03.00-0001-01\n"
CALM: Turn = (b"STAT:QUES?\n", b"+0\n")


def said(*commands: str) -> list[Turn]:
    return [(f"{one}\n".encode(), None) for one in commands]


def asked(*pairs: tuple[str, str]) -> list[Turn]:
    return [(f"{query}\n".encode(), f"{reply}\n".encode()) for query, reply in pairs]


def block(text: str) -> bytes:
    digits = str(len(text))
    return f"#{len(digits)}{digits}{text}\n".encode()


def voltage(channel: str, *, newer: bool = False) -> tuple[list[str], list[tuple[str, str]]]:
    """Commands, and queries with their answers, of a channel at 10 V, 1 power-line cycle, autozero."""
    zero, impedance = (
        ("VOLT:DC:ZERO:AUTO", "VOLT:DC:IMP:AUTO") if newer else ("ZERO:AUTO", "INP:IMP:AUTO")
    )
    where = f"(@{channel})"
    commands = [
        f"CONF:VOLT:DC 10,{where}",
        f"VOLT:DC:NPLC 1,{where}",
        f"{zero} ON,{where}",
        f"{impedance} ON,{where}",
    ]
    queries = [
        (f"VOLT:DC:RANG? {where}", "+1.00000000E+01"),
        (f"VOLT:DC:NPLC? {where}", "+1.00000000E+00"),
        (f"{zero}? {where}", "1"),
        (f"{impedance}? {where}", "1"),
    ]
    return commands, queries


def thermocouple(channel: str) -> tuple[list[str], list[tuple[str, str]]]:
    where = f"(@{channel})"
    commands = [f"CONF:TEMP TC,T,{where}", f"UNIT:TEMP C,{where}", f"TEMP:NPLC 1,{where}"]
    queries = [
        (f"TEMP:TRAN:TYPE? {where}", "TC"),
        (f"UNIT:TEMP? {where}", "C"),
        (f"TEMP:NPLC? {where}", "+1.00000000E+00"),
    ]
    return commands, queries


def channels(*parts: tuple[list[str], list[tuple[str, str]]]) -> list[Turn]:
    commands = [command for part in parts for command in part[0]]
    queries = [query for part in parts for query in part[1]]
    return [*said(*commands), *ERRORS, *asked(*queries)]


def scan_list(listed: str, *, found: str | None = None) -> list[Turn]:
    names = (
        ("TIME", "ON", "1"),
        ("TIME:TYPE", "REL", "REL"),
        ("CHAN", "ON", "1"),
        ("UNIT", "OFF", "0"),
        ("ALAR", "OFF", "0"),
    )
    return [
        *said(f"ROUT:SCAN {listed}", *(f"FORM:READ:{name} {value}" for name, value, _ in names)),
        *ERRORS,
        *asked(*((f"FORM:READ:{name}?", reply) for name, _, reply in names)),
        (b"ROUT:SCAN?\n", block(found or listed)),
    ]


def trial(*readings: str) -> list[Turn]:
    return [
        *said("TRIG:SOUR IMM", "TRIG:COUN 2"),
        *ERRORS,
        *asked(("TRIG:SOUR?", "IMM"), ("TRIG:COUN?", "+2.00000000E+00")),
        (b"INIT;:SYST:ERR?\n", NO_ERROR),
        *((b"R?\n", block(one)) for one in readings),
    ]


TIMER: list[Turn] = [
    *said("TRIG:SOUR TIM", "TRIG:TIM 1.000", "TRIG:COUN INF"),
    *ERRORS,
    *asked(("TRIG:SOUR?", "TIM"), ("TRIG:TIM?", "+1.00000000E+00")),
]
SWEEPS = "+1.0E+00,00000000.017,101,+2.5E+01,00000000.070,110,+1.0E+00,00000000.123,101,+2.5E+01,00000000.176,110"
READY: list[Turn] = [
    *opening(OLD),
    *channels(voltage("101"), thermocouple("110")),
    *scan_list("(@101,110)"),
    *trial(SWEEPS),
    *TIMER,
]
BEGUN: list[Turn] = [*said("ABOR"), (b"INIT;:SYST:ERR?\n", NO_ERROR)]


def scanner(wire: Dialogue, clock: StepClock | None = None, **settings: Any) -> Keysight34970A:
    beside = {"110": BesideChannel(function=Function.THERMOCOUPLE, type="t")}
    return Keysight34970A(
        "TCPIP::scanner::5025::SOCKET",
        Keysight34970ASettings(beside=beside, **settings),
        clock=clock or StepClock(),
        line_frequency_hz=50.0,
        connect=wire.connect,
    )


def begun(wire: Dialogue, clock: StepClock | None = None, *, samples: int) -> Keysight34970A:
    source = scanner(wire, clock)
    source.open()
    source.select(("101",), ("110",))
    source.configure(1.0)
    source.start(0, samples)
    return source


def sweep(number: int, *, output: str = "+1.5E+00", beside: str = "+2.5E+01") -> str:
    return f"{output},{number + 0.017:012.3f},101,{beside},{number + 0.07:012.3f},110"


def test_the_channels_are_set_up_tried_out_and_paced_by_the_timer() -> None:
    with Dialogue(READY) as wire:
        source = scanner(wire)
        source.open()
        source.select(("101",), ("110", "110"))
        sampling = source.configure(1.0)
    assert (sampling.interval_s, sampling.aperture_s) == (1.0, 0.02)
    assert sampling.columns == ("101", "110")
    assert sampling.offsets_s == pytest.approx((0.0, 0.053))
    assert sampling.range == 10.0


def test_the_newer_generation_has_other_words_for_autozero_and_input_resistance() -> None:
    turns = [
        *opening(NEW),
        *channels(voltage("203", newer=True)),
        *scan_list("(@203)"),
        *trial("", "+1.0E+00,00000000.017,203,+1.0E+00,00000000.070,203"),
        *TIMER,
    ]
    with Dialogue(turns) as wire:
        source = scanner(wire)
        source.open()
        source.select(("203",), ())
        assert source.configure(1.0).offsets_s == (0.0,)


def test_sweeps_come_in_blocks_of_which_one_may_end_in_the_middle_of_a_sweep() -> None:
    clock = StepClock()
    whole = ",".join(sweep(number) for number in range(5))
    half, rest = sweep(5).rsplit(",", 3)[0], ",".join(sweep(5).rsplit(",", 3)[1:])
    turns: list[Turn] = [
        *BEGUN,
        (b"R?\n", block(f"{whole},{half}")),
        CALM,
        (b"R?\n", b"#10\n"),
        CALM,
        (b"R?\n", block(f"{rest},{sweep(6)}")),
        CALM,
        *said("ABOR"),
        *ERRORS,
        *said("ABOR"),
    ]
    with Dialogue(READY + turns) as wire:
        source = begun(wire, clock, samples=7)
        first, second, end = source.fetch(), source.fetch(), source.fetch()
        source.close()
    assert first is not None
    assert second is not None
    assert end is None
    assert (first.first, first.values.tolist()) == (0, [[1.5, 25.0]] * 5)
    assert (second.first, second.values.tolist()) == (5, [[1.5, 25.0]] * 2)
    assert second.time_s == pytest.approx([5.017, 6.017])


def test_time_and_channel_may_come_in_either_order() -> None:
    turned = "+1.5E+00,101,00000000.017,+2.5E+01,110,00000000.070"
    with Dialogue([*READY, *BEGUN, (b"R?\n", block(turned)), CALM]) as wire:
        found = begun(wire, samples=1).fetch()
    assert found is not None
    assert found.values.tolist() == [[1.5, 25.0]]
    assert found.time_s == pytest.approx([0.017])


def test_sweeps_before_a_broken_probe_go_out_first() -> None:
    content = ",".join([sweep(0), sweep(1), sweep(2, beside="+9.90000000E+37")])
    with Dialogue([*READY, *BEGUN, (b"R?\n", block(content)), CALM]) as wire:
        source = begun(wire, samples=3)
        found = source.fetch()
        assert found is not None
        assert found.values.tolist() == [[1.5, 25.0]] * 2
        with pytest.raises(
            InstrumentError, match=r"\(34970A\): overload on channel 110 .thermocouple.; is the probe"
        ):
            source.fetch()


@pytest.mark.parametrize(
    ("content", "message"),
    [
        ("junk", "its memory holds 'junk', expected a reading, its time and its channel"),
        ("+1.5E+00,00000000.017", "expected a reading, its time and its channel"),
        ("+1.5E+00,00000000.017,x01,+2.5E+01,00000000.070,110", "something else than numbers"),
        (
            "+1.5E+00,00000000.017,102,+2.5E+01,00000000.070,110",
            "a sweep has the channels 102, 110, expected 101, 110",
        ),
        (f"{sweep(0)},{sweep(2)}", None),
    ],
)
def test_a_memory_that_holds_something_else_is_refused(content: str, message: str | None) -> None:
    with Dialogue([*READY, *BEGUN, (b"R?\n", block(content)), CALM]) as wire:
        source = begun(wire, samples=4)
        if message is None:
            source.fetch()
            message = "a sample was taken 1 s from when it was due; sweeps are missing"
        with pytest.raises(InstrumentProtocolError, match=message):
            source.fetch()


def test_a_scan_list_that_was_not_taken_is_refused() -> None:
    turns = [*opening(OLD), *channels(voltage("101")), *scan_list("(@101)", found="(@101,102)")]
    with Dialogue(turns) as wire:
        source = scanner(wire)
        source.open()
        source.select(("101",), ())
        with pytest.raises(
            InstrumentProtocolError, match=r"the scan list is \(@101,102\), expected \(@101\)"
        ):
            source.configure(1.0)


def test_a_timer_that_was_not_taken_is_refused() -> None:
    turns = [*READY[:-1], *asked(("TRIG:TIM?", "+2.00000000E+00"))]
    with Dialogue(turns) as wire:
        source = scanner(wire)
        source.open()
        source.select(("101",), ("110",))
        with pytest.raises(InstrumentProtocolError, match=r"TRIG:TIM\? gives 2 s, expected 1 s"):
            source.configure(1.0)


def test_a_trial_without_sweeps_and_a_scan_that_has_stopped_are_told() -> None:
    empty: list[Turn] = [(b"R?\n", b"#10\n")]
    start = READY[: -len(TIMER) - 1]
    wire = Dialogue([*start, *empty * 200])
    source = scanner(wire)
    source.open()
    source.select(("101",), ("110",))
    with pytest.raises(InstrumentTimeoutError, match="0 of 2 sweeps of a trial came"):
        source.configure(1.0)
    wire = Dialogue([*READY, *BEGUN, *[*empty, CALM] * 20])
    source = begun(wire, samples=3)
    with pytest.raises(
        InstrumentTimeoutError, match=r"no whole sweep in its memory, expected since 3\."
    ):
        source.fetch()


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        ({"function": Function.VOLTAGE, "type": "K"}, "a voltage has no type"),
        (
            {"function": Function.THERMOCOUPLE, "type": "X"},
            "type X is none of a thermocouple's: write one of K, B",
        ),
        ({"function": Function.RTD, "unit": "K"}, "a rtd gives °C; leave 'range' and 'unit' out"),
        ({"function": Function.VOLTAGE, "per_volt": 0.0}, "per_volt 0 is no scale"),
        ({"function": Function.VOLTAGE, "nplc": 3.0}, "nplc 3 is none of the 34970A's"),
        (
            {"function": Function.VOLTAGE, "range": Quantity(5.0, "V")},
            "range 5 V is none of the scanner's",
        ),
    ],
)
def test_the_settings_of_what_is_beside_are_checked(settings: dict[str, Any], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        BesideChannel(**settings)


@pytest.mark.parametrize("channel", ["temperature", "1", "100", "4101"])
def test_what_is_beside_is_named_by_its_channel(channel: str) -> None:
    beside = {channel: BesideChannel(function=Function.RTD)}
    with pytest.raises(ValueError, match="is no channel; write slot and channel"):
        Keysight34970ASettings(beside=beside)
