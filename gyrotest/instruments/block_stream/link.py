"""The connection to a server of the block protocol: commands and their replies, and blocks as they come."""

from collections import deque
from collections.abc import Callable
from typing import Any, TypeVar

from pydantic import TypeAdapter, ValidationError
from pydantic_core import from_json, to_json

from gyrotest.errors import InstrumentError, InstrumentProtocolError, InstrumentTimeoutError
from gyrotest.instruments.block_stream.messages import HEADER, Messages, Packet, Reply
from gyrotest.instruments.transport.byte_stream import ByteStream
from gyrotest.ports import Clock

# How long bytes that are due may be on their way, in real time, before the clock is let go on.
_ON_THE_WAY_S = 0.2
_LOOK_AGAIN_S = 0.05
_SHOWN = 80

_T = TypeVar("_T")


class Link:
    """One connection. Everything but `close` raises `InstrumentError`, or a subclass that fits."""

    def __init__(self, resource: str, *, clock: Clock, io_timeout_s: float) -> None:
        self._resource = self.who = resource
        self._clock, self._io_timeout_s = clock, io_timeout_s
        self._stream: ByteStream | None = None
        self._arrived: deque[Reply | Packet] = deque()
        self.messages = Messages(resource)

    def name(self, model: str) -> None:
        """Put the model that answered into the messages."""
        self.who = self.messages.who = f"{self._resource} ({model})"

    def attach(self, stream: ByteStream) -> None:
        """Speak over this connection from here on."""
        self.messages.restart()
        self._arrived.clear()
        self._stream = stream

    def close(self) -> None:
        """Disconnect; idempotent, never raises."""
        if self._stream is not None:
            self._stream.close()
            self._stream = None

    def ask(self, command: str, answer: TypeAdapter[_T], **content: Any) -> _T:
        """Send a command, pass over blocks that come before its reply, and check that against its kind."""
        line = command.encode() + (b" " + to_json(content) if content else b"") + b"\n"
        self._io(lambda stream: stream.write(line))
        reply = self._reply(command)
        self._refuse_error(reply, command)
        try:
            return answer.validate_json(reply.line)
        except ValidationError as error:
            first = error.errors(include_url=False)[0]
            where = ".".join(str(one) for one in first["loc"])
            raise InstrumentProtocolError(
                f"{self.who}: {command} gives {_shown(reply.line)}: {where}: {first['msg']}; is this a server"
                " of the block protocol?"
            ) from error

    def packets(self, deadline_s: float, least: int) -> list[Packet]:
        """At least one block, of those that have come by the deadline: `least` bytes are due then."""
        self._clock.sleep_until(deadline_s)
        here = sum(HEADER.size + one.raw.nbytes for one in self._arrived if isinstance(one, Packet))
        self._read(max(0, least - here - self.messages.waiting))
        self._wait("no sample has arrived", self._until_s())
        return self._taken()

    def poll(self, deadline_s: float) -> list[Packet]:
        """The blocks that have come by the deadline, perhaps none."""
        self._clock.sleep_until(deadline_s)
        self._read(0 if self._arrived else 1)
        return self._taken()

    def _taken(self) -> list[Packet]:
        found = []
        while self._arrived:
            message = self._arrived.popleft()
            if isinstance(message, Reply):
                self._refuse_error(message, "the acquisition")
                raise InstrumentProtocolError(
                    f"{self.who}: {_shown(message.line)} arrived without being asked for; is another program"
                    " speaking to it?"
                )
            found.append(message)
        return found

    def _reply(self, command: str) -> Reply:
        until_s = self._until_s()
        while True:
            self._wait(f"no reply to {command}", until_s)
            message = self._arrived.popleft()
            if isinstance(message, Reply):
                return message

    def _until_s(self) -> float:
        return self._clock.now_s() + self._io_timeout_s

    def _wait(self, lacking: str, until_s: float) -> None:
        """Until something has arrived; a clock that is not the real one moves only when it is waited for."""
        if not self._arrived:
            self._read(1)
        while not self._arrived:
            now_s = self._clock.now_s()
            if now_s >= until_s:
                raise InstrumentTimeoutError(
                    f"{self.who}: {lacking} within {self._io_timeout_s:g} s; is it switched on, and does it"
                    " speak the block protocol?"
                )
            self._clock.sleep_until(min(now_s + _LOOK_AGAIN_S, until_s))
            self._read(1)

    def _read(self, least: int) -> None:
        data = self._io(lambda stream: stream.read(least, _ON_THE_WAY_S))
        if data:
            self._arrived += self.messages.push(data)

    def _refuse_error(self, reply: Reply, command: str) -> None:
        try:
            said = from_json(reply.line)
        except ValueError:
            said = None
        if isinstance(said, dict) and "error" in said:
            raise InstrumentError(f"{self.who}: {command}: it says '{said['error']}'")

    def _io(self, act: Callable[[ByteStream], _T]) -> _T:
        if self._stream is None:
            raise InstrumentError(f"{self.who}: not open; open the instrument first")
        try:
            return act(self._stream)
        except OSError as error:
            raise InstrumentError(
                f"{self.who}: connection lost: {error}; look at the cable and the instrument's power"
            ) from error


def _shown(line: bytes) -> str:
    text = line.decode("utf-8", "backslashreplace")
    return repr(text if len(text) <= _SHOWN else f"{text[:_SHOWN]}…")
