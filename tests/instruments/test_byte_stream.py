"""Bytes as they arrive, over pseudo-terminals and sockets."""

import os
import pty
import socket
import threading
import tty
from collections.abc import Callable, Iterator
from contextlib import closing

import pytest

from gyrotest.errors import InstrumentError
from gyrotest.instruments.transport.byte_stream import ByteStream, open_stream
from gyrotest.instruments.transport.channel import SerialLine
from gyrotest.simulation.server import has_pty

needs_pty = pytest.mark.skipif(not has_pty(), reason="this platform has no pseudo-terminals")
Peer = tuple[ByteStream, Callable[[bytes], object], Callable[[int], bytes], Callable[[], object]]


@pytest.fixture(params=["tcp", pytest.param("pty", marks=needs_pty)])
def peer(request: pytest.FixtureRequest) -> Iterator[Peer]:
    """An open stream; and its other end: send, receive, hang up."""
    if request.param == "tcp":
        with socket.create_server(("127.0.0.1", 0)) as server:
            port = server.getsockname()[1]
            stream = open_stream(f"TCPIP0::127.0.0.1::{port}::SOCKET", SerialLine(), 1.0)
            other, _ = server.accept()
            with closing(stream), other:
                yield stream, other.sendall, other.recv, other.close
        return
    master, slave = pty.openpty()
    tty.setraw(slave)
    stream = open_stream(f"ASRL{os.ttyname(slave)}::INSTR", SerialLine(baud_rate=460800), 1.0)
    left = [slave, master]

    def hang_up() -> None:
        while left:
            os.close(left.pop(0))

    with closing(stream):
        yield stream, lambda data: os.write(master, data), lambda n: os.read(master, n), hang_up
    hang_up()


def test_all_that_has_arrived_comes_at_once(peer: Peer) -> None:
    stream, send, _, _ = peer
    sent = bytes(range(256)) * 60
    # A terminal may hold less than that, and then holds the sender up.
    sender = threading.Thread(target=send, args=(sent,))
    sender.start()
    assert stream.read(len(sent), 30.0) == sent
    sender.join()
    assert stream.read() == b""


def test_a_wait_ends_with_the_last_byte_that_is_waited_for(peer: Peer) -> None:
    stream, send, _, _ = peer
    send(b"abc")
    later = threading.Timer(0.05, send, (b"defgh",))
    later.start()
    assert stream.read(8, 30.0) == b"abcdefgh"
    later.join()


def test_a_wait_for_what_does_not_come_gives_what_is_there(peer: Peer) -> None:
    stream, send, _, _ = peer
    send(b"abc")
    assert stream.read(8, 0.05) == b"abc"


def test_what_is_written_arrives(peer: Peer) -> None:
    stream, _, receive, _ = peer
    stream.write(b"I\r")
    assert receive(10) == b"I\r"


def test_what_is_discarded_is_gone(peer: Peer) -> None:
    stream, send, _, _ = peer
    send(b"x" * 3000)
    assert len(stream.read(1, 5.0)) >= 1
    stream.discard()
    send(b"fresh")
    assert stream.read(5, 5.0)[-5:] == b"fresh"


def test_a_peer_that_has_gone_is_an_error_at_once(peer: Peer) -> None:
    stream, _, _, hang_up = peer
    hang_up()
    with pytest.raises(OSError, match=r".+"):
        stream.read(1, 30.0)
    stream.close()


def test_a_refused_connection_and_a_resource_of_another_kind_are_errors() -> None:
    with socket.create_server(("127.0.0.1", 0)) as server:
        port = server.getsockname()[1]
    with pytest.raises(InstrumentError, match=r"cannot be opened: .*; is it connected"):
        open_stream(f"TCPIP::127.0.0.1::{port}::SOCKET", SerialLine(), 1.0)
    with pytest.raises(InstrumentError, match="is no stream of bytes; write ASRL"):
        open_stream("USB0::1::2::INSTR", SerialLine(), 1.0)


@needs_pty
def test_a_port_is_not_opened_twice() -> None:
    master, slave = pty.openpty()
    resource = f"ASRL{os.ttyname(slave)}::INSTR"
    with (
        closing(open_stream(resource, SerialLine(), 1.0)),
        pytest.raises(InstrumentError, match="not in use elsewhere"),
    ):
        open_stream(resource, SerialLine(), 1.0)
    os.close(slave)
    os.close(master)
