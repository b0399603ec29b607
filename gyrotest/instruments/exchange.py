"""Commands and replies of a motion controller: each command is answered before the next one is sent."""

import contextlib
import threading
from collections.abc import Iterator

from gyrotest.errors import InstrumentError, InstrumentProtocolError, InstrumentTimeoutError
from gyrotest.instruments.transport.channel import Channel, Connect, SerialLine
from gyrotest.instruments.transport.conversation import shown

OPEN_TIMEOUT_S = 3.0
REPLY_TIMEOUT_S = 2.0
# A reply without an end of its own is over when nothing more has come for so long.
_QUIET_S = 0.02
_INSISTING_S = 0.1
_LONGEST_REPLY = 4096


class Exchange:
    """The way to one controller; `who` begins every message. Its methods raise `InstrumentError`."""

    def __init__(
        self, resource: str, line: SerialLine, *, connect: Connect, io_timeout_s: float | None
    ) -> None:
        self._resource = resource
        self._line = line
        self._connect = connect
        self._channel: Channel | None = None
        # `stop` may come from another thread, and in the middle of an exchange of the same one.
        self._lock = threading.RLock()
        self._timeout_s = REPLY_TIMEOUT_S if io_timeout_s is None else io_timeout_s
        self._open_timeout_s = OPEN_TIMEOUT_S if io_timeout_s is None else io_timeout_s
        self.who = resource

    @property
    def is_open(self) -> bool:
        """Whether there is a connection."""
        return self._channel is not None

    def open(self) -> None:
        """Connect."""
        self.close()
        self._channel = self._connect(self._resource, self._line, self._open_timeout_s)

    def name(self, model: str) -> None:
        """Put the model that answered into the messages."""
        self.who = f"{self._resource} ({model})"

    def close(self) -> None:
        """Disconnect; never raises."""
        with self._lock:
            channel, self._channel = self._channel, None
            if channel is not None:
                with contextlib.suppress(OSError):
                    channel.close()

    def forget(self) -> None:
        """Drop late replies, so that they are not taken for the answer to what is sent next; never raises."""
        with self._lock, contextlib.suppress(OSError):
            if self._channel is not None and (stale := self._channel.unread()):
                self._channel.receive_exactly(len(stale), self._timeout_s)

    def insist(self, command: str, end: bytes) -> None:
        """Send whatever else is on the line, and drop all that comes of it; never raises."""
        with self._lock, contextlib.suppress(OSError, InstrumentError):
            self._connected().send(command.encode("ascii") + end)
            for _ in range(_LONGEST_REPLY):
                self._connected().receive_exactly(1, _INSISTING_S)

    def send(self, command: str, end: bytes) -> None:
        """Send a command to which there is no answer."""
        with self._lock, self._told(command):
            self._connected().send(command.encode("ascii") + end)

    def until(self, command: str, end: bytes, *, reply_end: bytes) -> bytes:
        """Send, and return the reply up to and including its end."""
        with self._lock, self._told(command):
            self._send_after_silence(command, end)
            reply = bytearray()
            while not reply.endswith(reply_end):
                reply += self._connected().receive_exactly(1, self._timeout_s)
                self._refuse_endless(command, reply)
            return bytes(reply)

    def packet(self, command: str, end: bytes, *, least: int, whole: bytes) -> bytes:
        """Send, and return a reply of so many bytes or more, which has no end of its own.

        A reply that ends with `whole`, or with a line feed, is known to be complete.
        """
        with self._lock, self._told(command):
            self._send_after_silence(command, end)
            channel = self._connected()
            reply = bytearray(channel.receive_exactly(least, self._timeout_s))
            with contextlib.suppress(TimeoutError):
                while not reply.endswith((b"\n", whole)):
                    reply += channel.receive_exactly(1, _QUIET_S)
                    self._refuse_endless(command, reply)
            return bytes(reply)

    def _send_after_silence(self, command: str, end: bytes) -> None:
        channel = self._connected()
        stale = channel.unread()
        if stale.strip():
            channel.clear()
            raise InstrumentProtocolError(
                f"{self.who}: {shown(stale)} arrived without being asked for, before {command};"
                " is another program speaking to the controller?"
            )
        if stale:
            channel.receive_exactly(len(stale), self._timeout_s)
        channel.send(command.encode("ascii") + end)

    def _refuse_endless(self, command: str, reply: bytearray) -> None:
        if len(reply) > _LONGEST_REPLY:
            raise InstrumentProtocolError(
                f"{self.who}: the reply to {command} begins {shown(bytes(reply))} and has no end;"
                " is this the controller, and is its baud rate right?"
            )

    def _connected(self) -> Channel:
        if self._channel is None:
            raise InstrumentError(f"{self.who}: not open; open the rate table first")
        return self._channel

    @contextlib.contextmanager
    def _told(self, command: str) -> Iterator[None]:
        try:
            yield
        except TimeoutError as error:
            raise InstrumentTimeoutError(
                f"{self.who}: no reply to {command} within {self._timeout_s:g} s; is the controller switched on,"
                " and are its address and the settings of the line right?"
            ) from error
        except OSError as error:
            raise InstrumentError(
                f"{self.who}: connection lost at {command} ({error}); see that the table is at rest, then look"
                " at the cable and the controller's power"
            ) from error
