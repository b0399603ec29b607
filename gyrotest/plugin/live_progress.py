"""Progress on a terminal: the reading, how far, a running trace and a growing Allan deviation."""

import math
import os
import shutil
import time
from collections import deque
from typing import IO, TYPE_CHECKING

from gyrotest.acquisition.progress import Coming
from gyrotest.plugin.reading import Reading
from gyrotest.records.recording import Block, RecordingHeader, Sampling

if TYPE_CHECKING:
    from rich.console import Console
    from rich.live import Live
    from rich.text import Text

    from gyrotest.plugin.running_allan import RunningAllan

_BARS = "▁▂▃▄▅▆▇█"
_TRACE = 60
_BAR = 30
_REFRESH_S = 0.25
_PREPARING = "preparing the running Allan deviation (the first time on a machine: some seconds) …"
_SPARE_LINES = 2  # of the terminal, below and above what is redrawn


class LiveProgress:
    """A few lines at the foot of the terminal, redrawn in place."""

    def __init__(self, stream: IO[str], reading: Reading) -> None:
        self._stream = stream
        self._reading = reading
        self._header: RecordingHeader | None = None
        self._allan: RunningAllan | None = None
        self._live: Live | None = None
        self._note = ""
        self._trace: deque[float] = deque(maxlen=_TRACE)
        self._last: Block | None = None
        self._drawn_s = 0.0
        self._on_free_line = False

    def prepare(self, coming: Coming) -> None:
        """Load and compile what is drawn, and say so: the first time on a machine it takes long."""
        self._stream.write("\n")
        self._on_free_line = True
        # Of steps at different rates an Allan deviation says nothing.
        self._allan = self._running_allan(coming.sampling) if coming.steps == 1 else None

    def begin(self, header: RecordingHeader) -> None:
        """An acquisition begins."""
        self._header = header
        self._trace.clear()
        self._note = ""
        self._last = None
        self._to_free_line()
        self._on_free_line = False  # what is drawn now is there
        self._start()
        self._draw()  # the axes, before the first sample comes

    def push(self, block: Block) -> None:
        """Take the reading; redraw a few times a second."""
        self._trace.extend(filter(math.isfinite, block.values[-_TRACE:, 0].tolist()))
        if self._allan is not None:
            self._allan.push(block)
        self._last = block
        now_s = time.monotonic()
        if now_s - self._drawn_s >= _REFRESH_S:
            self._drawn_s = now_s
            self._draw()

    def note(self, text: str) -> None:
        """Show a remark, above the reading while an acquisition runs."""
        self._note = text
        if self._live is None:
            self._to_free_line()
            self._console().print(text, markup=False, highlight=False, end="")
            self._on_free_line = False

    def end(self) -> None:
        """The acquisition is over: draw all of it once more, and leave the screen to pytest."""
        try:
            self._draw()
        finally:
            live, self._live, self._allan, self._last = self._live, None, None, None
            if live is not None:
                live.stop()

    def _to_free_line(self) -> None:
        if not self._on_free_line:
            self._stream.write("\n")
            self._stream.flush()
        self._on_free_line = True

    def _running_allan(self, sampling: Sampling) -> "RunningAllan | None":
        dps_per_unit = self._reading.dps_per(sampling.unit)
        if dps_per_unit is None:
            return None
        self._stream.write(f"{_PREPARING}"[: self._size().columns - 1])
        self._stream.flush()
        try:
            from gyrotest.plugin.running_allan import RunningAllan

            return RunningAllan(sampling, dps_per_unit=dps_per_unit)
        finally:
            self._stream.write("\r\x1b[2K")
            self._stream.flush()

    def _size(self) -> os.terminal_size:
        """Look at the terminal itself: pytest's capture holds the streams that rich would ask."""
        try:
            size = os.get_terminal_size(self._stream.fileno())
        except (OSError, ValueError):  # Windows knows the size of its standard streams only
            size = shutil.get_terminal_size()
        return size if size.columns and size.lines else os.terminal_size((80, 24))

    def _console(self) -> "Console":
        from rich.console import Console

        size = self._size()
        return Console(file=self._stream, force_terminal=True, width=size.columns, height=size.lines)

    def _start(self) -> None:
        from rich.live import Live

        self._live = Live(console=self._console(), auto_refresh=False, transient=True)
        self._live.start()

    def _draw(self) -> None:
        if self._live is None or self._header is None:
            return
        size = self._size()
        if tuple(self._live.console.size) != tuple(size):
            # What was drawn is wrapped by now: begin on an empty screen.
            self._live.stop()
            self._live.console.clear()
            self._start()
        self._live.update(self._screen(self._header, size), refresh=True)

    def _screen(self, header: RecordingHeader, size: os.terminal_size) -> "Text":
        from rich.text import Text

        lines = Text(no_wrap=True, overflow="ellipsis")
        lines.append(f"{header.item}  ", style="bold")
        lines.append(f"{self._indication(header)}\n", style="cyan")
        lines.append(f"{self._how_far(header, size.columns)}\n")
        lines.append(_sparkline(self._trace), style="blue")
        for line in self._curve(header, size, 4 if self._note else 3):
            lines.append("\n").append_text(line)
        if self._note:
            lines.append(f"\n{self._note}", style="yellow")
        return lines

    def _indication(self, header: RecordingHeader) -> str:
        if self._last is None:
            return ""
        return self._reading.all_of(self._last, header.sampling)

    def _how_far(self, header: RecordingHeader, columns: int) -> str:
        done = 0 if self._last is None else self._last.first + len(self._last.flags)
        total, interval_s = header.planned_samples, header.sampling.interval_s
        elapsed, to_go = _clock(done * interval_s), _clock((total - done) * interval_s)
        words = f" {done} of {total}  {elapsed} elapsed, {to_go} to go"
        return _bar(done, total, min(max(columns - len(words), 4), _BAR)) + words

    def _curve(self, header: RecordingHeader, size: os.terminal_size, taken: int) -> "list[Text]":
        if self._allan is None:
            return []
        from gyrotest.plugin.allan_screen import Room, allan_lines, time_axis

        interval_s, anew = header.sampling.interval_s, self._allan.anew
        remark = ""
        if anew is not None:
            remark = (
                f"curve begun anew at sample {anew.first} ({_clock(anew.first * interval_s)}),"
                f" after {anew.reason}"
            )
        return allan_lines(
            self._allan.curves(),
            axis=time_axis(interval_s, header.planned_samples),
            anew=remark,
            room=Room(width=size.columns, height=size.lines - taken - _SPARE_LINES),
        )


def _bar(done: int, total: int, width: int) -> str:
    full = width * done // total
    return "━" * full + "╌" * (width - full)


def _clock(seconds: float) -> str:
    minutes, second = divmod(round(seconds), 60)
    hour, minute = divmod(minutes, 60)
    return f"{hour}:{minute:02d}:{second:02d}"


def _sparkline(values: deque[float]) -> str:
    low, high = min(values, default=0.0), max(values, default=0.0)
    span = (high - low) or 1.0
    return "".join(_BARS[min(7, int(8 * (one - low) / span))] for one in values)
