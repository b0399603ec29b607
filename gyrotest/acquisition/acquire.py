"""One acquisition: warm up, sample to the end of the plan, keep everything, bridge a bench's faults."""

from dataclasses import dataclass, field
from pathlib import Path

from gyrotest.acquisition.plausibility import Plausibility
from gyrotest.acquisition.progress import Progress
from gyrotest.errors import AcquisitionError, InstrumentError, OverloadError
from gyrotest.ports import Clock, Source
from gyrotest.recordings.writer import RecordingWriter
from gyrotest.records.plan import Plan
from gyrotest.records.recording import Block, Gap, Recording, RecordingHeader

RETRY_PAUSES_S = (1.0, 5.0, 30.0)
MOST_RECOVERIES = 10


@dataclass
class Acquisition:
    """A source sampled by a plan into a recording. `recording` and `events` stand after `run`.

    `run` raises what ended the acquisition early; the recording, marked incomplete, is there then too.
    """

    source: Source
    clock: Clock
    progress: Progress
    run_folder: Path
    header: RecordingHeader
    plan: Plan
    recording: Recording | None = None
    events: list[str] = field(default_factory=list)
    _next: int = 0
    _recoveries: int = 0

    def run(self) -> Recording:
        """Acquire the plan's samples; raises `AcquisitionError` or `InstrumentError`."""
        writer = RecordingWriter(self.run_folder, self.header)
        try:
            self.progress.begin(self.header)
            self._sample(writer)
            return writer.close(complete=True)
        finally:
            self.progress.end()
            self.recording = writer.close(complete=False)

    def _sample(self, writer: RecordingWriter) -> None:
        plausibility = Plausibility(self.header.source.model, self.header.sampling)
        self.source.start(0, self.plan.samples)
        faults = 0
        while True:
            try:
                block = self.source.fetch()
            except OverloadError:
                raise
            except InstrumentError as fault:
                faults = self._bridge(writer, fault, faults)
                continue
            if block is None:
                break
            self._keep(writer, block)
            plausibility.push(block)
            faults = 0
        if self._next < self.plan.samples:
            raise AcquisitionError(
                f"{self.header.source.model}: ended after {self._next} of {self.plan.samples} samples"
                f" ({self._next * self.plan.interval_s:g} of {self.plan.duration_s:g} s); shorten the case's"
                " duration or record longer"
            )

    def _keep(self, writer: RecordingWriter, block: Block) -> None:
        writer.push(block)
        self.progress.push(block)
        self._next = block.first + len(block.flags)

    def _bridge(self, writer: RecordingWriter, fault: InstrumentError, faults: int) -> int:
        """Bring the source back, with pauses between the tries; what was missed is a recorded gap."""
        if self._recoveries == MOST_RECOVERIES:
            raise AcquisitionError(f"{fault}; given up after {MOST_RECOVERIES} recoveries in one record")
        for tried, pause_s in enumerate(RETRY_PAUSES_S[faults:], start=faults + 1):
            self._note(f"{fault}; try {tried} of {len(RETRY_PAUSES_S)} in {pause_s:g} s")
            self.clock.sleep_until(self.clock.now_s() + pause_s)
            try:
                first = self._restarted()
            except InstrumentError as again:
                fault = again
                continue
            self._go_on(writer, first, str(fault))
            return tried
        raise AcquisitionError(f"{fault}; given up after {len(RETRY_PAUSES_S)} tries")

    def _restarted(self) -> int:
        """The position at which the source goes on, unless that is beyond the record's end."""
        first = self.source.recover()
        if first < self.plan.samples:
            self.source.start(first, self.plan.samples)
        return first

    def _go_on(self, writer: RecordingWriter, first: int, reason: str) -> None:
        gap = Gap(after=self._next - 1, missing=first - self._next, reason=reason)
        writer.new_segment(gap)
        self._recoveries += 1
        self._note(f"recovered; {gap.missing} samples are missing after sample {gap.after}")
        if first >= self.plan.samples:
            raise AcquisitionError(f"{reason}; the instrument came back after the record's end")
        self._next = first

    def _note(self, text: str) -> None:
        self.events.append(f"{self.clock.utc():%Y-%m-%d %H:%M:%S} UTC: {text}")
        self.progress.note(text)
