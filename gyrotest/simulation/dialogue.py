"""What a byte stream means to an instrument: lines in, replies out."""

from collections.abc import Iterable, Iterator
from typing import Protocol

from gyrotest.simulation.meter_state import Interface, Reply

# Replies on their way: when each part is ready, s, and its bytes.
Parts = Iterable[tuple[float, bytes]]

_LONGEST_MESSAGE = 1 << 20
_DEVICE_CLEAR = b"\x03"


class Dialogue(Protocol):
    """One connection's side of the conversation."""

    def receive(self, data: bytes) -> Parts:
        """Take bytes as they come; the replies, each to be sent when it is ready."""


class Speaker(Protocol):
    """An instrument that takes program messages."""

    def execute(self, message: str, interface: Interface) -> Reply | None:
        """Carry out a message; the reply, if there is one. May raise `HangUp`."""

    def clear(self) -> None:
        """Device clear: stop what is under way."""

    def refuse(self, code: int) -> None:
        """Put an error into the queue."""

    def status_byte(self) -> int:
        """The status byte of IEEE 488.2."""


class LineDialogue:
    """SCPI over a socket or a serial line: a message ends with a line feed."""

    def __init__(self, instrument: Speaker, interface: Interface) -> None:
        self._instrument = instrument
        self._interface = interface
        self._rest = b""

    def receive(self, data: bytes) -> Parts:
        """Carry out every complete message; may raise `HangUp`."""
        if self._interface is Interface.SERIAL and _DEVICE_CLEAR in data:
            self._instrument.clear()
            self._rest = b""
            data = data[data.rindex(_DEVICE_CLEAR) + 1 :]
        # Almost always one whole message at a time.
        if not self._rest and data.find(b"\n") == len(data) - 1:
            reply = (
                self._instrument.execute(data.decode("latin-1").strip(), self._interface)
                if data
                else None
            )
            return () if reply is None else reply.parts
        return self._several(data)

    def _several(self, data: bytes) -> Iterator[tuple[float, bytes]]:
        *messages, self._rest = (self._rest + data).split(b"\n")
        self._rest = self._rest[:_LONGEST_MESSAGE]
        for message in messages:
            reply = self._instrument.execute(message.decode("latin-1").strip(), self._interface)
            if reply is not None:
                yield from reply.parts
