"""The Ideal Aerosmith table byte by byte: the prompt, echoes, refusals, and a rate made of positions."""

from typing import Any

import pytest

from gyrotest.errors import InstrumentError, InstrumentIdentityError, InstrumentProtocolError
from gyrotest.instruments.aerosmith import Aerosmith, AerosmithSettings
from gyrotest.instruments.transport.dialogue import Dialogue, Turn
from gyrotest.records.station import Motion
from gyrotest.units import Quantity
from tests.instruments.meter_turns import StepClock
from tests.instruments.table_bench import motion

RESOURCE = "GPIB0::2::INSTR"


def told(command: str, reply: bytes = b"\r\n>\r\n") -> Turn:
    return (command.encode() + b"\r", reply)


def at(position: str) -> Turn:
    return told("PPO", position.encode() + b"\r\n>\r\n")


OPEN: list[Turn] = [told("*IDN?", b"?\r\n>\r\n"), at("10.0")]
# At rest is what two positions a second apart say.
ENABLE: list[Turn] = [
    told("STO"),
    at("10.0"),
    at("10.0"),
    told("ACL100"),
    told("SRV1"),
    told("STO"),
]
OFF: list[Turn] = [told("STO"), at("30.0"), at("30.0"), told("SRV0")]


def table(
    wire: Dialogue,
    settings: AerosmithSettings | None = None,
    limits: Motion | None = None,
    clock: StepClock | None = None,
) -> Aerosmith:
    return Aerosmith(
        RESOURCE,
        settings or AerosmithSettings(),
        clock=clock or StepClock(),
        motion=limits or motion(),
        connect=wire.connect,
    )


class Trailing(Dialogue):
    """The line end behind the last prompt stays unread, as on a real line."""

    def finish(self) -> None:
        assert not self._turns
        assert not bytes(self._replies).strip()


def test_a_run_from_opening_to_closing() -> None:
    clock = StepClock()
    turns: list[Turn] = [*OPEN, *ENABLE, told("JOG-20.5"), at("350.0"), at("329.5"), *OFF]
    with Trailing(turns) as wire:
        driver = table(wire, clock=clock)
        identity = driver.open()
        driver.enable()
        driver.set_rate(-20.5)
        clock.sleep_until(clock.now_s() + 1.0)
        assert driver.rate_dps() == pytest.approx(-20.5)
        driver.close()
        assert wire.closed == 1
    assert identity.serial_number == "not stated"
    assert not identity.simulated


def test_positions_far_enough_apart_give_a_rate_without_waiting() -> None:
    clock = StepClock()
    turns: list[Turn] = [*OPEN, *ENABLE, told("JOG36"), at("30.0"), at("66.0"), at("174.0")]
    with Trailing(turns) as wire:
        driver = table(wire, clock=clock)
        driver.open()
        driver.enable()
        driver.set_rate(36.0)
        clock.sleep_until(clock.now_s() + 1.0)
        assert driver.rate_dps() == pytest.approx(36.0)
        waits = len(clock.waits)
        clock.time_s += 3.0
        assert driver.rate_dps() == pytest.approx(36.0)
        assert len(clock.waits) == waits


def test_a_rate_query_of_the_controller_s_own_is_used() -> None:
    turns: list[Turn] = [
        *OPEN,
        told("PVE", b"PVE\r\n12.5\r\n>\r\n"),
        at("10.0"),
    ]
    with Trailing(turns) as wire:
        driver = table(wire, AerosmithSettings(rate_query="PVE"))
        driver.open()
        assert driver.rate_dps() == 12.5


def test_an_echo_before_the_prompt_is_no_refusal() -> None:
    turns = [told("*IDN?", b"*IDN?\r\n?\r\n>"), told("PPO", b"PPO\r\n-3.25\r\n>")]
    with Trailing(turns) as wire:
        driver = table(wire)
        driver.open()


def test_a_question_mark_is_a_refusal() -> None:
    turns = [*OPEN, told("STO", b"?\r\n>\r\n")]
    with Trailing(turns) as wire:
        driver = table(wire)
        driver.open()
        with pytest.raises(
            InstrumentProtocolError, match=r"answers '\?' to STO: refused; is the drive on"
        ):
            driver.enable()


def test_what_is_no_number_is_shown_with_a_hint_at_the_baud_rate() -> None:
    turns = [*OPEN[:1], told("PPO", b"\x15#x\r\n>")]
    said = r"expected a number; .* its baud rate right"
    with Trailing(turns) as wire, pytest.raises(InstrumentProtocolError, match=said):
        table(wire).open()


def test_a_reply_to_a_command_that_has_none_is_shown() -> None:
    with Trailing([*OPEN, told("STO", b"LIMIT\r\n>")]) as wire:
        driver = table(wire)
        driver.open()
        with pytest.raises(InstrumentProtocolError, match="STO is answered with 'LIMIT', expected '>'"):
            driver.enable()


def test_a_reply_that_comes_while_it_is_stopped_does_not_keep_the_stop_from_being_sent() -> None:
    class Interfering(Trailing):
        """Between the look at the line and the command, an earlier reply arrives."""

        def send(self, data: bytes) -> None:
            super().send(data)
            if data == b"JOG20\r":
                self._late = True

        _late = False

        def unread(self) -> bytes:
            if self._late:
                self._late = False
                return b""
            if self._turns[:1] == [told("STO")] and self._turns[1:] == []:
                self._replies += b"33.0\r\n>"
            return super().unread()

    with Interfering([*OPEN, *ENABLE, told("JOG20"), told("STO")]) as wire:
        driver = table(wire)
        driver.open()
        driver.enable()
        driver.set_rate(20.0)
        driver.stop()


def test_silence_names_what_to_look_at() -> None:
    turns: list[Turn] = [(b"*IDN?\r", TimeoutError())]
    with Dialogue(turns) as wire, pytest.raises(InstrumentError, match="the settings of the line right"):
        table(wire).open()


def test_what_is_another_instrument_by_its_own_words_is_refused() -> None:
    turns = [told("*IDN?", b"KEYSIGHT,34465A,MY1,A\r\n>")]
    said = "expected an Ideal Aerosmith rate table"
    with Trailing(turns) as wire, pytest.raises(InstrumentIdentityError, match=said):
        table(wire).open()


def test_an_angle_that_winds_the_cables_up_is_refused_before_a_byte_is_sent() -> None:
    with Trailing([*OPEN, *ENABLE]) as wire:
        driver = table(wire, limits=motion(slip_ring=False, max_turns=0.25))
        driver.open()
        driver.enable()
        with pytest.raises(
            InstrumentError, match=r"the angle 150 deg would turn the table by 0\.39 turns"
        ):
            driver.move_to(150.0)


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"rate_query": "pve"}, "is no command"),
        ({"rate_query": "JOG 3"}, "is no command"),
        ({"baud_rate": -1}, "not more than zero"),
        ({"rate_span": Quantity(10.0, "ms")}, "rate_span 10 ms is not 0.1 s to 30 s"),
    ],
)
def test_settings_that_cannot_be_are_refused(given: dict[str, Any], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        AerosmithSettings(**given)
