"""The 34465A byte by byte: its timer, its memory, its binary blocks."""

import numpy as np
import pytest

from gyrotest.errors import InstrumentError, InstrumentProtocolError, InstrumentTimeoutError
from gyrotest.instruments.keysight34465a import (
    Keysight34465A,
    Keysight34465ASettings,
    readings_that_fit,
)
from gyrotest.instruments.transport.dialogue import Dialogue, Turn
from gyrotest.records.recording import SampleFlag
from tests.instruments.meter_turns import (
    ERRORS,
    IDN_34465A,
    NO_ERROR,
    StepClock,
    applied_34465a,
    opening,
)

READY = [*opening(IDN_34465A), *applied_34465a()]
CALM: Turn = (b"STAT:QUES?\n", b"+0\n")


def block(*values: float) -> bytes:
    content = np.array(values, dtype=">f8").tobytes()
    digits = str(len(content)).encode()
    return b"#" + str(len(digits)).encode() + digits + content + b"\n"


def begun(samples: int, *, init: bytes = NO_ERROR) -> list[Turn]:
    readings = 2 * samples
    return [
        (b"SAMP:COUN? MAX\n", b"+1.00000000E+09\n"),
        (b"SAMP:COUN %d\n" % readings, None),
        *ERRORS,
        (b"SAMP:COUN?\n", b"+%d\n" % readings),
        (b"INIT;:SYST:ERR?\n", init),
    ]


def meter(wire: Dialogue, clock: StepClock | None = None) -> Keysight34465A:
    return Keysight34465A(
        "TCPIP::meter::5025::SOCKET",
        Keysight34465ASettings(),
        clock=clock or StepClock(),
        line_frequency_hz=50.0,
        connect=wire.connect,
    )


def running(wire: Dialogue, clock: StepClock | None = None, *, count: int) -> Keysight34465A:
    source = meter(wire, clock)
    source.open()
    source.configure(1.0)
    source.start(0, count)
    return source


def test_the_timer_divides_the_interval_into_as_many_readings_as_fit() -> None:
    with Dialogue(READY) as wire:
        source = meter(wire)
        source.open()
        sampling = source.configure(1.0)
    assert (sampling.interval_s, sampling.aperture_s, sampling.readings) == (1.0, 0.2, 2)


def test_readings_come_in_blocks_every_few_seconds_and_are_cut_into_samples() -> None:
    clock = StepClock()
    turns: list[Turn] = [
        *begun(7),
        # Eleven readings: five whole samples and half of the sixth; 0x0A is in the bytes of 2.25.
        (b"R?\n", block(*[2.25, 2.75] * 5, 1.0)),
        CALM,
        (b"R?\n", block(3.0, 4.0, 6.0)),
        CALM,
        (b"DATA:POIN?\n", b"+0\n"),
        *ERRORS,
        (b"ABOR\n", None),
        (b"DISP ON\n", None),
    ]
    with Dialogue(READY + turns) as wire:
        source = running(wire, clock, count=7)
        first, second, end = source.fetch(), source.fetch(), source.fetch()
        source.close()
    assert first is not None
    assert second is not None
    assert end is None
    assert (first.first, first.values.tolist()) == (0, [[2.5]] * 5)
    assert (second.first, second.values.tolist()) == (5, [[2.0], [5.0]])
    assert second.time_s.tolist() == [5.0, 6.0]
    assert clock.waits == [1000.0, 1005.0, 1007.0]


def test_an_empty_memory_is_asked_again_and_then_is_a_fault() -> None:
    empty: list[Turn] = [(b"R?\n", b"#10\n"), CALM]
    with Dialogue(READY + begun(1) + empty * 8) as wire:
        source = running(wire, count=1)
        with pytest.raises(InstrumentTimeoutError, match="0 readings in its memory, expected 2"):
            source.fetch()


def test_overload_and_not_a_number_are_flagged() -> None:
    turns: list[Turn] = [
        *begun(3),
        (b"R?\n", block(9.9e37, 1.0, 9.91e37, 1.0, float("nan"), -9.9e37)),
        CALM,
    ]
    with Dialogue(READY + turns) as wire:
        found = running(wire, count=3).fetch()
    assert found is not None
    assert np.isnan(found.values).all()
    both = SampleFlag.OVERLOAD | SampleFlag.NOT_A_NUMBER
    assert found.flags.tolist() == [SampleFlag.OVERLOAD, SampleFlag.NOT_A_NUMBER, both]


def test_a_memory_that_overflowed_is_a_fault_and_its_readings_are_not_used() -> None:
    turns: list[Turn] = [*begun(9), (b"R?\n", block(1.0, 1.0)), (b"STAT:QUES?\n", b"+16384\n")]
    with Dialogue(READY + turns) as wire:
        source = running(wire, count=9)
        with pytest.raises(InstrumentProtocolError, match=r"\(34465A\): its memory overflowed"):
            source.fetch()


@pytest.mark.parametrize(
    ("reply", "message"),
    [
        (b"+1.00000000E+00\n", r"the reply to R\? begins '\+1\.00000000E\+00', expected a binary block"),
        (b"#0abc\n", "begins '#0abc'"),
        (b"#2x8abcdefgh\n", "begins '#2x8'"),
        (b"#13abc\n", "a block of 3 bytes, expected a multiple of 8"),
        (block(1.0, 1.0, 1.0, 1.0), "4 readings, expected at most 2"),
    ],
)
def test_a_block_that_is_none_is_refused(reply: bytes, message: str) -> None:
    wire = Dialogue([*READY, *begun(1), (b"R?\n", reply), CALM])
    source = running(wire, count=1)
    with pytest.raises(InstrumentProtocolError, match=message):
        source.fetch()


def test_a_block_that_breaks_off_is_a_time_out() -> None:
    wire = Dialogue([*READY, *begun(1), (b"R?\n", b"#216abc")])
    source = running(wire, count=1)
    with pytest.raises(InstrumentTimeoutError, match=r"no reply to R\? within 5 s"):
        source.fetch()


def test_a_refused_init_is_named() -> None:
    with Dialogue(READY + begun(1, init=b'-213,"Init ignored"\n')) as wire:
        source = meter(wire)
        source.open()
        source.configure(1.0)
        with pytest.raises(InstrumentProtocolError, match='INIT is refused: -213,"Init ignored"'):
            source.start(0, 1)


def test_more_readings_than_the_model_takes_are_refused() -> None:
    with Dialogue([*READY, (b"SAMP:COUN? MAX\n", b"+5.00000000E+04\n")]) as wire:
        source = meter(wire)
        source.open()
        source.configure(1.0)
        with pytest.raises(InstrumentError, match="72000 readings in one run, at most 50000"):
            source.start(0, 36_000)


def test_an_interval_below_the_meters_shortest_is_refused() -> None:
    turns = applied_34465a()[:17]
    with Dialogue([*opening(IDN_34465A), *turns]) as wire:
        source = meter(wire)
        source.open()
        with pytest.raises(InstrumentError, match=r"0\.3 s cannot be reached .* shortest is 0\.4 s"):
            source.configure(0.3)


def test_after_recovery_the_grid_goes_on() -> None:
    clock = StepClock()
    turns: list[Turn] = [
        *begun(20),
        (b"R?\n", TimeoutError()),
        (b"*IDN?\n", IDN_34465A),
        *ERRORS,
        (b"*CLS;*RST\n", None),
        *applied_34465a(),
        *begun(13),
        (b"R?\n", block(*[1.0] * 10)),
        CALM,
    ]
    with Dialogue(READY + turns) as wire:
        source = running(wire, clock, count=20)
        with pytest.raises(InstrumentTimeoutError):
            source.fetch()
        clock.time_s += 1.3
        first = source.recover()
        source.start(first, 20)
        found = source.fetch()
    assert first == 7
    assert found is not None
    assert (found.first, found.time_s.tolist()) == (7, [7.0, 8.0, 9.0, 10.0, 11.0])


@pytest.mark.parametrize(
    ("interval_s", "shortest_s", "count"),
    [
        (1.0, 0.40002, 2),
        (1.0, 0.04002, 20),  # 24 fit, but a 23rd or 24th part of a second is no whole number of steps
        (1.0, 1.0, 1),
        (0.3, 0.4, 0),
        (0.999983, 0.01, 99),  # nothing near divides it: as many as fit
    ],
)
def test_readings_fit_without_wasting_the_interval(
    interval_s: float, shortest_s: float, count: int
) -> None:
    assert readings_that_fit(interval_s, shortest_s) == count
