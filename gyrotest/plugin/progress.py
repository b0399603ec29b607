"""Progress on the operator's screen: the reading, how far, how long, and a running trace.

It goes to a duplicate of the real standard output: pytest's capture holds whatever an item writes.
"""

import os
import sys
import time
from collections import deque
from typing import IO, TYPE_CHECKING

import pytest

from gyrotest.acquisition.progress import Progress, Silence
from gyrotest.records.recording import Block, RecordingHeader
from gyrotest.records.spec import Output, OutputKind

if TYPE_CHECKING:
    from rich.console import Console
    from rich.live import Live
    from rich.text import Text

_BARS = "▁▂▃▄▅▆▇█"
_TRACE = 60
_LINE_EVERY_S = 60.0
_REFRESH_S = 0.1


def progress_for(config: pytest.Config, output: Output) -> Progress:
    """The progress that fits the session: none for workers and `-q`, lines where there is no terminal."""
    if hasattr(config, "workerinput") or config.get_verbosity() < 0:
        return Silence()
    if sys.__stdout__ is None:
        return Silence()
    stream = os.fdopen(os.dup(sys.__stdout__.fileno()), "w", encoding="utf-8", errors="replace")
    config.add_cleanup(stream.close)
    reading = Reading(output)
    return LiveProgress(stream, reading) if stream.isatty() else LineProgress(stream, reading)


class Reading:
    """An indication as the operator reads it: in the source's unit and as a rate."""

    def __init__(self, output: Output) -> None:
        voltage = output.kind is OutputKind.VOLTAGE
        self._scale = output.scale_factor.to("V*s/deg") if voltage and output.scale_factor else None
        self._zero = output.zero_rate.to("V") if voltage and output.zero_rate else 0.0

    def __call__(self, value: float, unit: str) -> str:
        """The text, `2.512345 V = +0.2469 °/s`."""
        if unit != "V" or self._scale is None:
            return f"{value:+.4f} {unit.replace('deg', '°')}"
        return f"{value:.6f} V = {(value - self._zero) / self._scale:+.4f} °/s"


class LineProgress:
    """A line now and then, for logs and pipes; each on a line of its own, between pytest's."""

    def __init__(self, stream: IO[str], reading: Reading) -> None:
        self._stream = stream
        self._reading = reading
        self._header: RecordingHeader | None = None
        self._written = 0.0
        self._among_pytests = True

    def begin(self, header: RecordingHeader) -> None:
        """An acquisition begins."""
        self._header = header
        self._written = time.monotonic()
        self.note(
            f"{header.item}: {header.planned_samples} samples every {header.sampling.interval_s:g} s"
        )

    def push(self, block: Block) -> None:
        """Say how far it is, once a minute."""
        if self._header is None or time.monotonic() - self._written < _LINE_EVERY_S:
            return
        self._written = time.monotonic()
        done = block.first + len(block.flags)
        shown = self._reading(float(block.values[-1, 0]), self._header.sampling.unit)
        self.note(f"{self._header.item}: {done} of {self._header.planned_samples}, {shown}")

    def note(self, text: str) -> None:
        """Write a line."""
        before = "\n" if self._among_pytests else ""
        self._stream.write(f"{before}{text}\n")
        self._stream.flush()
        self._among_pytests = False

    def end(self) -> None:
        """The acquisition is over; pytest goes on with its own line."""
        self._header = None
        self._among_pytests = True


class LiveProgress:
    """A few lines at the foot of the terminal, redrawn in place."""

    def __init__(self, stream: IO[str], reading: Reading) -> None:
        self._stream = stream
        self._reading = reading
        self._header: RecordingHeader | None = None
        self._live: Live | None = None
        self._note = ""
        self._trace: deque[float] = deque(maxlen=_TRACE)
        self._drawn = 0.0

    def begin(self, header: RecordingHeader) -> None:
        """An acquisition begins."""
        from rich.live import Live

        self._header = header
        self._trace.clear()
        self._note = ""
        console = self._console()
        console.print()
        self._live = Live(console=console, auto_refresh=False, transient=True)
        self._live.start()

    def push(self, block: Block) -> None:
        """Take the reading; redraw a few times a second."""
        self._trace.extend(block.values[-_TRACE:, 0].tolist())
        now = time.monotonic()
        if self._live is None or now - self._drawn < _REFRESH_S:
            return
        self._drawn = now
        self._live.update(self._screen(block), refresh=True)

    def note(self, text: str) -> None:
        """Show a remark, above the reading while an acquisition runs."""
        self._note = text
        if self._live is None:
            self._console().print(f"\n{text}", markup=False, highlight=False, end="")

    def end(self) -> None:
        """The acquisition is over: leave the screen to pytest."""
        if self._live is not None:
            self._live.stop()
            self._live = None

    def _console(self) -> "Console":
        from rich.console import Console

        return Console(file=self._stream, force_terminal=True)

    def _screen(self, block: Block) -> "Text":
        from rich.text import Text

        header = self._header
        if header is None:
            return Text()
        done, total = block.first + len(block.flags), header.planned_samples
        interval_s = header.sampling.interval_s
        lines = Text(no_wrap=True, overflow="ellipsis")
        lines.append(f"{header.item}  ", style="bold")
        lines.append(
            f"{self._reading(float(block.values[-1, 0]), header.sampling.unit)}\n", style="cyan"
        )
        lines.append(f"{_bar(done, total)} {done} of {total}")
        lines.append(
            f"  {_clock(done * interval_s)} elapsed, {_clock((total - done) * interval_s)} to go\n"
        )
        lines.append(_sparkline(self._trace), style="blue")
        if self._note:
            lines.append(f"\n{self._note}", style="yellow")
        return lines


def _bar(done: int, total: int, width: int = 30) -> str:
    full = width * done // total
    return "━" * full + "╌" * (width - full)


def _clock(seconds: float) -> str:
    minutes, second = divmod(round(seconds), 60)
    hour, minute = divmod(minutes, 60)
    return f"{hour}:{minute:02d}:{second:02d}"


def _sparkline(values: deque[float]) -> str:
    low, high = min(values), max(values)
    span = (high - low) or 1.0
    return "".join(_BARS[min(7, int(8 * (one - low) / span))] for one in values)
