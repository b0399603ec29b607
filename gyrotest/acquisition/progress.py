"""What an acquisition tells of itself while it runs."""

from dataclasses import dataclass
from typing import Protocol

from gyrotest.records.recording import Block, Identity, RecordingHeader, Sampling


@dataclass(frozen=True, slots=True, kw_only=True)
class Coming:
    """What is known of an acquisition before it begins."""

    sampling: Sampling
    source: Identity
    samples: int
    steps: int = 1


class Progress(Protocol):
    """Whoever shows the progress: a terminal, or nobody. `prepare` comes before each `begin`."""

    def prepare(self, coming: Coming) -> None:
        """Make ready for an acquisition, also what takes long: nothing waits for it yet."""

    def begin(self, header: RecordingHeader) -> None:
        """An acquisition begins."""

    def push(self, block: Block) -> None:
        """Samples arrived."""

    def note(self, text: str) -> None:
        """Something that the operator should see: warming up, a retry."""

    def end(self) -> None:
        """The acquisition is over, whatever way."""


class Silence:
    """Shows nothing."""

    def prepare(self, coming: Coming) -> None:
        """Show nothing."""

    def begin(self, header: RecordingHeader) -> None:
        """Show nothing."""

    def push(self, block: Block) -> None:
        """Show nothing."""

    def note(self, text: str) -> None:
        """Show nothing."""

    def end(self) -> None:
        """Show nothing."""
