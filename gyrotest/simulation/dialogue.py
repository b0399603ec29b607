"""What a byte stream means to a meter: lines in, replies out."""

from collections.abc import Iterable, Iterator
from typing import Protocol

from gyrotest.simulation.meter import Meter
from gyrotest.simulation.meter_state import Interface

# Replies on their way: when each part is ready, s, and its bytes.
Parts = Iterable[tuple[float, bytes]]

_LONGEST_MESSAGE = 1 << 20
_DEVICE_CLEAR = b"\x03"


class Dialogue(Protocol):
    """One connection's side of the conversation."""

    def receive(self, data: bytes) -> Parts:
        """Take bytes as they come; the replies, each to be sent when it is ready."""


class LineDialogue:
    """SCPI over a socket or a serial line: a message ends with a line feed."""

    def __init__(self, meter: Meter, interface: Interface) -> None:
        self._meter = meter
        self._interface = interface
        self._rest = b""

    def receive(self, data: bytes) -> Parts:
        """Carry out every complete message; may raise `HangUp`."""
        if self._interface is Interface.SERIAL and _DEVICE_CLEAR in data:
            self._meter.clear()
            self._rest = b""
            data = data[data.rindex(_DEVICE_CLEAR) + 1 :]
        # Almost always one whole message at a time.
        if not self._rest and data.find(b"\n") == len(data) - 1:
            reply = (
                self._meter.execute(data.decode("latin-1").strip(), self._interface) if data else None
            )
            return () if reply is None else reply.parts
        return self._several(data)

    def _several(self, data: bytes) -> Iterator[tuple[float, bytes]]:
        *messages, self._rest = (self._rest + data).split(b"\n")
        self._rest = self._rest[:_LONGEST_MESSAGE]
        for message in messages:
            reply = self._meter.execute(message.decode("latin-1").strip(), self._interface)
            if reply is not None:
                yield from reply.parts
