"""Servers that put a dialogue behind a TCP port or a pseudo-terminal, each in its own threads."""

import contextlib
import os
import select
import socket
import threading
from collections.abc import Callable
from types import TracebackType
from typing import Protocol, Self

from gyrotest.ports import Clock
from gyrotest.simulation.dialogue import Dialogue
from gyrotest.simulation.meter_state import HangUp

_CHUNK = 65_536
_JOIN_S = 1.0


class Server(Protocol):
    """A server that is running until it is closed."""

    def close(self) -> None:
        """Stop; idempotent."""


class TcpServer:
    """Serves a dialogue on 127.0.0.1; every connection begins a dialogue of its own.

    What stands behind answers one connection at a time.
    """

    def __init__(self, dialogue: Callable[[], Dialogue], clock: Clock, *, port: int = 0) -> None:
        self._dialogue = dialogue
        self._clock = clock
        self._listener = socket.create_server(("127.0.0.1", port))
        self.port: int = self._listener.getsockname()[1]
        self._lock = threading.Lock()
        self._talking = threading.Lock()
        self._connections: set[socket.socket] = set()
        self._threads: set[threading.Thread] = set()
        self._closed = False
        self._start(self._accept)

    def _start(self, target: Callable[..., None], *arguments: object) -> None:
        thread = threading.Thread(
            target=target, args=arguments, daemon=True, name=f"simulated-{self.port}"
        )
        with self._lock:
            self._threads = {one for one in self._threads if one.is_alive()} | {thread}
            # Started within the lock, so that nobody sees it not yet alive and forgets it.
            thread.start()

    def _accept(self) -> None:
        while True:
            try:
                connection, _ = self._listener.accept()
            except OSError:
                return
            connection.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
            with self._lock:
                if self._closed:
                    connection.close()
                    return
                self._connections.add(connection)
            self._start(self._converse, connection)

    def _converse(self, connection: socket.socket) -> None:
        receive = self._dialogue().receive
        sleep_until = self._clock.sleep_until
        with contextlib.suppress(OSError, HangUp), connection:
            while data := connection.recv(_CHUNK):
                with self._talking:
                    for ready_s, part in receive(data):
                        sleep_until(ready_s)
                        connection.sendall(part)
        with self._lock:
            self._connections.discard(connection)

    def close(self) -> None:
        """Close the port and every connection; idempotent."""
        with self._lock:
            self._closed = True
            connections, threads = tuple(self._connections), tuple(self._threads)
        for one in (self._listener, *connections):
            # A blocked accept or recv only notices a shutdown, not a close.
            with contextlib.suppress(OSError):
                one.shutdown(socket.SHUT_RDWR)
        self._listener.close()
        for thread in threads:
            thread.join(_JOIN_S)

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()


class PtyServer:
    """Serves a dialogue on a pseudo-terminal; `path` is what a program opens as serial port."""

    def __init__(self, dialogue: Callable[[], Dialogue], clock: Clock) -> None:
        # These exist on POSIX only; the door has refused a pty elsewhere.
        import tty

        self._dialogue = dialogue()
        self._clock = clock
        self._own, self._their = os.openpty()
        tty.setraw(self._their)
        self.path = os.ttyname(self._their)
        # A byte in this pipe wakes the thread up to end.
        self._wake_read, self._wake_write = os.pipe()
        self._thread = threading.Thread(
            target=self._converse, daemon=True, name=f"simulated-{self.path}"
        )
        self._thread.start()

    def _converse(self) -> None:
        while True:
            readable, _, _ = select.select([self._own, self._wake_read], [], [])
            if self._wake_read in readable:
                return
            data = os.read(self._own, _CHUNK)
            with contextlib.suppress(HangUp):
                for ready_s, part in self._dialogue.receive(data):
                    self._clock.sleep_until(ready_s)
                    if not self._send(part):
                        return

    def _send(self, part: bytes) -> bool:
        """Write all of it, or as much as is taken before `close`."""
        while part:
            readable, _, _ = select.select([self._wake_read], [self._own], [])
            if readable:
                return False
            # In small pieces: a terminal takes some kilobytes and would then block.
            part = part[os.write(self._own, part[:1024]) :]
        return True

    def close(self) -> None:
        """Close the pseudo-terminal; idempotent."""
        if self._wake_write < 0:
            return
        os.write(self._wake_write, b"\0")
        self._thread.join(_JOIN_S)
        for descriptor in (self._own, self._their, self._wake_read, self._wake_write):
            os.close(descriptor)
        self._wake_write = -1

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()


def has_pty() -> bool:
    """Whether this platform has pseudo-terminals."""
    return hasattr(os, "openpty")
