"""A conversation with one instrument: lines, values and blocks over a channel, errors that say who and what."""

import contextlib
import threading

from gyrotest.errors import InstrumentError, InstrumentProtocolError, InstrumentTimeoutError
from gyrotest.instruments.transport.channel import Channel

_SHOWN = 40
_OF_READINGS = frozenset({"READ?", "FETC?", "R?"})


class Conversation:
    """Commands and queries by one owner at a time; `who` begins every message."""

    def __init__(self, resource: str, channel: Channel) -> None:
        self._resource = resource
        self._channel = channel
        self._lock = threading.Lock()
        self.who = resource

    def name(self, model: str) -> None:
        """Put the model that answered into the messages."""
        self.who = f"{self._resource} ({model})"

    @property
    def channel(self) -> Channel:
        """The way to the instrument."""
        return self._channel

    def write(self, command: str) -> None:
        """Send a command; raises `InstrumentError`."""
        with self._lock:
            try:
                self._channel.send(command.encode("ascii") + b"\n")
            except OSError as error:
                raise self._failure(command, 0.0, error) from error

    def query(self, command: str, timeout_s: float) -> str:
        """Ask and return the reply without its line end; raises `InstrumentError`."""
        reply = self.query_line(command.encode("ascii") + b"\n", timeout_s)
        return reply.decode("ascii", "replace").strip()

    def query_line(self, line: bytes, timeout_s: float) -> bytes:
        """Send a query with its line end and return the reply with its own; the fast way."""
        channel = self._channel
        with self._lock:
            try:
                stale = channel.unread()
                if not stale:
                    channel.send(line)
                    return channel.receive_line(timeout_s)
            except OSError as error:
                raise self._failure(line.decode().strip(), timeout_s, error) from error
        raise InstrumentProtocolError(
            f"{self.who}: {shown(stale)} arrived without being asked for, before {line.decode().strip()};"
            " is another program speaking to the instrument?"
        )

    def read_line(self, timeout_s: float) -> str:
        """The next line of a reply; raises `InstrumentError`."""
        with self._lock:
            try:
                return self._channel.receive_line(timeout_s).decode("ascii", "replace").strip()
            except OSError as error:
                raise self._failure("the last query", timeout_s, error) from error

    def query_block(self, command: str, timeout_s: float) -> bytes:
        """Ask and return the content of the definite-length block (IEEE 488.2 8.7.9) in the reply."""
        with self._lock:
            try:
                self._channel.send(command.encode("ascii") + b"\n")
                return self._receive_block(command, timeout_s)
            except OSError as error:
                raise self._failure(command, timeout_s, error) from error

    def clear(self) -> None:
        """Clear the instrument's interface; some refuse, and then *IDN? tells how it stands."""
        with self._lock, contextlib.suppress(OSError):
            self._channel.clear()

    def close(self) -> None:
        """Give the front panel back and disconnect; never raises."""
        with self._lock:
            with contextlib.suppress(OSError):
                self._channel.go_to_local()
            self._channel.close()

    def _receive_block(self, command: str, timeout_s: float) -> bytes:
        head = self._channel.receive_exactly(2, timeout_s)
        if head[:1] != b"#" or head[1:] not in b"123456789":
            raise self._no_block(command, head + self._channel.receive_line(timeout_s))
        length = self._channel.receive_exactly(int(head[1:]), timeout_s)
        if not length.isdigit():
            raise self._no_block(command, head + length)
        content = self._channel.receive_exactly(int(length), timeout_s)
        self._channel.receive_line(timeout_s)
        return content

    def _no_block(self, command: str, found: bytes) -> InstrumentProtocolError:
        return InstrumentProtocolError(
            f"{self.who}: the reply to {command} begins {shown(found)}, expected a binary block '#…'"
        )

    def _failure(self, command: str, timeout_s: float, error: OSError) -> InstrumentError:
        if isinstance(error, TimeoutError):
            hint = "is its trigger source IMM?" if command in _OF_READINGS else "is its address right?"
            return InstrumentTimeoutError(
                f"{self.who}: no reply to {command} within {timeout_s:.3g} s; is it switched on, and {hint}"
            )
        return InstrumentError(
            f"{self.who}: connection lost at {command} ({error}); look at the cable and the instrument's power"
        )


def shown(data: bytes) -> str:
    """The beginning of a reply, as it is shown in a message."""
    text = data.decode("ascii", "backslashreplace").strip()
    return repr(text if len(text) <= _SHOWN else text[:_SHOWN] + "…")
