"""The ACUTROL3000 byte by byte: both dialects, limits read back, refusals."""

import pytest

from gyrotest.errors import InstrumentError, InstrumentIdentityError, InstrumentProtocolError
from gyrotest.instruments.acutrol3000 import Acutrol3000, Acutrol3000Settings, Dialect
from gyrotest.instruments.transport.dialogue import Dialogue, Turn
from gyrotest.records.station import Motion
from tests.instruments.meter_turns import StepClock
from tests.instruments.table_bench import motion

# No guard over GPIB: nothing is started beside.
RESOURCE = "GPIB0::1::INSTR"
IDN = b"ACUTRONIC,ACUTROL3000,1234,2.0\n"
PREFIX = b"\x00\x01\x00\x00\x00\x0a\x00\x00"


def told(command: str, status: bytes = b"0\n") -> list[Turn]:
    """A command in the plain dialect, and the question whether it was taken."""
    return [(command.encode() + b"\n", None), (b"*STB?\n", status)]


def answered(command: str, reply: bytes = b"OK") -> Turn:
    return (command.encode() + b"\r\n", PREFIX + reply)


OPEN: list[Turn] = [
    (b"*IDN?\n", IDN),
    *told(":Interlock:Reset"),
    (b":Interlock? 1\n", b"Open\n"),
    (b":Read:Position? 1\n", b"12.5\n"),
]
HELD: list[Turn] = [
    *told(":Demand:Rate 1,0.000000"),
    *told(":Mode:Rate 1"),
    *told(":Demand:Rate 1,0.000000"),
]
CLOSED: Turn = (b":Interlock? 1\n", b"Closed\n")
ENABLE: list[Turn] = [
    *told(":Interlock:Reset"),
    *told(":Demand:Rate 1,0"),
    (b":Read:Rate? 1\n", b"0.0\n"),
    *told(":Mode:Off 1"),
    *told(":Limit:Rate Rate,1,200.000000"),
    (b":Limit:Rate? Rate,1\n", b"200.0\n"),
    *told(":Limit:Acceleration Rate,1,100.000000"),
    (b":Limit:Acceleration? Rate,1\n", b"100.0\n"),
    *told(":Limit:Rate Position,1,200.000000"),
    (b":Limit:Rate? Position,1\n", b"200.0\n"),
    *told(":Limit:Acceleration Position,1,100.000000"),
    (b":Limit:Acceleration? Position,1\n", b"100.0\n"),
    *told(":Interlock:Close 1"),
    CLOSED,
    *HELD,
    CLOSED,
]
OFF: list[Turn] = [
    *HELD,
    (b":Read:Rate? 1\n", b"0.0\n"),
    *told(":Mode:Off 1"),
    *told(":Interlock:Open 1"),
]


def table(
    wire: Dialogue,
    settings: Acutrol3000Settings | None = None,
    limits: Motion | None = None,
    serial_number: str | None = None,
) -> Acutrol3000:
    return Acutrol3000(
        RESOURCE,
        settings or Acutrol3000Settings(),
        clock=StepClock(),
        motion=limits or motion(),
        serial_number=serial_number,
        connect=wire.connect,
    )


def test_a_run_from_opening_to_closing() -> None:
    turns: list[Turn] = [
        *OPEN,
        *ENABLE,
        CLOSED,
        *told(":Demand:Rate 1,-40.500000"),
        *told(":Mode:Rate 1"),
        *told(":Demand:Rate 1,-40.500000"),
        CLOSED,
        (b":Read:Rate? 1\n", b"-40.4999\n"),
        (b":Read:Position? 1\n", b"12.5\n"),
        *OFF,
    ]
    with Dialogue(turns) as wire:
        driver = table(wire)
        identity = driver.open()
        driver.enable()
        driver.set_rate(-40.5)
        assert driver.rate_dps() == -40.4999
        driver.close()
        assert wire.closed == 1
    assert (identity.manufacturer, identity.serial_number) == ("ACUTRONIC", "1234")


def test_a_table_that_was_not_switched_on_is_left_as_it_is() -> None:
    with Dialogue(OPEN) as wire:
        driver = table(wire)
        driver.open()
        driver.close()


def test_behind_status_bytes_every_command_is_answered_with_ok() -> None:
    turns: list[Turn] = [
        answered("*IDN?", b"not known"),
        answered(":Interlock:Reset"),
        answered(":Interlock? 2", b"Open"),
        answered(":Read:Position 2", b"359.25\r\n"),
        answered(":Read:Position 2", b"0.25"),
    ]
    settings = Acutrol3000Settings(dialect=Dialect.STATUS, axis=2)
    with Dialogue(turns) as wire:
        driver = table(wire, settings, serial_number="AC-1")
        identity = driver.open()
        assert driver.position_deg() == pytest.approx(360.25)
    assert (identity.model, identity.serial_number) == ("ACUTROL3000", "AC-1")
    assert not identity.simulated


def test_a_missing_ok_is_shown() -> None:
    turns = [answered("*IDN?", IDN), answered(":Interlock:Reset", b"NOT IN REMOTE")]
    with (
        Dialogue(turns) as wire,
        pytest.raises(InstrumentProtocolError, match="'NOT IN REMOTE', expected OK"),
    ):
        table(wire, Acutrol3000Settings(dialect=Dialect.STATUS)).open()


def test_status_bytes_that_the_settings_do_not_know_of_are_shown() -> None:
    turns: list[Turn] = [
        (b"*IDN?\r\n", IDN),
        (b":Interlock:Reset\r\n", b"\x00\x01\x00\x00\x00\x02\x00\x00OK"),
    ]
    settings = Acutrol3000Settings(dialect=Dialect.STATUS, prefix_bytes=0)
    with Dialogue(turns) as wire, pytest.raises(InstrumentProtocolError, match="prefix_bytes set as"):
        table(wire, settings).open()


def test_a_question_mark_is_a_refusal() -> None:
    turns = [*OPEN[:-1], (b":Read:Position? 1\n", b"?\n")]
    with (
        Dialogue(turns) as wire,
        pytest.raises(InstrumentProtocolError, match=r"answers '\?' to :Read:Pos"),
    ):
        table(wire).open()


def test_a_set_summary_bit_after_a_command_is_a_refusal() -> None:
    turns: list[Turn] = [*OPEN[:1], *told(":Interlock:Reset", b"65\n"), CLOSED]
    with (
        Dialogue(turns) as wire,
        pytest.raises(InstrumentProtocolError, match="status byte is 65 after"),
    ):
        table(wire).open()


def test_an_interlock_fault_that_a_reset_does_not_clear_is_said_at_opening() -> None:
    turns: list[Turn] = [*OPEN[:3], (b":Interlock? 1\n", b"Fault\n")]
    with Dialogue(turns) as wire:
        driver = table(wire)
        with pytest.raises(InstrumentError, match=r"\(ACUTROL3000\): .* interlock fault of axis 1"):
            driver.open()
        assert wire.closed == 1


def test_a_limit_that_the_controller_does_not_take_is_shown() -> None:
    place = next(i for i, turn in enumerate(ENABLE) if turn[0] == b":Limit:Rate? Rate,1\n")
    turns: list[Turn] = [*OPEN, *ENABLE[:place], (b":Limit:Rate? Rate,1\n", b"100.0\n")]
    with Dialogue(turns) as wire:
        driver = table(wire)
        driver.open()
        with pytest.raises(InstrumentProtocolError, match=r"gives 100 after 200 was set"):
            driver.enable()


def test_another_instrument_is_refused() -> None:
    turns: list[Turn] = [(b"*IDN?\n", b"KEYSIGHT,34465A,MY1,A\n")]
    said = "expected an Acutronic ACUTROL3000"
    with Dialogue(turns) as wire, pytest.raises(InstrumentIdentityError, match=said):
        table(wire).open()


def test_a_rate_that_needs_turns_is_refused_before_a_byte_is_sent() -> None:
    with Dialogue([*OPEN, *ENABLE]) as wire:
        driver = table(wire, limits=motion(slip_ring=False))
        driver.open()
        driver.enable()
        with pytest.raises(InstrumentError, match="neither a slip ring nor how far"):
            driver.set_rate(1.0)


def test_a_late_reply_does_not_make_stopping_fail() -> None:
    class Late(Dialogue):
        def finish(self) -> None:
            """What is left is the point."""

    turns: list[Turn] = [*OPEN, *ENABLE, (b":Interlock? 1\n", TimeoutError()), *HELD]
    with Late(turns) as wire:
        driver = table(wire)
        driver.open()
        driver.enable()
        with pytest.raises(InstrumentError, match="no reply to :Interlock"):
            driver.rate_dps()
        wire._replies += b"Closed\n"
        driver.stop()
        assert not wire._turns


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"axis": 0}, "axis 0 is not 1 to 6"),
        ({"prefix_bytes": -1}, "less than 0"),
        ({"baud_rate": 0}, "not more than zero"),
    ],
)
def test_settings_that_cannot_be_are_refused(given: dict[str, int], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        Acutrol3000Settings(**given)
