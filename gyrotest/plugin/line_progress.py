"""Progress where there is no terminal: a line a minute."""

import time
from typing import IO, TYPE_CHECKING

from gyrotest.acquisition.progress import Coming
from gyrotest.plugin.reading import Reading
from gyrotest.records.recording import Block, RecordingHeader

if TYPE_CHECKING:
    from gyrotest.plugin.running_allan import RunningAllan

LINE_EVERY_S = 60.0


class LineProgress:
    """A line now and then, for logs and pipes; each on a line of its own, between pytest's.

    A simulated bench without `real_time` and a replayed file are over before they have much to say:
    nothing is loaded for them.
    """

    def __init__(self, stream: IO[str], reading: Reading, *, real_time: bool) -> None:
        self._stream = stream
        self._reading = reading
        self._real_time = real_time
        self._header: RecordingHeader | None = None
        self._allan: RunningAllan | None = None
        self._written = 0.0
        self._among_pytests = True

    def prepare(self, coming: Coming) -> None:
        """Load and compile what the lines will tell."""
        self._allan = self._running_allan(coming)

    def begin(self, header: RecordingHeader) -> None:
        """An acquisition begins."""
        self._header = header
        self.note(
            f"{header.item}: {header.planned_samples} samples every {header.sampling.interval_s:g} s"
        )
        self._written = time.monotonic()

    def push(self, block: Block) -> None:
        """Say how far it is, once a minute."""
        if self._allan is not None:
            self._allan.push(block)
        if self._header is None or time.monotonic() - self._written < LINE_EVERY_S:
            return
        self._written = time.monotonic()
        done = block.first + len(block.flags)
        shown = self._reading.all_of(block, self._header.sampling)
        self.note(
            f"{self._header.item}: {done} of {self._header.planned_samples}, {shown}{self._lowest()}"
        )

    def note(self, text: str) -> None:
        """Write a line."""
        before = "\n" if self._among_pytests else ""
        self._stream.write(f"{before}{text}\n")
        self._stream.flush()
        self._among_pytests = False

    def end(self) -> None:
        """The acquisition is over; pytest goes on with its own line."""
        self._header = self._allan = None
        self._among_pytests = True

    def _running_allan(self, coming: Coming) -> "RunningAllan | None":
        dps_per_unit = self._reading.dps_per(coming.sampling.unit)
        paced = self._real_time or not (coming.source.simulated or coming.source.replayed)
        lasts_s = coming.samples * coming.sampling.interval_s
        if dps_per_unit is None or not paced or lasts_s < LINE_EVERY_S or coming.steps > 1:
            return None
        from gyrotest.plugin.running_allan import RunningAllan

        return RunningAllan(coming.sampling, dps_per_unit=dps_per_unit)

    def _lowest(self) -> str:
        if self._allan is None:
            return ""
        from gyrotest.plugin.allan_words import lowest_so_far

        curves = self._allan.curves()
        words = lowest_so_far(curves[0]) if curves else ""
        return f"; Allan deviation so far: {words}" if words else ""
