"""SCPI headers, path memory, parameters and the error queue."""

import pytest

from gyrotest.simulation import scpi
from gyrotest.simulation.scpi import ErrorQueue, ScpiError, Table, spellings


def name(text: str) -> scpi.Action[None]:
    return lambda _, parameters: ",".join((text, *parameters))


TABLE: Table[None] = Table(
    {
        "*IDN?": name("idn"),
        "[SENSe:]VOLTage[:DC]:NPLCycles": name("nplc"),
        "[SENSe:]VOLTage[:DC]:RANGe": name("range"),
        "TRIGger:COUNt": name("count"),
        "TRIGger:DELay": name("delay"),
        "SAMPle:COUNt?": name("samples?"),
        "DISPlay:TEXT": name("text"),
    }
)


def run(message: str) -> list[object]:
    return [
        call.action(None, call.parameters) if call.action else call.refusal
        for call in TABLE.compile(message)
    ]


@pytest.mark.parametrize(
    "message",
    ["VOLT:NPLC 10", "volt:dc:nplc 10", "SENSe:VOLTage:DC:NPLCycles 10", ":Sens:Volt:Nplcycles  10 "],
)
def test_short_long_and_optional_nodes_are_one_command(message: str) -> None:
    assert run(message) == ["nplc,10"]


@pytest.mark.parametrize(
    "message", ["VOLTA:NPLC 10", "NPLC 10", "VOLT:NPLC? 10", "VOLT:AC:NPLC 1", "*FOO?"]
)
def test_anything_else_is_an_undefined_header(message: str) -> None:
    assert run(message) == [-113]


def test_a_header_after_a_semicolon_continues_the_path() -> None:
    assert run("TRIG:COUN 1;DEL 0") == ["count,1", "delay,0"]
    assert run("VOLT:NPLC 1;RANG 10") == ["nplc,1", "range,10"]


def test_a_colon_begins_at_the_root_again() -> None:
    assert run("TRIG:COUN 1;:SAMP:COUN?") == ["count,1", "samples?"]
    assert run("TRIG:COUN 1;SAMP:COUN?") == ["count,1", -113]


def test_a_common_command_leaves_the_path() -> None:
    assert run("TRIG:COUN 1;*IDN?;DEL 2") == ["count,1", "idn", "delay,2"]


def test_separators_within_quotes_do_not_count() -> None:
    assert run('DISP:TEXT "a;b,c";*IDN?') == ['text,"a;b,c"', "idn"]


def test_spellings_lists_short_and_long() -> None:
    assert set(spellings("[SENSe:]ZERO:AUTO")) == {"ZERO:AUTO", "SENS:ZERO:AUTO", "SENSE:ZERO:AUTO"}


@pytest.mark.parametrize(
    ("text", "value"), [("MIN", 1.0), ("maximum", 9.0), ("DEF", 2.0), ("1E0", 1.0), ("+3.5", 3.5)]
)
def test_numbers_and_their_names(text: str, value: float) -> None:
    assert scpi.number(text, least=1.0, most=9.0, default=2.0) == value


@pytest.mark.parametrize(
    ("text", "code"), [("10", -222), ("x", -104), ("1 V", -104), ("nan", -104), ("", -104)]
)
def test_bad_numbers_are_refused(text: str, code: int) -> None:
    with pytest.raises(ScpiError) as refused:
        scpi.number(text, least=1.0, most=9.0)
    assert refused.value.code == code


def test_the_error_queue_is_first_in_first_out() -> None:
    queue = ErrorQueue()
    queue.push(-113)
    queue.push(-222)
    assert [queue.pop() for _ in range(3)] == [
        '-113,"Undefined header"',
        '-222,"Data out of range"',
        '+0,"No error"',
    ]


def test_the_twenty_first_error_becomes_an_overflow() -> None:
    queue = ErrorQueue()
    for _ in range(25):
        queue.push(-113)
    popped = [queue.pop() for _ in range(21)]
    assert popped[18:] == ['-113,"Undefined header"', '-350,"Too many errors"', '+0,"No error"']


def test_a_definite_length_block_states_its_length() -> None:
    assert scpi.block(b"") == b"#10"
    assert scpi.block(b"x" * 12) == b"#212" + b"x" * 12
