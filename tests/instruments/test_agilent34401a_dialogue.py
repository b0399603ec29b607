"""The 34401A byte by byte: what is sent, and what is made of each reply."""

import numpy as np
import pytest

from gyrotest.errors import (
    InstrumentError,
    InstrumentIdentityError,
    InstrumentProtocolError,
    InstrumentTimeoutError,
)
from gyrotest.instruments.agilent34401a import Agilent34401A, Agilent34401ASettings
from gyrotest.instruments.transport.dialogue import Dialogue, Turn
from gyrotest.records.recording import SampleFlag
from gyrotest.records.station import Accuracy
from gyrotest.units import Quantity
from tests.instruments.meter_turns import (
    ERRORS,
    IDN_34401A,
    NO_ERROR,
    StepClock,
    applied_34401a,
    opening,
)

ADDRESS = "GPIB0::22::INSTR"
READY = [*opening(IDN_34401A), *applied_34401a(count=2)]
CLOSED: list[Turn] = [(b"DISP ON\n", None)]


def meter(wire: Dialogue, clock: StepClock | None = None, **given: object) -> Agilent34401A:
    arguments = {"line_frequency_hz": 50.0, "settings": Agilent34401ASettings()} | given
    return Agilent34401A(
        ADDRESS,
        arguments.pop("settings"),
        clock=clock or StepClock(),
        connect=wire.connect,
        **arguments,  # type: ignore[arg-type]
    )


def running(wire: Dialogue, clock: StepClock | None = None, *, count: int = 3) -> Agilent34401A:
    source = meter(wire, clock)
    source.open()
    source.configure(1.0)
    source.start(0, count)
    return source


def test_identity_is_asked_before_anything_is_changed() -> None:
    with Dialogue(opening(IDN_34401A)) as wire:
        identity = meter(wire).open()
    assert (identity.manufacturer, identity.model, identity.serial_number) == (
        "HEWLETT-PACKARD",
        "34401A",
        "0",
    )


def test_two_readings_of_10_cycles_with_autozero_fit_into_a_second_at_50_hz() -> None:
    noise = Accuracy(
        of_reading=Quantity(35.0, "ppm"), of_range=Quantity(5.0, "ppm"), noise=Quantity(3e-6, "V")
    )
    with Dialogue(READY) as wire:
        source = meter(wire, accuracy=noise)
        source.open()
        sampling = source.configure(1.0)
    assert (sampling.interval_s, sampling.aperture_s, sampling.readings) == (1.0, 0.2, 2)
    assert sampling.duty == pytest.approx(0.4)
    assert sampling.noise == pytest.approx(3e-6 / np.sqrt(2))
    assert sampling.range == 10.0


def test_each_sample_is_the_mean_of_one_read_at_its_deadline() -> None:
    clock = StepClock()
    turns: list[Turn] = [
        (b"READ?\n", b"+2.50000000E+00,+2.50000200E+00\n"),
        (b"READ?\n", b"-1.00000000E-03,+1.00000000E-03\r\n"),
        *ERRORS,
        *CLOSED,
    ]
    with Dialogue(READY + turns) as wire:
        source = running(wire, clock, count=2)
        first, second, end = source.fetch(), source.fetch(), source.fetch()
        source.close()
    assert first is not None
    assert second is not None
    assert end is None
    assert first.values.tolist() == [[pytest.approx(2.500001)]]
    assert second.values.tolist() == [[pytest.approx(0.0, abs=1e-12)]]
    assert (second.first, second.time_s.tolist(), second.flags.tolist()) == (1, [1.0], [0])
    assert clock.waits == [1000.0, 1001.0]


def test_deadlines_do_not_drift_when_a_sample_is_late() -> None:
    clock = StepClock()
    read: list[Turn] = [(b"READ?\n", b"+1.00000000E+00,+1.00000000E+00\n")] * 3
    with Dialogue(READY + read) as wire:
        source = running(wire, clock)
        source.fetch()
        clock.late_s = 0.3
        late = source.fetch()
        punctual = source.fetch()
    assert late is not None
    assert punctual is not None
    assert late.time_s.tolist() == [pytest.approx(1.3)]
    assert punctual.time_s.tolist() == [pytest.approx(2.0)]


def test_samples_missed_by_an_interval_or_more_are_a_gap() -> None:
    clock = StepClock()
    read: list[Turn] = [(b"READ?\n", b"+1.00000000E+00,+1.00000000E+00\n")] * 2
    with Dialogue(READY + read) as wire:
        source = running(wire, clock, count=9)
        source.fetch()
        clock.time_s += 3.5
        block = source.fetch()
    assert block is not None
    assert (block.first, block.time_s.tolist()) == (4, [pytest.approx(4.0)])


def test_short_intervals_come_in_batches_of_a_second() -> None:
    turns: list[Turn] = [
        *opening(IDN_34401A),
        *applied_34401a(count=15, nplc="0.02"),
        *[(b"READ?\n", b",".join([b"+1.00000000E+00"] * 15) + b"\n")] * 25,
        *ERRORS,
    ]
    with Dialogue(turns) as wire:
        source = meter(wire, settings=Agilent34401ASettings(nplc=0.02))
        source.open()
        source.configure(0.05)
        source.start(0, 25)
        blocks = [source.fetch(), source.fetch(), source.fetch()]
    assert [None if block is None else len(block.flags) for block in blocks] == [20, 5, None]
    assert blocks[1] is not None
    assert blocks[1].time_s.tolist() == pytest.approx([1.0, 1.05, 1.1, 1.15, 1.2])


@pytest.mark.parametrize(
    ("reply", "flag"),
    [
        (b"+2.50000000E+00,+9.90000000E+37\n", SampleFlag.OVERLOAD),
        (b"-9.90000000E+37,+9.90000000E+37\n", SampleFlag.OVERLOAD),
        (b"+9.91000000E+37,+2.50000000E+00\n", SampleFlag.NOT_A_NUMBER),
        (b"+9.91000000E+37,-9.90000000E+37\n", SampleFlag.OVERLOAD | SampleFlag.NOT_A_NUMBER),
    ],
)
def test_overload_and_not_a_number_are_flagged_and_have_no_value(reply: bytes, flag: SampleFlag) -> None:
    with Dialogue([*READY, (b"READ?\n", reply)]) as wire:
        block = running(wire).fetch()
    assert block is not None
    assert np.isnan(block.values).all()
    assert block.flags.tolist() == [int(flag)]


@pytest.mark.parametrize(
    ("reply", "found"),
    [
        (b"+2.50000000E+00\n", r"1 readings in one reply, expected 2"),
        (b"+2.5E+00,+2.5E+00,+2.5E+00\n", r"3 readings in one reply, expected 2"),
        (b"#!?garbage\n", r"begins '#!\?garbage', expected 2 reading"),
        (b"+2.50000000E+00,+2.500000\n", r"begins '\+2\.50000000E\+00,\+2\.500000'"),
        (b"1_0.0E+00,+2.5E+00\n", r"begins '1_0"),
        (b"\n", "begins ''"),
    ],
)
def test_a_reply_that_is_not_two_readings_is_refused(reply: bytes, found: str) -> None:
    with Dialogue([*READY, (b"READ?\n", reply)]) as wire:
        source = running(wire)
        with pytest.raises(InstrumentProtocolError, match=rf"^GPIB0::22::INSTR \(34401A\): .*{found}"):
            source.fetch()


def test_no_reply_names_the_query_and_the_time() -> None:
    with Dialogue([*READY, (b"READ?\n", TimeoutError())]) as wire:
        source = running(wire)
        with pytest.raises(InstrumentTimeoutError, match=r"no reply to READ\? within 2\.6 s; .*IMM"):
            source.fetch()


def test_samples_read_before_a_fault_are_given_out_first() -> None:
    quick = [*opening(IDN_34401A), *applied_34401a(count=1)]
    turns: list[Turn] = [
        (b"READ?\n", b"+1.00000000E+00\n"),
        (b"READ?\n", ConnectionResetError("gone")),
    ]
    with Dialogue(quick + turns) as wire:
        source = meter(wire)
        source.open()
        source.configure(0.5)
        source.start(0, 9)
        block = source.fetch()
        with pytest.raises(InstrumentError, match="connection lost at READ"):
            source.fetch()
    assert block is not None
    assert block.values.tolist() == [[1.0]]


def test_a_reply_that_nobody_asked_for_is_refused_before_the_next_query() -> None:
    turn: Turn = (b"READ?\n", b"+1.00000000E+00,+1.00000000E+00\n+5.00000000E+00\n")
    with Dialogue([*READY, turn]) as wire:
        source = running(wire)
        source.fetch()
        with pytest.raises(InstrumentProtocolError, match=r"'\+5\.00000000E\+00' arrived without"):
            source.fetch()
        wire.clear()


def test_another_instrument_is_named_and_left_alone() -> None:
    wire = Dialogue([(b"*IDN?\n", b"Agilent Technologies,E3631A,0,2.1\n")])
    expected = r"found Agilent Technologies E3631A .*expected an HP / Agilent 34401A"
    with wire, pytest.raises(InstrumentIdentityError, match=expected):
        meter(wire).open()
    assert wire.closed == 1


def test_another_serial_number_than_the_stations_is_refused() -> None:
    wire = Dialogue([(b"*IDN?\n", b"HEWLETT-PACKARD,34401A,US111,11-5-2\n")])
    with wire, pytest.raises(InstrumentIdentityError, match="serial number US111, expected US222"):
        meter(wire, serial_number="US222").open()


def test_what_is_no_identity_is_refused() -> None:
    replies = b"hello\n" * 9
    with Dialogue([(b"*IDN?\n", replies)]) as wire:
        with pytest.raises(InstrumentProtocolError, match=r"\*IDN\? gives 'hello', expected the four"):
            meter(wire).open()
        wire.clear()


def test_an_entry_in_the_error_queue_after_configuration_is_named() -> None:
    written = applied_34401a(count=2)[:9]
    queue: list[Turn] = [(b"SYST:ERR?\n", b'-113,"Undefined header"\n'), (b"SYST:ERR?\n", NO_ERROR)]
    with Dialogue([*opening(IDN_34401A), *written, *queue]) as wire:
        source = meter(wire)
        source.open()
        with pytest.raises(InstrumentProtocolError, match='reports -113,"Undefined header"'):
            source.configure(1.0)


def test_an_entry_in_the_error_queue_at_the_end_is_named() -> None:
    turns: list[Turn] = [
        (b"READ?\n", b"+1.00000000E+00,+1.00000000E+00\n"),
        (b"SYST:ERR?\n", b'+521,"Input buffer overflow"\n'),
        (b"SYST:ERR?\n", NO_ERROR),
    ]
    with Dialogue(READY + turns) as wire:
        source = running(wire, count=1)
        source.fetch()
        with pytest.raises(InstrumentProtocolError, match="Input buffer overflow"):
            source.fetch()


@pytest.mark.parametrize(
    ("query", "reply", "message"),
    [
        ("NPLC", b"+1.000000E+00\n", r"VOLT:DC:NPLC\? gives \+1\.000000E\+00 after 'VOLT:DC:NPLC 10'"),
        ("ZERO", b"0\n", r"ZERO:AUTO\? gives 0 after 'ZERO:AUTO ON', expected 1"),
        ("SOUR", b"EXT\n", r"TRIG:SOUR\? gives EXT after 'TRIG:SOUR IMM', expected IMM"),
        ("SAMP", b"nonsense\n", r"SAMP:COUN\? gives nonsense"),
    ],
)
def test_a_setting_that_reads_back_otherwise_is_refused(query: str, reply: bytes, message: str) -> None:
    turns = [*opening(IDN_34401A), *applied_34401a(count=2, **{query: reply})]
    with Dialogue(turns) as wire:
        source = meter(wire)
        source.open()
        with pytest.raises(InstrumentProtocolError, match=message):
            source.configure(1.0)


def test_an_interval_that_is_too_short_names_the_shortest() -> None:
    with Dialogue(opening(IDN_34401A)) as wire:
        source = meter(wire)
        source.open()
        with pytest.raises(InstrumentError, match=r"an interval of 0\.4 s .* the shortest is 0\.42 s"):
            source.configure(0.4)


def test_without_line_frequency_nothing_is_configured() -> None:
    with Dialogue(opening(IDN_34401A)) as wire:
        source = meter(wire, line_frequency_hz=None)
        source.open()
        with pytest.raises(InstrumentError, match="set line_frequency in the station"):
            source.configure(1.0)


def test_over_a_serial_line_the_transfer_takes_its_share_of_the_interval() -> None:
    turns: list[Turn] = [
        (b"*IDN?\n", IDN_34401A),
        (b"SYST:REM\n", None),
        (b"*CLS;*RST\n", None),
        # 0.98 s hold 49 readings of 20 ms, but 17 bytes each at 9600 baud take 17.7 ms more.
        *applied_34401a(count=25, nplc="1", autozero=False),
    ]
    with Dialogue(turns, seconds_per_byte=10 / 9600, remote_by_command=True) as wire:
        source = meter(wire, settings=Agilent34401ASettings(nplc=1.0, autozero=False))
        source.open()
        assert source.configure(1.0).readings == 25


def test_without_autozero_the_zero_is_taken_once_before_the_start() -> None:
    turns: list[Turn] = [
        *opening(IDN_34401A),
        *applied_34401a(count=4, autozero=False),
        (b"ZERO:AUTO ONCE\n", None),
    ]
    with Dialogue(turns) as wire:
        source = meter(wire, settings=Agilent34401ASettings(autozero=False))
        source.open()
        source.configure(1.0)
        source.start(0, 1)


def test_a_slow_sample_behind_an_adapter_goes_through_the_memory() -> None:
    clock = StepClock()
    turns: list[Turn] = [
        *opening(IDN_34401A),
        *applied_34401a(count=2, nplc="100"),
        (b"INIT;:SYST:ERR?\n", NO_ERROR),
        (b"FETC?\n", b"+1.00000000E+00,+3.00000000E+00\n"),
    ]
    with Dialogue(turns, longest_wait_s=3.0) as wire:
        source = meter(wire, clock, settings=Agilent34401ASettings(nplc=100.0))
        source.open()
        source.configure(10.0)
        source.start(0, 1)
        block = source.fetch()
    assert block is not None
    assert block.values.tolist() == [[2.0]]
    assert clock.waits[-1] == pytest.approx(1000.0 + 2 * 4.0)


def test_recovery_drops_late_answers_and_sets_the_meter_up_again() -> None:
    clock = StepClock()
    turns: list[Turn] = [
        (b"READ?\n", TimeoutError()),
        (b"*IDN?\n", b"+2.5E+00,+2.5E+00\n" + IDN_34401A),
        (b"SYST:ERR?\n", b'-410,"Query INTERRUPTED"\n'),
        (b"SYST:ERR?\n", NO_ERROR),
        (b"*CLS;*RST\n", None),
        *applied_34401a(count=2),
        (b"READ?\n", b"+1.00000000E+00,+1.00000000E+00\n"),
    ]
    with Dialogue(READY + turns) as wire:
        source = running(wire, clock, count=20)
        with pytest.raises(InstrumentTimeoutError):
            source.fetch()
        clock.time_s += 6.2
        first = source.recover()
        source.start(first, 20)
        block = source.fetch()
    assert (first, wire.cleared, wire.opened) == (7, 1, 1)
    assert block is not None
    assert (block.first, block.time_s.tolist()) == (7, [pytest.approx(7.0)])


def test_recovery_connects_anew_where_the_connection_is_gone() -> None:
    turns: list[Turn] = [
        (b"READ?\n", ConnectionResetError("gone")),
        (b"*IDN?\n", ConnectionResetError("gone")),
        *opening(IDN_34401A),
        *applied_34401a(count=2),
    ]
    with Dialogue(READY + turns) as wire:
        source = running(wire)
        with pytest.raises(InstrumentError, match="connection lost"):
            source.fetch()
        source.recover()
    assert (wire.opened, wire.closed) == (2, 1)


def test_recovery_refuses_another_meter_at_the_same_address() -> None:
    turns: list[Turn] = [(b"*IDN?\n", b"HEWLETT-PACKARD,34401A,OTHER,11-5-2\n")]
    with Dialogue(READY + turns) as wire:
        source = running(wire)
        with pytest.raises(InstrumentIdentityError, match="serial number OTHER, expected 0"):
            source.recover()


def test_closing_is_idempotent_and_never_raises() -> None:
    with Dialogue([*opening(IDN_34401A), (b"DISP ON\n", None)]) as wire:
        source = meter(wire)
        source.close()
        source.open()
        source.close()
        source.close()
    assert wire.closed == 1
    with pytest.raises(InstrumentError, match="not open"):
        source.configure(1.0)


def test_over_a_serial_line_the_front_panel_is_given_back() -> None:
    turns: list[Turn] = [
        (b"*IDN?\n", IDN_34401A),
        (b"SYST:REM\n", None),
        (b"*CLS;*RST\n", None),
        (b"DISP ON\n", None),
        (b"SYST:LOC\n", None),
    ]
    with Dialogue(turns, remote_by_command=True) as wire:
        source = meter(wire)
        source.open()
        source.close()


@pytest.mark.parametrize("nplc", [0.5, 2.0, 0.0, -1.0])
def test_an_integration_time_that_the_meter_lacks_is_refused(nplc: float) -> None:
    with pytest.raises(ValueError, match=r"none of the 34401A's: write one of 0\.02, 0\.2, 1, 10, 100"):
        Agilent34401ASettings(nplc=nplc)


def test_a_range_that_the_meter_lacks_is_refused() -> None:
    with pytest.raises(ValueError, match=r"range 5 V is none of the meter's: write one of 0\.1 V, 1 V"):
        Agilent34401ASettings(range=Quantity(5.0, "V"))


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"stop_bits": 3}, "stop_bits 3 is none of 1 and 2"),
        ({"data_bits": 5}, "data_bits 5 is none of 7 and 8"),
        ({"baud_rate": 0}, "baud_rate 0 is not more than zero"),
    ],
)
def test_a_serial_setting_that_makes_no_sense_is_refused(given: dict[str, int], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        Agilent34401ASettings(**given)  # type: ignore[arg-type]
