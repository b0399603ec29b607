"""The taking of one acquisition: power, source, warm-up, record; for every unit that the source reads."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

from gyrotest.acquisition.acquire import Acquisition
from gyrotest.acquisition.progress import Coming, Progress
from gyrotest.acquisition.tracks import Track
from gyrotest.acquisition.vibrating import VibrationByHand
from gyrotest.errors import AcquisitionError, GyrotestError, InstrumentError
from gyrotest.ports import DigitalGyro, Playback, Remarking
from gyrotest.records.plan import Placement
from gyrotest.records.recording import Identity, Recording, RecordingHeader, Sampling
from gyrotest.records.run import Attempt, Origin, Outcome, PlannedItem, RunHeader
from gyrotest.records.spec import Between
from gyrotest.records.station import Slot
from gyrotest.runner.bench import Bench, OpenSource
from gyrotest.runner.channels import Share, configured
from gyrotest.runner.device import check_device
from gyrotest.runner.folder import RunFolder
from gyrotest.runner.items import PlannedCase, moment
from gyrotest.runner.mounting import mounted_words, remounting_words, turned_before_deg

_BY_HAND = "The unit was switched off and on by hand (manual power cycle), as the operator confirmed."


@dataclass
class TakesPart:
    """A unit's part in an acquisition: its run's folder and header, and the attempt as it stands so far."""

    folder: RunFolder
    header: RunHeader
    item: PlannedItem
    attempt: Attempt

    @property
    def slot(self) -> str:
        """The name of the unit's slot."""
        return self.header.slot

    @property
    def place(self) -> Slot:
        """Where the unit is."""
        return self.header.station.station.slots[self.header.slot]


class Taking:
    """One acquisition for one unit, or for several that one source reads.

    `confirm` asks the operator to do something by hand and returns when it is done.
    """

    def __init__(
        self,
        parts: Sequence[TakesPart],
        planned: PlannedCase,
        *,
        bench: Bench,
        progress: Progress,
        confirm: Callable[[str], None],
    ) -> None:
        self._parts = parts
        self._first = parts[0]
        self._planned = planned
        self._bench = bench
        self._progress = progress
        self._confirm = confirm

    def acquire(self) -> None:
        """Acquire, and leave each part's attempt with its recording; raises what ended it early."""
        self._cycle_power()
        for part in self._parts:
            self._bench.power_on(part.slot)
        opened = self._bench.source(self._first.slot, self._first.header.serial_number)
        for part in self._parts:
            part.attempt = replace(
                part.attempt, origin=origin_of(opened.use.identity), instruments=(opened.use,)
            )
        try:
            self._remount(opened)
            shares = self._configured(opened)
            self._make_ready(opened, shares[0].sampling)
            self._record(opened, shares)
        except GyrotestError as fault:
            self._bench.drop(opened)
            self._bench.stimuli.put_down(self._first.slot)
            self._blame_power(fault)
            raise

    def _blame_power(self, fault: GyrotestError) -> None:
        """Tell of a supply that failed what it has brought about; it is off then, and switched on anew."""
        for part in self._parts:
            try:
                self._bench.check_power(part.slot)
            except InstrumentError as cause:
                if str(cause) not in str(fault):
                    raise AcquisitionError(f"{cause}; what came of it: {fault}") from fault

    def _cycle_power(self) -> None:
        """Switch the units off and on between two repeats, where the case asks for it."""
        case, item = self._planned.case, self._first.item
        if case.between_repeats is not Between.POWER_CYCLE or item.repeat == 1:
            return
        for part in self._parts:
            if self._bench.cycle_power(part.slot):
                continue
            if part.header.station.station.simulation is None:
                self._confirm(f"{part.item.name}: switch the unit off and on again")
                part.attempt = replace(part.attempt, remarks=(*part.attempt.remarks, _BY_HAND))
            self._bench.power_was_cycled(part.slot)

    def _remount(self, opened: OpenSource) -> None:
        """See that every unit is mounted as the plan says; several are asked for at once."""
        placement = self._planned.plan.placement(self._first.item.repeat)
        if placement is None or isinstance(opened.source, Playback):
            return
        bench, changes = self._bench, [one for one in self._parts if self._is_other(one, placement)]
        if changes and bench.by_hand:
            units = {one.slot: one.header.serial_number for one in changes}
            asked = remounting_words(units, placement, safe=bench.stimuli.make_safe(self._first.slot))
            self._confirm(f"{self._first.item.name}: {asked}")
        for part in self._parts:
            bench.mounted.put(part.slot, part.header.serial_number, placement.turned_deg)
        if changes or placement.turned_deg:
            confirmed = ", as the operator confirmed" if bench.by_hand else ""
            self._remark(f"Mounted {mounted_words(placement)}{confirmed}.")

    def _is_other(self, part: TakesPart, placement: Placement) -> bool:
        """Whether a unit is mounted otherwise: as it was last, here or by its run's record."""
        known_deg = self._bench.mounted.turned_deg(part.slot, part.header.serial_number)
        if known_deg is None:
            known_deg = turned_before_deg(part.folder, part.header)
        return known_deg != placement.turned_deg

    def _configured(self, opened: OpenSource) -> tuple[Share, ...]:
        """Set the source up; each unit's share of it."""
        output = self._first.header.spec.spec.output
        shares = configured(
            opened, [one.place for one in self._parts], self._planned.plan.interval_s, output.axes
        )
        if isinstance(opened.source, DigitalGyro):
            device = opened.source.device()
            check_device(
                device,
                who=opened.use.resource,
                serial_number=self._first.header.serial_number,
                output=output,
            )
            if device.simulated:
                self._first.attempt = replace(self._first.attempt, origin=Origin.SIMULATED)
        return shares

    def _make_ready(self, opened: OpenSource, sampling: Sampling) -> None:
        planned, bench = self._planned, self._bench
        plan = planned.plan
        # What this takes passes while the unit warms up, and before the record is stamped.
        self._progress.prepare(
            Coming(
                sampling=sampling,
                source=opened.use.identity,
                samples=plan.samples,
                steps=len(plan.steps),
            )
        )
        warm_at_s = plan.warm_up_s + max(bench.powered_on_s(one.slot) for one in self._parts)
        if bench.clock.now_s() < warm_at_s and not isinstance(opened.source, Playback):
            self._progress.note(
                f"{self._first.item.name}: warming up until {planned.case.warm_up} after power-on"
            )
            bench.clock.sleep_until(warm_at_s)
        for part in self._parts:
            header = part.header
            starts = moment(header.spec.spec, part.item)
            bench.stage(
                header.slot,
                header.serial_number,
                part.item,
                moment=starts,
                plan=plan,
                case=planned.case,
            )
            if isinstance(opened.source, Playback):
                opened.source.cue(starts.acquired_s)

    def _record(self, opened: OpenSource, shares: tuple[Share, ...]) -> None:
        planned, bench = self._planned, self._bench
        loss = planned.case.allowed_loss
        acquisition = Acquisition(
            source=opened.source,
            clock=bench.clock,
            progress=self._progress,
            tracks=tuple(
                Track(
                    run_folder=part.folder.path,
                    header=self._header(part, opened, of_unit.sampling),
                    columns=of_unit.columns,
                )
                for part, of_unit in zip(self._parts, shares, strict=True)
            ),
            plan=planned.plan,
            stimulation=bench.stimuli.of(
                self._first.slot, planned.plan, source=opened.source, by_hand=self._vibration_by_hand()
            ),
            allowed_loss=None if loss is None else loss.to(""),
        )
        outcome = Outcome.INTERRUPTED
        try:
            acquisition.run()
            for part in self._parts:
                bench.check_power(part.slot)
            outcome = Outcome.ACQUIRED
        finally:
            self._put_on_record(opened, acquisition, outcome)

    def _vibration_by_hand(self) -> VibrationByHand | None:
        """The operator at a vibration table that has a controller of its own; nobody on a simulated bench."""
        if self._first.header.station.station.simulation is not None:
            return None
        item = self._first.item.name
        return VibrationByHand(
            clock=self._bench.clock,
            ask=lambda text: self._confirm(f"{item}: {text}"),
            told=self._remark,
            note=lambda text: self._progress.note(f"{item}: {text}"),
        )

    def _remark(self, text: str) -> None:
        """Something that each unit's certificate is to say of this acquisition, once."""
        for part in self._parts:
            remarks = dict.fromkeys((*part.attempt.remarks, text))
            part.attempt = replace(part.attempt, remarks=tuple(remarks))

    def _put_on_record(self, opened: OpenSource, acquisition: Acquisition, outcome: Outcome) -> None:
        bench, source = self._bench, opened.source
        told = source.remarks() if isinstance(source, Remarking) else ()
        recordings: tuple[Recording | None, ...] = acquisition.recordings or (None,) * len(self._parts)
        for part, track, recording in zip(self._parts, acquisition.tracks, recordings, strict=True):
            slot = part.slot
            used = tuple(one for one in bench.used(slot) if one.name != opened.use.name)
            part.attempt = replace(
                part.attempt,
                outcome=outcome,
                started_utc=track.header.started_utc,
                ended_utc=bench.clock.utc(),
                recording=recording,
                instruments=(opened.use, *used),
                events=tuple(acquisition.events),
                remarks=(*part.attempt.remarks, *bench.take_events(slot), *told),
                truth=bench.truth(slot, self._planned.plan),
            )
            part.folder.write_attempt(part.attempt)

    def _header(self, part: TakesPart, opened: OpenSource, sampling: Sampling) -> RecordingHeader:
        header, bench = part.header, self._bench
        return RecordingHeader(
            run_id=header.run_id,
            item=part.attempt.item,
            attempt=part.attempt.number,
            serial_number=header.serial_number,
            model=header.model,
            spec_sha256=header.spec.sha256,
            started_utc=bench.clock.utc(),
            planned_samples=self._planned.plan.samples,
            sampling=sampling,
            source=opened.use.identity,
            since_power_on_s=self._since_power_on_s(part, opened),
            meta=header.meta,
        )

    def _since_power_on_s(self, part: TakesPart, opened: OpenSource) -> float | None:
        header = part.header
        if opened.use.identity.replayed:
            return None
        if header.station.station.simulation is not None:
            return moment(header.spec.spec, part.item).elapsed_s
        return self._bench.clock.now_s() - self._bench.powered_on_s(header.slot)


def origin_of(identity: Identity) -> Origin:
    """Where the samples of an instrument come from, by what it says of itself."""
    if identity.replayed:
        return Origin.REPLAYED
    return Origin.SIMULATED if identity.simulated else Origin.MEASURED
