"""Where a simulated instrument that sends by itself is plugged in: a TCP port or a pseudo-terminal.

Nothing here waits. What nobody takes in time is lost, as on a serial line.
"""

import contextlib
import os
import select
import socket
import struct
import time
from typing import Protocol

_CHUNK = 65_536
# A pseudo-terminal holds some 20 kB, a connection over the loopback some megabytes.
_PTY_HOLDS = 16_384
_TCP_HOLDS = 1 << 19


class Outlet(Protocol):
    """A line to whoever reads it."""

    @property
    def address(self) -> str:
        """The VISA address of the line's other end."""

    @property
    def room(self) -> int:
        """Bytes that may be sent now: half of what the line holds, less where much is unread; 0 to nobody."""

    @property
    def callers(self) -> int:
        """How many have connected so far; a line that is always there has one."""

    def receive(self) -> bytes:
        """What came from the other end."""

    def wait(self, timeout_s: float) -> None:
        """Return when somebody connects or says something, or after the time."""

    def send(self, data: bytes) -> int:
        """Send what the line takes: so many bytes."""

    def hang_up(self) -> None:
        """Break the connection; another may be made."""

    def unplug(self) -> None:
        """Be gone, without a word."""

    def close(self) -> None:
        """Be gone for good; idempotent."""


class TcpOutlet:
    """A port on 127.0.0.1 with one connection at a time, the last one."""

    def __init__(self, port: int = 0) -> None:
        self._listener: socket.socket | None = socket.create_server(("127.0.0.1", port))
        self._listener.setblocking(False)
        self._address = f"TCPIP::127.0.0.1::{self._listener.getsockname()[1]}::SOCKET"
        self._connection: socket.socket | None = None
        self._callers = 0

    @property
    def address(self) -> str:
        """The VISA address of the line's other end."""
        return self._address

    @property
    def room(self) -> int:
        """Bytes that may be sent now."""
        if self._connection is None:
            return 0
        return max(0, min(_TCP_HOLDS // 2, _TCP_HOLDS - _unsent(self._connection)))

    @property
    def callers(self) -> int:
        """How many have connected so far."""
        return self._callers

    def wait(self, timeout_s: float) -> None:
        """Return when somebody connects or says something, or after the time."""
        lines = [one for one in (self._listener, self._connection) if one is not None]
        try:
            select.select(lines, (), (), timeout_s)
        except (OSError, ValueError):
            # One of them was closed meanwhile.
            time.sleep(timeout_s)

    def receive(self) -> bytes:
        """What came from the other end; a new connection takes the place of the last one."""
        self._accept()
        if self._connection is None:
            return b""
        try:
            data = self._connection.recv(_CHUNK)
        except BlockingIOError:
            return b""
        except OSError:
            data = b""
        if not data:
            self._drop()
        return data

    def _accept(self) -> None:
        if self._listener is None:
            return
        with contextlib.suppress(OSError):
            connection, _ = self._listener.accept()
            self._drop()
            connection.setblocking(False)
            connection.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
            connection.setsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF, _TCP_HOLDS)
            self._connection = connection
            self._callers += 1

    def send(self, data: bytes) -> int:
        """Send what the line takes: so many bytes."""
        if self._connection is None:
            return 0
        try:
            return self._connection.send(data)
        except BlockingIOError:
            return 0
        except OSError:
            self._drop()
            return 0

    def _drop(self) -> None:
        if self._connection is not None:
            self._connection.close()
            self._connection = None

    def hang_up(self) -> None:
        """Break the connection; another is accepted."""
        if self._connection is not None:
            # A broken line, not an orderly end.
            self._connection.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack("ii", 1, 0))
        self._drop()

    def unplug(self) -> None:
        """Be gone: the connection breaks, and none is accepted."""
        self.hang_up()
        self.close()

    def close(self) -> None:
        """Be gone for good; idempotent."""
        self._drop()
        if self._listener is not None:
            self._listener.close()
            self._listener = None


class PtyOutlet:
    """A pseudo-terminal."""

    def __init__(self) -> None:
        # These exist on POSIX only; the door has refused a pty elsewhere.
        import tty

        self._own, self._their = os.openpty()
        tty.setraw(self._their)
        os.set_blocking(self._own, False)
        self._address = f"ASRL{os.ttyname(self._their)}::INSTR"

    @property
    def address(self) -> str:
        """The VISA address of the line's other end."""
        return self._address

    @property
    def room(self) -> int:
        """Bytes that may be sent now."""
        if self._own < 0:
            return 0
        import termios

        # What was sent just before may still be on its way to the reader, on a busy machine.
        return max(0, min(_PTY_HOLDS // 2, _PTY_HOLDS - _asked(self._their, termios.FIONREAD)))

    @property
    def callers(self) -> int:
        """One: the line is always there."""
        return 1

    def wait(self, timeout_s: float) -> None:
        """Return when something is said, or after the time."""
        try:
            select.select([self._own], (), (), timeout_s)
        except (OSError, ValueError):
            # It was closed meanwhile.
            time.sleep(timeout_s)

    def receive(self) -> bytes:
        """What came from the other end."""
        if self._own < 0:
            return b""
        try:
            return os.read(self._own, _CHUNK)
        except OSError:
            return b""

    def send(self, data: bytes) -> int:
        """Send what the line takes: so many bytes."""
        sent = 0
        while sent < len(data) and self._own >= 0:
            try:
                sent += os.write(self._own, data[sent : sent + 4096])
            except OSError:
                break
        return sent

    def hang_up(self) -> None:
        """A terminal has nobody to hang up on but for good."""
        self.close()

    def unplug(self) -> None:
        """Be gone: who reads it is hung up on."""
        self.close()

    def close(self) -> None:
        """Be gone for good; idempotent."""
        if self._own >= 0:
            os.close(self._own)
            os.close(self._their)
            self._own = -1


def _unsent(connection: socket.socket) -> int:
    """Bytes that the other end has not taken yet, where the platform tells."""
    try:
        import termios
    except ImportError:
        return 0
    return _asked(connection.fileno(), termios.TIOCOUTQ)


def _asked(descriptor: int, request: int) -> int:
    """A number that the operating system tells of a line."""
    import fcntl

    told: int = struct.unpack("i", fcntl.ioctl(descriptor, request, b"\0" * 4))[0]
    return told
