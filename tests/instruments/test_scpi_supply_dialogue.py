"""The SCPI power supply byte by byte: the order of its commands, its outputs, what it refuses."""

import pytest

from gyrotest.errors import (
    InstrumentError,
    InstrumentIdentityError,
    InstrumentProtocolError,
    InstrumentTimeoutError,
)
from gyrotest.instruments.scpi_supply import ScpiSupply, ScpiSupplySettings, Select
from gyrotest.instruments.transport.dialogue import Dialogue, Turn
from tests.instruments.meter_turns import ERRORS, StepClock

IDN = b"Keysight Technologies,E36312A,MY59001234,1.0.4\n"
OPENED: list[Turn] = [(b"*IDN?\n", IDN), (b"*CLS\n", None)]
CLOSED: list[Turn] = [(b"OUTP OFF\n", None), (b"OUTP?\n", b"0\n")]


def said(*commands: str) -> list[Turn]:
    return [(f"{one}\n".encode(), None) for one in commands]


def asked(**replies: str) -> list[Turn]:
    return [
        (f"{header.replace('_', ':')}?\n".encode(), f"{reply}\n".encode())
        for header, reply in replies.items()
    ]


SET: list[Turn] = [
    *asked(VOLT="+0.00000000E+00"),
    *said("VOLT:PROT 5.5", "CURR 0.2", "VOLT 5"),
    *ERRORS,
    *asked(VOLT_PROT="+5.50000000E+00", CURR="+2.00000000E-01", VOLT="+5.00000000E+00"),
]


def supply(
    wire: Dialogue, *, output: int = 1, serial_number: str | None = None, **settings: object
) -> ScpiSupply:
    return ScpiSupply(
        "TCPIP::psu::5025::SOCKET",
        ScpiSupplySettings(**settings),  # type: ignore[arg-type]
        clock=StepClock(),
        output=output,
        serial_number=serial_number,
        connect=wire.connect,
    )


def set_up(one: ScpiSupply) -> None:
    one.set(voltage_v=5.0, current_limit_a=0.2, over_voltage_v=5.5)


def test_protection_is_set_before_limit_and_voltage_and_the_output_goes_off_at_the_end() -> None:
    turns: list[Turn] = [
        *OPENED,
        *SET,
        *said("OUTP ON"),
        *ERRORS,
        *asked(MEAS_VOLT="+5.00100000E+00", MEAS_CURR="+4.00000000E-02", VOLT_PROT_TRIP="0"),
        *CLOSED,
    ]
    with Dialogue(turns) as wire:
        one = supply(wire)
        identity = one.open()
        set_up(one)
        one.on()
        found = one.measure()
        one.close()
        one.close()
    assert identity.serial_number == "MY59001234"
    assert (found.voltage_v, found.current_a) == (5.001, 0.04)
    assert not found.limiting
    assert not found.tripped


def test_the_instrument_is_never_reset_since_other_outputs_may_feed_other_units() -> None:
    with Dialogue([*OPENED, *CLOSED]) as wire:
        one = supply(wire)
        one.open()
        one.close()


def test_an_output_of_several_is_named_before_each_command() -> None:
    second = said("INST:NSEL 2")
    turns: list[Turn] = [
        *OPENED,
        *second, *asked(VOLT="5"),
        *second, *said("VOLT:PROT 5.5"),
        *second, *said("VOLT:PROT:STAT ON"),
        *second, *said("CURR 0.2"),
        *second, *said("VOLT 5"),
        *ERRORS,
        *second, *asked(VOLT_PROT="5.5"),
        *second, *asked(CURR="0.2"),
        *second, *asked(VOLT="5"),
        *second, *said("OUTP OFF"),
        *second, *asked(OUTP="0"),
    ]  # fmt: skip
    with Dialogue(turns) as wire:
        one = supply(wire, output=2, outputs=3, protection_on="VOLT:PROT:STAT ON")
        one.open()
        set_up(one)
        one.close()


def test_an_output_may_be_named_by_a_channel_list() -> None:
    query = "STAT:QUES:INST:ISUM{output}:COND?"
    turns: list[Turn] = [
        *OPENED,
        (b"VOLT? (@2)\n", b"0\n"),
        *said("VOLT:PROT 5.5,(@2)", "CURR 0.2,(@2)", "VOLT 5,(@2)"),
        *ERRORS,
        (b"VOLT:PROT? (@2)\n", b"5.5\n"),
        (b"CURR? (@2)\n", b"0.2\n"),
        (b"VOLT? (@2)\n", b"5\n"),
        *said("OUTP ON,(@2)"),
        *ERRORS,
        (b"MEAS:VOLT? (@2)\n", b"4.1\n"),
        (b"MEAS:CURR? (@2)\n", b"0.1\n"),
        (b"STAT:QUES:INST:ISUM2:COND?\n", b"+3\n"),
        (b"VOLT:PROT:TRIP? (@2)\n", b"0\n"),
        *said("OUTP OFF,(@2)"),
        (b"OUTP? (@2)\n", b"0\n"),
    ]
    with Dialogue(turns) as wire:
        one = supply(wire, output=2, outputs=2, select=Select.CHANNEL_LIST, limit_query=query)
        one.open()
        set_up(one)
        one.on()
        assert one.measure().limiting
        one.close()


def test_a_higher_voltage_from_before_is_lowered_before_the_protection_is() -> None:
    turns: list[Turn] = [
        *OPENED,
        *asked(VOLT="12"),
        *said("VOLT 5", "VOLT:PROT 5.5", "CURR 0.2", "VOLT 5"),
        *ERRORS,
        *asked(VOLT_PROT="5.5", CURR="0.2", VOLT="5"),
    ]
    with Dialogue(turns) as wire:
        one = supply(wire)
        one.open()
        set_up(one)


@pytest.mark.parametrize(
    ("current", "trip", "limiting", "tripped"),
    [("0.1999", "0", True, False), ("0.19", "0", False, False), ("0", "1", False, True)],
)
def test_a_current_at_its_limit_and_a_tripped_protection_are_told(
    current: str, trip: str, limiting: bool, tripped: bool
) -> None:
    turns = [*OPENED, *SET, *asked(MEAS_VOLT="1.0", MEAS_CURR=current, VOLT_PROT_TRIP=trip)]
    with Dialogue(turns) as wire:
        one = supply(wire)
        one.open()
        set_up(one)
        found = one.measure()
    assert (found.limiting, found.tripped) == (limiting, tripped)


def test_a_supply_that_cannot_tell_a_trip_has_tripped_when_its_output_went_off_by_itself() -> None:
    off = asked(MEAS_VOLT="0", MEAS_CURR="0", OUTP="0")
    turns = [*OPENED, *asked(MEAS_VOLT="0", MEAS_CURR="0"), *said("OUTP ON"), *ERRORS, *off]
    with Dialogue(turns) as wire:
        one = supply(wire, trip_query="")
        one.open()
        assert not one.measure().tripped
        one.on()
        assert one.measure().tripped


def test_no_answer_to_the_trip_query_says_how_to_change_it() -> None:
    turns: list[Turn] = [
        *OPENED,
        *asked(MEAS_VOLT="0", MEAS_CURR="0"),
        (b"VOLT:PROT:TRIP?\n", TimeoutError()),
    ]
    with Dialogue(turns) as wire:
        one = supply(wire)
        one.open()
        with pytest.raises(
            InstrumentTimeoutError, match="write the query that it knows into the setting trip_query"
        ):
            one.measure()


@pytest.mark.parametrize(
    ("header", "reply", "message"),
    [
        ("VOLT_PROT", "6.6", r"\(E36312A\) output 1: VOLT:PROT\? gives 6.6 V, expected 5.5 V"),
        ("CURR", "1", r"CURR\? gives 1 A, expected 0.2 A"),
        ("VOLT", "5.1", r"VOLT\? gives 5.1 V, expected 5 V; is it within what this supply can do"),
    ],
)
def test_a_setting_that_was_not_taken_is_refused(header: str, reply: str, message: str) -> None:
    names = ["VOLT_PROT", "CURR", "VOLT"]
    good = {"VOLT_PROT": "5.5", "CURR": "0.2", "VOLT": "5"}
    read = [turn for name in names[: names.index(header)] for turn in asked(**{name: good[name]})]
    with Dialogue([*OPENED, *SET[: 4 + len(ERRORS)], *read, *asked(**{header: reply})]) as wire:
        one = supply(wire)
        one.open()
        with pytest.raises(InstrumentProtocolError, match=message):
            set_up(one)


def test_what_a_supply_refuses_is_told() -> None:
    refused: list[Turn] = [(b"SYST:ERR?\n", b'-222,"Data out of range"\n'), *ERRORS]
    with Dialogue([*OPENED, *SET[:4], *refused]) as wire:
        one = supply(wire)
        one.open()
        with pytest.raises(InstrumentProtocolError, match="Data out of range"):
            set_up(one)


def test_an_output_that_stays_on_is_an_error() -> None:
    with Dialogue([*OPENED, *said("OUTP OFF"), *asked(OUTP="1")]) as wire:
        one = supply(wire)
        one.open()
        with pytest.raises(
            InstrumentProtocolError, match="still on after OUTP OFF; switch it off at its front"
        ):
            one.off()


def test_a_lost_connection_is_opened_anew_to_switch_off() -> None:
    turns: list[Turn] = [
        *OPENED,
        (b"OUTP OFF\n", None),
        (b"OUTP?\n", ConnectionResetError("gone")),
        (b"*IDN?\n", ConnectionResetError("gone")),
        *OPENED,
        *CLOSED,
    ]
    with Dialogue(turns) as wire:
        one = supply(wire)
        one.open()
        one.close()
    assert wire.opened == 2


@pytest.mark.parametrize(
    ("settings", "serial_number", "message"),
    [
        (
            {"identity": "ROHDE.*HMP4040"},
            None,
            r"found Keysight Technologies E36312A .* expected 'ROHDE.*HMP4040'",
        ),
        ({}, "MY00000000", "serial number MY59001234, expected MY00000000"),
    ],
)
def test_another_supply_is_refused(
    settings: dict[str, object], serial_number: str | None, message: str
) -> None:
    wire = Dialogue(OPENED)
    one = supply(wire, serial_number=serial_number, **settings)
    with pytest.raises(InstrumentIdentityError, match=message):
        one.open()
    one.close()
    assert wire.closed == 1


def test_an_output_that_there_is_not_is_refused_before_anything_is_sent() -> None:
    with (
        Dialogue([]) as wire,
        pytest.raises(InstrumentError, match="output 3 is asked for, the supply has 2"),
    ):
        supply(wire, output=3, outputs=2).open()


@pytest.mark.parametrize("over_voltage_v", [4.9, 5.0])
def test_a_protection_that_is_not_above_the_voltage_is_refused(over_voltage_v: float) -> None:
    with Dialogue(OPENED) as wire:
        one = supply(wire)
        one.open()
        with pytest.raises(InstrumentError, match="the protection lies above the voltage"):
            one.set(voltage_v=5.0, current_limit_a=0.2, over_voltage_v=over_voltage_v)


def test_off_and_close_before_open_say_nothing() -> None:
    with Dialogue([]) as wire:
        one = supply(wire)
        one.off()
        one.close()


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        ({"outputs": 0}, "outputs 0 is less than one"),
        ({"identity": "("}, "is no regular expression"),
        ({"data_bits": 9}, "data_bits 9"),
        ({"trip_query": "STAT:QUES:COND"}, "is no query"),
        ({"limit_mask": 0}, "a mask without a bit"),
    ],
)
def test_settings_are_checked(settings: dict[str, object], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        ScpiSupplySettings(**settings)  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("reply", "tripped"), [("NO", False), ("YES", True), ("ON", True), ("+0", False), ("1", True)]
)
def test_a_supply_may_answer_in_words(reply: str, tripped: bool) -> None:
    turns = [*OPENED, *asked(MEAS_VOLT="5", MEAS_CURR="0"), (b"OUTP:OVP:QUES?\n", f"{reply}\n".encode())]
    with Dialogue([*turns, (b"OUTP OFF\n", None), (b"OUTP?\n", b"OFF\n")]) as wire:
        one = supply(wire, trip_query="OUTP:OVP:QUES?")
        one.open()
        assert one.measure().tripped is tripped
        one.off()


def test_an_answer_that_is_neither_yes_nor_no_is_told() -> None:
    with Dialogue([*OPENED, (b"OUTP OFF\n", None), (b"OUTP?\n", b"CV\n")]) as wire:
        one = supply(wire)
        one.open()
        with pytest.raises(InstrumentProtocolError, match=r"OUTP\? gives 'CV', expected 0 or 1"):
            one.off()
