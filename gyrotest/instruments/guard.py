"""A process of its own that stops a rate table when the process that turned it is gone.

It knows the standard library only (and pyserial for a serial line), so that it is ready at once. It
holds a pipe from the run: when that closes without the word that all is well, the run was killed, and
the controller is told to stop over a connection of the guard's own.
"""

import contextlib
import json
import signal
import socket
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from dataclasses import asdict, dataclass
from typing import Any

_MODULE = "gyrotest.instruments.guard"
_ALL_IS_WELL = b"well\n"
# A controller frees a connection, and the kernel a line, some time after the process is gone.
_PATIENCE_S = 10.0
_PAUSE_S = 0.25
_CONNECT_S = 2.0
_REPLY_S = 0.3
_WAIT_AT_EXIT_S = _PATIENCE_S + 5.0


@dataclass(frozen=True, slots=True, kw_only=True)
class Orders:
    """Where the controller is, and what stops it: lines with their ends, sent one after the other.

    `host` and `port`, or the `device` of a serial line with its `baud_rate`.
    """

    commands: tuple[str, ...]
    host: str = ""
    port: int = 0
    device: str = ""
    baud_rate: int = 9600


class Guard:
    """The guard of one table, from `start` on until `release`."""

    def __init__(self, orders: Orders) -> None:
        self._orders = orders
        self._process: subprocess.Popen[bytes] | None = None

    def start(self) -> None:
        """Begin to watch over this process; returns at once. Raises `OSError`."""
        if self._process is not None and self._process.poll() is None:
            return
        self._process = subprocess.Popen(  # noqa: S603 - this very module
            # Nothing of the folder that the run was started in is imported.
            (sys.executable, "-P", "-m", _MODULE),
            stdin=subprocess.PIPE,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
            # What kills the run's group of processes, a Ctrl-C among it, does not reach the guard.
            start_new_session=True,
        )
        self._tell(json.dumps(asdict(self._orders)).encode() + b"\n")

    def release(self) -> None:
        """The table is at rest: the guard is not needed any more. Never raises."""
        self._tell(_ALL_IS_WELL)
        self.call()

    def call(self) -> None:
        """Let the guard stop the table now, since it is not known whether it rests. Never raises."""
        if self._process is None:
            return
        with contextlib.suppress(OSError):
            if self._process.stdin is not None:
                self._process.stdin.close()
        with contextlib.suppress(subprocess.TimeoutExpired):
            self._process.wait(_WAIT_AT_EXIT_S)
        self._process = None

    def _tell(self, line: bytes) -> None:
        if self._process is not None and self._process.stdin is not None:
            with contextlib.suppress(OSError):
                self._process.stdin.write(line)
                self._process.stdin.flush()


def watch() -> None:
    """Wait for the end of the run, and stop the table if it came without a word."""
    for number in (signal.SIGINT, signal.SIGTERM, getattr(signal, "SIGHUP", signal.SIGTERM)):
        signal.signal(number, signal.SIG_IGN)
    lines = sys.stdin.buffer.readlines()
    if _ALL_IS_WELL in lines or not lines:
        return
    given = json.loads(lines[0])
    stop_table(Orders(**{**given, "commands": tuple(given["commands"])}))


def stop_table(orders: Orders) -> bool:
    """Send the commands; whether they could be sent. The controller may be gone with the run."""
    deadline_s = time.monotonic() + (0.0 if _gone_with_its_server(orders) else _PATIENCE_S)
    while True:
        with contextlib.suppress(OSError):
            with _connected(orders) as send:
                for command in orders.commands:
                    send(command.encode("ascii"))
            return True
        if time.monotonic() > deadline_s:
            return False
        time.sleep(_PAUSE_S)


def _gone_with_its_server(orders: Orders) -> bool:
    """Whether the address means nothing, or something else, once it does not answer: a simulated one."""
    return orders.host.startswith("127.") or orders.device.startswith("/dev/pts/")


@contextlib.contextmanager
def _connected(orders: Orders) -> Iterator[Callable[[bytes], None]]:
    """A way to send a command and leave it the time of a reply."""
    if orders.device:
        with _line(orders) as line:
            # The end of a line first: the run may have been killed in the middle of a command.
            line.write(orders.commands[0][-1:].encode("ascii"))

            def over_line(command: bytes) -> None:
                line.write(command)
                line.read(64)

            yield over_line
        return
    with socket.create_connection((orders.host, orders.port), _CONNECT_S) as connection:
        connection.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        connection.settimeout(_REPLY_S)

        def over_network(command: bytes) -> None:
            connection.sendall(command)
            with contextlib.suppress(TimeoutError):
                connection.recv(64)

        yield over_network


def _line(orders: Orders) -> Any:
    import serial

    return serial.serial_for_url(orders.device, baudrate=orders.baud_rate, timeout=_REPLY_S)


if __name__ == "__main__":
    watch()
