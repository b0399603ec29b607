"""What an acquisition tells of itself while it runs."""

from typing import Protocol

from gyrotest.records.recording import Block, RecordingHeader


class Progress(Protocol):
    """Whoever shows the progress: a terminal, or nobody."""

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

    def begin(self, header: RecordingHeader) -> None:
        """Show nothing."""

    def push(self, block: Block) -> None:
        """Show nothing."""

    def note(self, text: str) -> None:
        """Show nothing."""

    def end(self) -> None:
        """Show nothing."""
