"""Ways to an instrument that break when they are told to."""

from collections.abc import Callable

from gyrotest.errors import InstrumentError
from gyrotest.instruments.transport.channel import Channel, SerialLine

Open = Callable[[str, SerialLine, float], Channel]


class Cut:
    """Opens ways by `opened`, and breaks those that are open; `later`: those opened afterwards too."""

    def __init__(self, opened: Open) -> None:
        self.later = False
        self.broken: set[int] = set()
        self.count = 0
        self._opened = opened

    def cut(self, *, later: bool) -> None:
        self.broken = set(range(self.count + 1))
        self.later = later

    def connect(self, resource: str, line: SerialLine, timeout_s: float) -> Channel:
        if self.later:
            raise InstrumentError(f"{resource}: cannot be opened")
        self.count += 1
        number = self.count
        channel = self._opened(resource, line, timeout_s)
        send = channel.send

        def send_or_break(data: bytes) -> None:
            if number in self.broken:
                raise ConnectionResetError("reset by peer")
            send(data)

        channel.send = send_or_break  # type: ignore[method-assign]
        return channel
