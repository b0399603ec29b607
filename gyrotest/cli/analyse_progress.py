"""How far an analysis is: a line on a terminal's error stream, nothing elsewhere."""

import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager


class Silence:
    """Says nothing."""

    def reads(self, name: str) -> Callable[[int], None]:
        """Return what is told how many rows of a file have been read."""
        del name
        return _ignored

    def analyses(self, name: str) -> None:
        """Is told that a file has been read and is analysed."""


class Spinner(Silence):
    """Shows which file is read and how many rows so far, then that it is analysed."""

    def __init__(self, show: Callable[[str], None]) -> None:
        self._show = show

    def reads(self, name: str) -> Callable[[int], None]:
        """Return what is told how many rows of a file have been read."""
        self._show(f"{name} …")
        return lambda rows: self._show(f"{name}: {rows:,} rows read".replace(",", "\N{THIN SPACE}"))

    def analyses(self, name: str) -> None:
        """Say that a file is analysed."""
        self._show(f"{name}: Allan deviation and noise model …")


@contextmanager
def watched() -> Iterator[Silence]:
    """Show progress while files are read and analysed."""
    if not sys.stderr.isatty():
        yield Silence()
        return
    from rich.console import Console
    from rich.markup import escape

    with Console(stderr=True).status("") as status:
        yield Spinner(lambda text: status.update(escape(text)))


def _ignored(rows: int) -> None:
    del rows
