"""How far the reading is: a line on a terminal's error stream, nothing elsewhere."""

import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager


def _ignored(rows: int) -> None:
    del rows


class Silence:
    """Says nothing."""

    def reads(self, name: str) -> Callable[[int], None]:
        """Return what is told the rows of a file as they are read."""
        del name
        return _ignored


class Spinner(Silence):
    """Shows what is read, and how many rows so far."""

    def __init__(self, show: Callable[[str], None]) -> None:
        self._show = show

    def reads(self, name: str) -> Callable[[int], None]:
        """Return what is told the rows of a file as they are read."""
        self._show(f"{name} …")
        return lambda rows: self._show(f"{name}: {rows:,} rows read".replace(",", "\N{THIN SPACE}"))


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
