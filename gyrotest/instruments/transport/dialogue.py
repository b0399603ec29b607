"""A scripted channel for the tests of drivers: what must be sent, and what is answered."""

from collections.abc import Sequence

from gyrotest.errors import InstrumentError
from gyrotest.instruments.transport.channel import SerialLine

Turn = tuple[bytes, bytes | OSError | None]


class DialogueError(AssertionError):
    """The driver said something else than the script, or left something over."""


class Dialogue:
    """A channel that plays pairs of (sent, reply), line ends included.

    The reply is None where a command has none, or the error that the wire answers with (`TimeoutError()`).
    A context: at its end nothing may be left over. `closed` and `cleared` count the calls.
    """

    def __init__(
        self,
        turns: Sequence[Turn],
        *,
        seconds_per_byte: float = 0.0,
        longest_wait_s: float | None = None,
        remote_by_command: bool = False,
    ) -> None:
        self.seconds_per_byte = seconds_per_byte
        self.longest_wait_s = longest_wait_s
        self.remote_by_command = remote_by_command
        self.closed = 0
        self.cleared = 0
        self.opened = 0
        self._turns = list(turns)
        self._replies = bytearray()
        self._fault: OSError | None = None

    def connect(self, resource: str, line: SerialLine, timeout_s: float) -> "Dialogue":
        """Stand in for the opening of a resource."""
        if not resource or timeout_s <= 0 or line.baud_rate <= 0:
            raise InstrumentError(f"{resource}: cannot be opened")
        self.opened += 1
        return self

    def __enter__(self) -> "Dialogue":
        return self

    def __exit__(self, kind: object, error: object, trace: object) -> None:
        if kind is None:
            self.finish()

    def finish(self) -> None:
        """Raise if anything of the script is left over."""
        if self._turns or self._replies:
            raise DialogueError(f"left over: {self._turns!r}, unread {bytes(self._replies)!r}")

    def unread(self) -> bytes:
        """Replies of the script that nobody read."""
        return bytes(self._replies)

    def send(self, data: bytes) -> None:
        """Compare with the script's next line and take its reply up."""
        if not self._turns:
            raise DialogueError(f"the script has ended, but {data!r} was sent")
        expected, reply = self._turns.pop(0)
        if data != expected:
            raise DialogueError(f"{data!r} was sent, the script says {expected!r}")
        self._fault = reply if isinstance(reply, OSError) else None
        self._replies += b"" if reply is None or isinstance(reply, OSError) else reply

    def receive_line(self, timeout_s: float) -> bytes:  # noqa: ARG002 - nothing is waited for
        """The reply's next line; a time-out where there is none."""
        self._raise_fault()
        end = self._replies.find(b"\n") + 1
        if not end:
            raise TimeoutError
        return self._take(end)

    def receive_exactly(self, count: int, timeout_s: float) -> bytes:  # noqa: ARG002 - as above
        """That many bytes of the reply; a time-out where there are fewer."""
        self._raise_fault()
        if len(self._replies) < count:
            raise TimeoutError
        return self._take(count)

    def clear(self) -> None:
        """Forget what was not read."""
        self._replies.clear()
        self.cleared += 1

    def go_to_local(self) -> None:
        """Nothing."""

    def close(self) -> None:
        """Count."""
        self.closed += 1

    def _raise_fault(self) -> None:
        if self._fault is not None:
            fault, self._fault = self._fault, None
            raise fault

    def _take(self, count: int) -> bytes:
        data = bytes(self._replies[:count])
        del self._replies[:count]
        return data
