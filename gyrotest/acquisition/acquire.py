"""One acquisition: each step's stimulus, its samples to the last, everything kept, a bench's faults bridged."""

import contextlib
from collections.abc import Iterator
from dataclasses import dataclass, field, replace

from gyrotest.acquisition.plausibility import Plausibility
from gyrotest.acquisition.progress import Progress
from gyrotest.acquisition.stimulation import Stimulation
from gyrotest.acquisition.tracks import Track, Tracks
from gyrotest.acquisition.vibrating import vibration_words
from gyrotest.errors import AcquisitionError, GyrotestError, InstrumentError, OverloadError
from gyrotest.ports import Clock, DigitalGyro, Playback, Source, SyncDaq
from gyrotest.records.plan import Plan, Rotating, Step, Turning, Vibrating
from gyrotest.records.recording import Block, Dwell, Gap, Recording

RETRY_PAUSES_S = (1.0, 5.0, 30.0)
MOST_RECOVERIES = 10
_PPM = 1e6


@dataclass
class Acquisition:
    """A source sampled by a plan into recordings. `recordings` and `events` stand after `run`.

    Every unit that the source reads has a track; all tracks are recorded side by side. `allowed_loss`
    is the share of the samples that may be lost (None: any). `run` raises what ended the acquisition
    early; the recordings, marked incomplete, are there then too.
    """

    source: Source
    clock: Clock
    progress: Progress
    tracks: tuple[Track, ...]
    plan: Plan
    stimulation: Stimulation = field(default_factory=Stimulation)
    allowed_loss: float | None = None
    recordings: tuple[Recording, ...] = ()
    events: list[str] = field(default_factory=list)
    _begun_s: float = 0.0
    _base: int = 0
    _offset_s: float = 0.0
    _next: int = 0
    _missing: int = 0
    _recoveries: int = 0

    def run(self) -> tuple[Recording, ...]:
        """Acquire the plan's samples; raises `AcquisitionError` or `InstrumentError`."""
        tracks = Tracks(self.tracks)
        try:
            self.progress.begin(self.tracks[0].header)
            self._begun_s = self.clock.now_s()
            for number, step in enumerate(self.plan.steps, start=1):
                self._carry_out(tracks, step, number)
            return tracks.close(complete=True)
        finally:
            self.stimulation.rest()
            self.progress.end()
            self.recordings = tracks.close(complete=False)

    def _carry_out(self, tracks: Tracks, step: Step, number: int) -> None:
        """Bring the stimulus about, sample, and put on record what was there, also when it breaks off."""
        if len(self.plan.steps) > 1:
            self.progress.note(f"{_step_words(step)}, {number} of {len(self.plan.steps)}")
        asked_s = self.clock.now_s()
        with self._told_of(step):
            self.stimulation.reach(step)
        began_s = self.clock.now_s()
        self._offset_s = began_s - self._begun_s
        try:
            with self._told_of(step):
                self._sample(tracks, step)
                self.stimulation.leave()
        finally:
            read_back = self.stimulation.read_back()
            tracks.dwell(
                Dwell(
                    name=step.name,
                    first=self._base,
                    samples=step.samples,
                    began_s=self._offset_s,
                    settling_s=began_s - asked_s,
                    rate_dps=read_back.demanded_rate_dps,
                    measured_rate_dps=read_back.rate_dps,
                    temperature_degc=read_back.demanded_temperature_degc,
                    measured_temperature_degc=read_back.temperature_degc,
                    position_deg=read_back.demanded_position_deg,
                    measured_position_deg=read_back.position_deg,
                    vibration_dps=read_back.vibration_dps,
                    frequency_hz=read_back.frequency_hz,
                    band_hz=read_back.band_hz,
                )
            )
        self._base += step.samples

    @contextlib.contextmanager
    def _told_of(self, step: Step) -> Iterator[None]:
        """Say of whatever goes wrong in which of several steps it did."""
        try:
            yield
        except GyrotestError as fault:
            if len(self.plan.steps) > 1 and f"step '{step.name}'" not in str(fault):
                fault.args = (f"{fault} ({_step_words(step)})",)
            raise

    def _sample(self, tracks: Tracks, step: Step) -> None:
        header = self.tracks[0].header
        plausibility = Plausibility(header.source.model, header.sampling, may_saturate=step.may_saturate)
        self._next = 0
        self.source.start(0, step.samples)
        faults = 0
        while True:
            try:
                block = self.source.fetch()
            except OverloadError:
                raise
            except InstrumentError as fault:
                faults = self._bridge(tracks, step, fault, faults)
                continue
            if block is None:
                break
            self._keep(tracks, block)
            # What the samples say of themselves, a restart say, is nearer the cause than how many are lost.
            plausibility.push(block)
            self._refuse_loss()
            self.stimulation.watch()
            faults = 0
        lost = step.samples - self._next
        if lost and not self._may_be_lost():
            raise AcquisitionError(self._ended_early(step))
        if lost:
            self._missing += lost
            self._note(f"the last {lost} samples of the step were lost on the way")
            self._refuse_loss()

    def _may_be_lost(self) -> bool:
        """Whether samples that lack at the end were lost on the way, and are no end of the source itself."""
        if isinstance(self.source, Playback):
            return False
        return self.allowed_loss is not None or isinstance(self.source, DigitalGyro | SyncDaq)

    def _ended_early(self, step: Step) -> str:
        interval_s = self.plan.interval_s
        of_step = f" of step '{step.name}'" if len(self.plan.steps) > 1 else ""
        return (
            f"{self.tracks[0].header.source.model}: ended after {self._next} of {step.samples} samples{of_step}"
            f" ({self._next * interval_s:g} of {step.samples * interval_s:g} s); shorten the case's"
            " duration or record longer"
        )

    def _keep(self, tracks: Tracks, block: Block) -> None:
        """Put a block in its place in the whole recording."""
        self._count_missing(block.first)
        self._next = block.first + len(block.flags)
        if self._base or self._offset_s:
            block = replace(block, first=self._base + block.first, time_s=block.time_s + self._offset_s)
        self.progress.push(tracks.push(block))

    def _count_missing(self, first: int) -> None:
        self._missing += first - self._next

    def _refuse_loss(self) -> None:
        if self.allowed_loss is None or self._missing <= self.allowed_loss * self.plan.samples:
            return
        raise AcquisitionError(
            f"{self.tracks[0].header.source.model}: {self._missing} samples are lost, of {self.plan.samples}"
            f" {self.allowed_loss * _PPM:g} ppm are allowed (allowed_loss); look at the line, its baud rate"
            " and the computer's load"
        )

    def _bridge(self, tracks: Tracks, step: Step, fault: InstrumentError, faults: int) -> int:
        """Bring the source back, with pauses between the tries; what was missed is a recorded gap."""
        if self._recoveries == MOST_RECOVERIES:
            raise AcquisitionError(f"{fault}; given up after {MOST_RECOVERIES} recoveries in one record")
        for tried, pause_s in enumerate(RETRY_PAUSES_S[faults:], start=faults + 1):
            self._note(f"{fault}; try {tried} of {len(RETRY_PAUSES_S)} in {pause_s:g} s")
            self.stimulation.allow_pause(pause_s)
            self.clock.sleep_until(self.clock.now_s() + pause_s)
            self.stimulation.watch()
            try:
                first = self._restarted(step)
            except InstrumentError as again:
                fault = again
                continue
            self._go_on(tracks, step, first, str(fault))
            return tried
        raise AcquisitionError(f"{fault}; given up after {len(RETRY_PAUSES_S)} tries")

    def _restarted(self, step: Step) -> int:
        """The position at which the source goes on, unless that is beyond the step's end."""
        first = self.source.recover()
        if first < step.samples:
            self.source.start(first, step.samples)
        return first

    def _go_on(self, tracks: Tracks, step: Step, first: int, reason: str) -> None:
        gap = Gap(after=self._base + self._next - 1, missing=first - self._next, reason=reason)
        tracks.new_segment(gap)
        self._recoveries += 1
        self._note(f"recovered; {gap.missing} samples are missing after sample {gap.after}")
        if first >= step.samples:
            raise AcquisitionError(f"{reason}; the instrument came back after the record's end")
        self._missing += gap.missing
        self._next = first

    def _note(self, text: str) -> None:
        self.events.append(f"{self.clock.utc():%Y-%m-%d %H:%M:%S} UTC: {text}")
        self.progress.note(text)


def _step_words(step: Step) -> str:
    """A step by its name, and by how it turns or vibrates where it does."""
    if isinstance(step.stimulus, Turning | Rotating):
        return f"step '{step.name}' at {step.stimulus.rate_dps:g} °/s"
    if isinstance(step.stimulus, Vibrating):
        return f"step '{step.name}', {vibration_words(step.stimulus)}"
    return f"step '{step.name}'"
