"""Bytes over the TCP connection of a `TCPIP…::SOCKET` resource.

PyVISA-py opens the connection; the bytes are exchanged here, because its read goes on waiting, at
full load, for the whole time-out after the peer has closed, and its write notices only the next time.
"""

import select
import socket
import time
from collections.abc import Callable

_CHUNK = 65536
_DRAIN_S = 0.1


def peer_has_gone(connection: socket.socket) -> bool:
    """Whether the peer has closed the connection and left nothing to read."""
    readable, _, _ = select.select((connection,), (), (), 0)
    return bool(readable) and not connection.recv(1, socket.MSG_PEEK)


def send_at_once(connection: socket.socket) -> None:
    """Turn Nagle's algorithm off: it holds a write that follows a write back for 40 ms."""
    connection.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)


class SocketChannel:
    """A connected socket as a channel."""

    seconds_per_byte = 0.0
    longest_wait_s: float | None = None
    remote_by_command = False

    def __init__(self, connection: socket.socket, close: Callable[[], None]) -> None:
        self._socket = connection
        self._close = close
        self._buffer = bytearray()
        self._timeout_s: float | None = None

    def unread(self) -> bytes:
        """What has arrived without being asked for; raises at once if the peer has gone."""
        if select.select((self._socket,), (), (), 0)[0]:
            self._buffer += self._receive_some(1.0)
        return bytes(self._buffer)

    def send(self, data: bytes) -> None:
        """Send all the bytes."""
        self._socket.sendall(data)

    def receive_line(self, timeout_s: float) -> bytes:
        """The bytes up to and including the next line feed."""
        buffer = self._buffer
        if not buffer:
            data = self._receive_some(timeout_s)
            if data.find(b"\n") == len(data) - 1:
                return data
            buffer += data
        return self._take(self._line_end(timeout_s))

    def receive_exactly(self, count: int, timeout_s: float) -> bytes:
        """That many bytes, whatever they are."""
        deadline_s = time.monotonic() + timeout_s
        while len(self._buffer) < count:
            self._buffer += self._receive_some(_left_s(deadline_s))
        return self._take(count)

    def clear(self) -> None:
        """Forget what has arrived; a raw socket knows no device clear."""
        self._buffer.clear()
        while select.select((self._socket,), (), (), _DRAIN_S)[0]:
            self._receive_some(1.0)

    def go_to_local(self) -> None:
        """Nothing: a raw socket has no message for it."""

    def close(self) -> None:
        """Disconnect."""
        self._close()

    def _line_end(self, timeout_s: float) -> int:
        deadline_s = time.monotonic() + timeout_s
        searched = 0
        while (found := self._buffer.find(b"\n", searched)) < 0:
            searched = len(self._buffer)
            self._buffer += self._receive_some(_left_s(deadline_s))
        return found + 1

    def _take(self, count: int) -> bytes:
        data = bytes(self._buffer[:count])
        del self._buffer[:count]
        return data

    def _receive_some(self, timeout_s: float) -> bytes:
        if timeout_s != self._timeout_s:
            self._socket.settimeout(timeout_s)
            self._timeout_s = timeout_s
        data = self._socket.recv(_CHUNK)
        if not data:
            raise ConnectionAbortedError("the instrument closed the connection")
        return data


def _left_s(deadline_s: float) -> float:
    left_s = deadline_s - time.monotonic()
    if left_s <= 0:
        raise TimeoutError
    return left_s
