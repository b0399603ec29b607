"""The way to an instrument: what is said where it is closed, broken off, or not there at all."""

import socket
import threading
from collections.abc import Callable, Iterator
from contextlib import closing, contextmanager

import pytest

from gyrotest.errors import InstrumentError, InstrumentProtocolError, InstrumentTimeoutError
from gyrotest.instruments.transport.channel import FlowControl, Parity, SerialLine
from gyrotest.instruments.transport.conversation import Conversation
from gyrotest.instruments.transport.dialogue import Dialogue, DialogueError
from gyrotest.instruments.transport.visa import open_channel, resource_manager
from gyrotest.instruments.transport.visa_session import socket_beneath
from gyrotest.simulation.server import has_pty

# Long enough that a test which waits for it is noticed.
MINUTES_S = 300.0


@contextmanager
def responder(answer: Callable[[socket.socket, bytes], None]) -> Iterator[str]:
    """The address of a server that hands every message of its one connection to `answer`."""
    with socket.create_server(("127.0.0.1", 0)) as listener:

        def serve() -> None:
            connection, _ = listener.accept()
            with connection:
                while data := connection.recv(4096):
                    answer(connection, data)

        thread = threading.Thread(target=serve, daemon=True)
        thread.start()
        yield f"TCPIP::127.0.0.1::{listener.getsockname()[1]}::SOCKET"
        thread.join(5.0)


def conversation(address: str, timeout_s: float = 3.0) -> Conversation:
    return Conversation(address, open_channel(address, SerialLine(), timeout_s))


def test_a_line_that_arrives_in_pieces_is_put_together() -> None:
    def answer(connection: socket.socket, data: bytes) -> None:
        connection.sendall(b"+1.5")
        connection.sendall(b"E+00\n")

    with responder(answer) as address, closing(conversation(address)) as talk:
        assert [talk.query("READ?", 5.0) for _ in range(3)] == ["+1.5E+00"] * 3


def test_a_block_with_line_feeds_in_it_comes_whole() -> None:
    content = bytes(range(256)) * 40

    def answer(connection: socket.socket, data: bytes) -> None:
        connection.sendall(b"#510240" + content + b"\n" if data == b"R?\n" else b"next\n")

    with responder(answer) as address, closing(conversation(address)) as talk:
        assert talk.query_block("R?", 5.0) == content
        assert talk.query("NEXT?", 5.0) == "next"


def test_a_connection_closed_in_the_middle_of_a_reply_is_noticed_at_once() -> None:
    def answer(connection: socket.socket, data: bytes) -> None:
        connection.sendall(b"+1.5")
        connection.shutdown(socket.SHUT_RDWR)

    with (
        responder(answer) as address,
        closing(conversation(address)) as talk,
        pytest.raises(InstrumentError, match=r"connection lost at READ\? \(the instrument closed"),
    ):
        talk.query("READ?", MINUTES_S)


def test_a_reply_too_many_is_seen_before_the_next_query() -> None:
    def answer(connection: socket.socket, data: bytes) -> None:
        connection.sendall(b"one\nlate\n")

    with responder(answer) as address, closing(conversation(address)) as talk:
        assert talk.query("A?", 5.0) == "one"
        with pytest.raises(
            InstrumentProtocolError, match=r"'late' arrived without being asked for, before B\?"
        ):
            talk.query("B?", 5.0)
        talk.clear()
        assert talk.query("C?", 5.0) == "one"


def test_no_reply_is_a_time_out_that_says_how_long() -> None:
    said = r"^TCPIP::127\.0\.0\.1::\d+::SOCKET: .* within 0\.05 s"
    with (
        responder(lambda connection, data: None) as address,
        closing(conversation(address)) as talk,
        pytest.raises(InstrumentTimeoutError, match=said),
    ):
        talk.query("READ?", 0.05)


def test_replies_are_not_held_back_by_the_network() -> None:
    with (
        responder(lambda connection, data: connection.sendall(b"ok\n")) as address,
        closing(conversation(address)) as talk,
    ):
        assert talk.query("*IDN?", 5.0) == "ok"
        beneath = [socket_beneath(one) for one in resource_manager().list_opened_resources()]
        found = [one for one in beneath if one is not None]
        assert found
        assert all(one.getsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY) for one in found)


@pytest.mark.parametrize("adapter", ["", "PRLGX-"])
def test_a_refused_port_is_said_at_opening(adapter: str) -> None:
    with socket.create_server(("127.0.0.1", 0)) as free:
        port = free.getsockname()[1]
    plain = f"TCPIP::127.0.0.1::{port}::SOCKET"
    address = f"PRLGX-TCPIP9::127.0.0.1::{port}::INTFC GPIB9::22::INSTR" if adapter else plain
    with pytest.raises(
        InstrumentError, match=rf"^{address}: cannot be opened \(.*; is the instrument switched on"
    ):
        open_channel(address, SerialLine(), 2.0)


@pytest.mark.parametrize(
    ("address", "reason"),
    [
        ("TCPIP::no-such-host.invalid::5025::SOCKET", "cannot be opened"),
        ("ASRL/dev/no-such-port::INSTR", "cannot be opened"),
        ("nonsense", "cannot be opened"),
        ("GPIB0::22::INSTR GPIB0::23::INSTR", "write one VISA resource"),
        ("PRLGX-TCPIP0::127.0.0.1::1234::INTFC", "write one VISA resource"),
        ("", "write one VISA resource"),
    ],
)
def test_an_address_that_leads_nowhere_is_said(address: str, reason: str) -> None:
    with pytest.raises(InstrumentError, match=rf"^{address}: .*{reason}"):
        open_channel(address, SerialLine(), 2.0)


@pytest.mark.skipif(not has_pty(), reason="this platform has no pseudo-terminals")
def test_a_serial_line_is_set_as_the_station_says() -> None:
    import os

    own, their = os.openpty()
    try:
        # A pseudo-terminal takes neither parity nor seven bits.
        line = SerialLine(baud_rate=19200, stop_bits=2, flow_control=FlowControl.XON_XOFF)
        with closing(open_channel(f"ASRL{os.ttyname(their)}::INSTR", line, 2.0)) as channel:
            (session,) = [
                one
                for one in resource_manager().list_opened_resources()
                if os.ttyname(their) in one.resource_name
            ]
            assert (session.baud_rate, session.data_bits) == (19200, 8)
            assert session.parity.name == "none"
            assert session.stop_bits.name == "two"
            assert session.flow_control.name == "xon_xoff"
            assert channel.seconds_per_byte == pytest.approx(11 / 19200)
    finally:
        os.close(own)
        os.close(their)


def test_a_byte_takes_its_start_parity_and_stop_bits() -> None:
    line = SerialLine(baud_rate=1200, data_bits=7, parity=Parity.EVEN, stop_bits=2)
    assert line.seconds_per_byte == pytest.approx(11 / 1200)


def test_the_dialogue_refuses_what_the_script_does_not_say() -> None:
    wire = Dialogue([(b"A?\n", b"1\n")])
    with pytest.raises(DialogueError, match=r"b'B\?\\n' was sent, the script says b'A\?\\n'"):
        wire.send(b"B?\n")


def test_the_dialogue_refuses_leftovers() -> None:
    with pytest.raises(DialogueError, match="left over"), Dialogue([(b"A?\n", b"1\n")]):
        pass
    with pytest.raises(DialogueError, match="unread b'1"), Dialogue([(b"A?\n", b"1\n")]) as wire:
        wire.send(b"A?\n")


def test_a_resource_manager_closed_by_somebody_else_is_made_anew() -> None:
    resource_manager().close()

    def answer(connection: socket.socket, data: bytes) -> None:
        connection.sendall(b"here\n")

    with responder(answer) as address, closing(conversation(address)) as talk:
        assert talk.query("*IDN?", 5.0) == "here"
