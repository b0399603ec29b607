"""The generator of a vibration table byte by byte: what is set up, read back and refused before it is sent."""

from collections.abc import Callable
from typing import Any

import pytest

from gyrotest.errors import InstrumentError, InstrumentIdentityError, InstrumentProtocolError
from gyrotest.instruments.keysight33500b import Keysight33500B
from gyrotest.instruments.transport.dialogue import Dialogue, Turn
from gyrotest.ports import VibrationDrive
from gyrotest.units import Quantity
from tests.instruments.exciter_bench import settings
from tests.instruments.meter_turns import ERRORS, StepClock, opening

IDN = b"Agilent Technologies,33522B,MY57001234,4.00-1.19-2.00-58-00\n"
# A GPIB address: no process is started that would watch over it.
RESOURCE = "GPIB0::10::INSTR"


def generator(wire: Dialogue, **changed: Any) -> VibrationDrive:
    return Keysight33500B(RESOURCE, settings(**changed), clock=StepClock(), connect=wire.connect)


def said(*commands: str) -> list[Turn]:
    return [(f"{one}\n".encode(), None) for one in commands]


def asked(*pairs: tuple[str, str]) -> list[Turn]:
    return [(f"{header}?\n".encode(), f"{reply}\n".encode()) for header, reply in pairs]


def set_up(
    function: str, frequency: tuple[str, str], level: str, *, load: str = "INF", channel: int = 1
) -> list[Turn]:
    """The output set up and switched on, all of it read back."""
    out, source = f"OUTP{channel}", f"SOUR{channel}"
    header, value = frequency
    return [
        *said(
            f"{out} OFF",
            f"{source}:FREQ:MODE CW",
            f"{out}:LOAD {load}",
            f"{source}:FUNC {function}",
            f"{source}:VOLT:UNIT VRMS",
            f"{source}:{header} {value}",
            f"{source}:VOLT {level}",
            f"{source}:VOLT:OFFS 0",
        ),
        *ERRORS,
        *asked(
            (out, "0"),
            (f"{source}:FREQ:MODE", "CW"),
            (f"{out}:LOAD", "+9.9000000000000000E+37" if load == "INF" else load),
            (f"{source}:FUNC", function),
            (f"{source}:VOLT:UNIT", "VRMS"),
            (f"{source}:{header}", f"{float(value):+.15E}"),
            (f"{source}:VOLT:OFFS", "+0.000000000000000E+00"),
            # Rounded by the generator to four digits of peak to peak.
            (f"{source}:VOLT", f"{float(level) * 1.0004:+.15E}"),
        ),
        *said(f"{out} ON"),
        *ERRORS,
        *asked((out, "1")),
    ]


OPENED: list[Turn] = [*opening(IDN), *asked(("OUTP1", "0"))]
OFF: list[Turn] = [*said("OUTP1 OFF"), *asked(("OUTP1", "0"))]
# 10 °/s by 20 °/s/V, and the share that noise from 0 to 100 Hz has from 5 Hz on.
RANDOM = set_up("NOIS", ("FUNC:NOIS:BAND", "100"), "0.512989")
SINE = set_up("SIN", ("FREQ", "12.5"), "0.5")


def test_noise_has_the_level_that_its_band_gets_and_is_switched_off_at_the_end() -> None:
    with Dialogue([*OPENED, *RANDOM, *OFF]) as wire:
        drive = generator(wire)
        assert drive.open().serial_number == "MY57001234"
        drive.random(rms_dps=10.0, low_hz=5.0, high_hz=100.0)
        drive.close()
        drive.close()


def test_a_sine_is_set_by_its_rms_and_checked_while_it_lasts() -> None:
    check = asked(("OUTP1", "1"), ("SOUR1:FUNC", "SIN"), ("SOUR1:VOLT", "+5.0E-01"))
    with Dialogue([*OPENED, *SINE, *check, *OFF]) as wire:
        drive = generator(wire)
        drive.open()
        drive.sine(rms_dps=10.0, frequency_hz=12.5)
        drive.check()
        drive.stop()


SWEEP: list[Turn] = [
    *said(
        "SOUR1:FREQ:STAR 12.5",
        "SOUR1:FREQ:STOP 100",
        "SOUR1:SWE:SPAC LOG",
        "SOUR1:SWE:TIME 60",
        "TRIG1:SOUR BUS",
        "SOUR1:FREQ:MODE SWE",
    ),
    *ERRORS,
    *asked(
        ("SOUR1:FREQ:STAR", "+1.25E+01"),
        ("SOUR1:FREQ:STOP", "+1.0E+02"),
        ("SOUR1:SWE:SPAC", "LOG"),
        ("SOUR1:SWE:TIME", "+6.0E+01"),
        ("TRIG1:SOUR", "BUS"),
        ("SOUR1:FREQ:MODE", "SWE"),
    ),
    *said("*TRG"),
    *ERRORS,
]


def test_a_sweep_goes_on_from_the_sine_that_is_there_already() -> None:
    with Dialogue([*OPENED, *SINE, *SWEEP, *OFF]) as wire:
        drive = generator(wire)
        drive.open()
        drive.sine(rms_dps=10.0, frequency_hz=12.5)
        drive.sweep(rms_dps=10.0, low_hz=12.5, high_hz=100.0, duration_s=60.0)
        drive.close()


def test_a_sweep_after_anything_else_begins_with_its_first_frequency() -> None:
    with Dialogue([*OPENED, *RANDOM, *SINE, *SWEEP, *OFF]) as wire:
        drive = generator(wire)
        drive.open()
        drive.random(rms_dps=10.0, low_hz=5.0, high_hz=100.0)
        drive.sweep(rms_dps=10.0, low_hz=12.5, high_hz=100.0, duration_s=60.0)
        drive.close()


def test_the_second_output_and_a_load_of_50_ohm_are_named() -> None:
    second = set_up("SIN", ("FREQ", "12.5"), "0.5", load="50", channel=2)
    off: list[Turn] = [*said("OUTP2 OFF"), *asked(("OUTP2", "0"))]
    with Dialogue([*opening(IDN), *asked(("OUTP2", "0")), *second, *off]) as wire:
        drive = generator(wire, output=2, load="50 ohm")
        drive.open()
        drive.sine(rms_dps=10.0, frequency_hz=12.5)
        drive.close()


@pytest.mark.parametrize(
    ("ask", "told"),
    [
        (
            lambda drive: drive.sine(rms_dps=41.0, frequency_hz=10.0),
            r"41 deg/s rms is asked for, the station allows more than 0 and up to 40 deg/s \(settings.max_rate",
        ),
        (
            lambda drive: drive.random(rms_dps=30.0, low_hz=5.0, high_hz=100.0),
            r"up to 7.08 V peak \(4.6 times the rms\), the station allows 5 V \(settings.max_voltage\)",
        ),
        (lambda drive: drive.sine(rms_dps=0.0, frequency_hz=10.0), "0 deg/s rms is asked for"),
        (lambda drive: drive.sine(rms_dps=float("nan"), frequency_hz=10.0), "nan deg/s rms is asked"),
        (lambda drive: drive.sine(rms_dps=0.001, frequency_hz=10.0), r"needs 7.07e-05 V peak"),
        (lambda drive: drive.sine(rms_dps=1.0, frequency_hz=0.0), "0 to 0 Hz cannot be generated"),
        (
            lambda drive: drive.random(rms_dps=1.0, low_hz=100.0, high_hz=5.0),
            "100 to 5 Hz cannot be generated; frequencies are 0.001 Hz to 2e[+]07 Hz, the lower one first",
        ),
        (
            lambda drive: drive.sweep(rms_dps=1.0, low_hz=5.0, high_hz=100.0, duration_s=900.0),
            "a sweep of 900 s is asked for, a logarithmic one of this generator lasts 0.001 s to 500 s",
        ),
    ],
)
def test_what_the_station_does_not_allow_is_refused_before_anything_is_sent(
    ask: Callable[[VibrationDrive], None], told: str
) -> None:
    with Dialogue(OPENED) as wire:
        drive = generator(wire)
        drive.open()
        with pytest.raises(InstrumentError, match=f"{RESOURCE}: .*{told}.*; nothing was sent"):
            ask(drive)
        drive.close()


@pytest.mark.parametrize(
    ("changed", "told"),
    [
        ({"sensitivity": Quantity(0.0, "deg/s/V")}, "sensitivity '0 deg/s/V' is not more than zero"),
        ({"max_voltage": Quantity(-1.0, "V")}, "max_voltage '-1 V' is not more than zero"),
        ({"output": 3}, "output 3 is neither 1 nor 2"),
        ({"load": "20 kohm"}, "load '20 kohm' is neither 'high' nor 1 ohm to 10000 ohm"),
    ],
)
def test_settings_that_make_no_sense_are_refused(changed: dict[str, Any], told: str) -> None:
    with pytest.raises(ValueError, match=told):
        settings(**changed)


def test_a_setting_that_is_read_back_otherwise_ends_it_before_the_output_is_on() -> None:
    turns: list[Turn] = [
        *OPENED,
        *[one for one in SINE if b"?" not in one[0]][:8],
        *ERRORS,
        *asked(("OUTP1", "0"), ("SOUR1:FREQ:MODE", "CW"), ("OUTP1:LOAD", "+5.0E+01")),
    ]
    with Dialogue(turns) as wire:
        drive = generator(wire)
        drive.open()
        with pytest.raises(InstrumentProtocolError, match=r"OUTP1:LOAD\? gives \+5.0E\+01 after"):
            drive.sine(rms_dps=10.0, frequency_hz=12.5)
        drive.close()


def test_what_the_generator_itself_refuses_is_told_in_its_own_words() -> None:
    refused: Turn = (b"SYST:ERR?\n", b'-222,"Data out of range"\n')
    turns = [*OPENED, *[one for one in SINE if b"?" not in one[0]][:8], refused, *ERRORS]
    with Dialogue(turns) as wire:
        drive = generator(wire)
        drive.open()
        with pytest.raises(InstrumentProtocolError, match=r"\(33522B\).* reports -222,.Data out of"):
            drive.sine(rms_dps=10.0, frequency_hz=12.5)


@pytest.mark.parametrize(
    ("found", "told"),
    [
        ((("OUTP1", "0"),), "the output has gone off by itself; look for a voltage that is fed back"),
        (
            (("OUTP1", "1"), ("SOUR1:FUNC", "SQU")),
            "SOUR1:FUNC. gives 'SQU', expected SIN; was it set by",
        ),
        (
            (("OUTP1", "1"), ("SOUR1:FUNC", "SIN"), ("SOUR1:VOLT", "+2.0E-01")),
            "SOUR1:VOLT. gives 0.2 V rms, expected 0.5 V",
        ),
    ],
)
def test_an_output_that_does_something_else_is_told_by_the_check(
    found: tuple[tuple[str, str], ...], told: str
) -> None:
    with Dialogue([*OPENED, *SINE, *asked(*found), *OFF]) as wire:
        drive = generator(wire)
        drive.open()
        drive.sine(rms_dps=10.0, frequency_hz=12.5)
        with pytest.raises(InstrumentError, match=told):
            drive.check()
        drive.stop()


def test_nothing_is_checked_that_was_not_asked_for() -> None:
    with Dialogue(OPENED) as wire:
        drive = generator(wire)
        drive.open()
        with pytest.raises(InstrumentError, match="nothing was asked of it since it was stopped"):
            drive.check()


def test_an_output_that_a_reset_leaves_on_is_told_of() -> None:
    with Dialogue([*opening(IDN), *asked(("OUTP1", "1"))]) as wire:
        drive = generator(wire)
        with pytest.raises(InstrumentError, match=r"OUTP1\? gives 1 after a reset, expected 0"):
            drive.open()
        drive.close()


def test_another_instrument_is_refused_before_it_is_reset() -> None:
    with Dialogue([(b"*IDN?\n", b"Agilent Technologies,33220A,MY44001234,2.07\n")]) as wire:
        drive = generator(wire)
        with pytest.raises(InstrumentIdentityError, match="expected a Keysight 33500 or 33600 series"):
            drive.open()
