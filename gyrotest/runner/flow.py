"""The run of one serial number: acquire an item, judge it, certify the whole."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from datetime import UTC, datetime
from pathlib import Path

from gyrotest.acquisition.acquire import Acquisition
from gyrotest.acquisition.progress import Coming, Progress
from gyrotest.conformity import judge, line
from gyrotest.errors import GyrotestError, InsufficientDataError
from gyrotest.ports import Playback
from gyrotest.recordings.reader import read_samples
from gyrotest.records.plan import Context, Reduction
from gyrotest.records.recording import Identity, Recording, RecordingHeader, Sampling
from gyrotest.records.result import JudgedResult, Measurand, Result, Verdict
from gyrotest.records.run import Attempt, Origin, Outcome, PlannedItem, RunHeader, RunRecord
from gyrotest.records.spec import Between, Over
from gyrotest.runner.bench import Bench, OpenSource
from gyrotest.runner.folder import RunFolder
from gyrotest.runner.items import PlannedCase, moment, planned_case
from gyrotest.runner.record import assemble, write_record

NOT_ENDED = "the run has not ended"


class LackingError(GyrotestError):
    """What is computed over the repeats lacks some of them."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Acquired:
    """An attempt that has a complete recording; `reduction` is None where it was judged before."""

    attempt: Attempt
    reduction: Reduction | None


@dataclass
class UnitRun:
    """The run of one serial number, in whatever process does a part of it.

    `confirm` asks the operator to do something by hand and returns when it is done.
    """

    folder: RunFolder
    header: RunHeader
    bench: Callable[[], Bench]
    progress: Progress
    confirm: Callable[[str], None]
    missing: dict[str, str] = field(default_factory=dict)

    def planned_case(self, item: PlannedItem) -> PlannedCase:
        """The case of an item."""
        return planned_case(item.case, self.header.spec.spec.cases[item.case])

    def acquire(self, item: PlannedItem) -> Acquired:
        """Acquire and reduce an item, unless it stands acquired already.

        Every way out leaves an attempt on record. Raises what ended the attempt.
        """
        standing = self._standing(item)
        if standing is not None:
            return self._acquired_before(item, standing)
        attempt = self._begun(item)
        self._put(attempt)  # so that a killed process leaves an interrupted attempt
        try:
            attempt = self._with_recording(item, attempt)
            reduction = self._reduce(item, attempt)
        except BaseException as fault:
            self._record_fault(self._latest(attempt), fault)
            raise
        return Acquired(attempt=attempt, reduction=reduction)

    def judge(self, item: PlannedItem, acquired: Acquired) -> Attempt:
        """Judge every limit of an acquisition and put the attempt on record."""
        if acquired.reduction is None:
            return acquired.attempt
        return self._judged(item, acquired.attempt, acquired.reduction, None)

    def judge_repeats(self, item: PlannedItem) -> Attempt:
        """Compute and judge what is over the repeats; raises `LackingError` naming what is not there."""
        planned = self.planned_case(item)
        attempt = self._begun(item)
        repeats = [one for one in self.header.plan if one.case == item.case and one.repeat is not None]
        last = {one.name: self._last_judged(one) for one in repeats}
        lacking = [name for name, found in last.items() if found is None]
        if lacking:
            message = f"lacks {', '.join(lacking)}"
            self._put(replace(attempt, outcome=Outcome.SKIPPED, message=message))
            raise LackingError(message)
        found = [one for one in last.values() if one is not None]
        attempt = replace(attempt, origin=found[0].origin, instruments=found[0].instruments)
        try:
            context = self._context(item, planned, None, found[0].recording)
            results = tuple(tuple(_as_result(one) for one in attempt.results) for attempt in found)
            reduction = planned.procedure.reduce_repeats(results, context)
        except GyrotestError as fault:
            self._record_fault(attempt, fault)
            raise
        return self._judged(item, attempt, reduction, Over.REPEATS)

    def fail(self, item: str, message: str) -> None:
        """Something else went wrong with an item that had passed: its attempt becomes an error."""
        attempts = self.folder.attempts(item)
        if attempts and attempts[-1].outcome in {Outcome.PASSED, Outcome.ACQUIRED}:
            self._put(replace(attempts[-1], outcome=Outcome.ERROR, message=message))

    def update_record(self, *, whole: str = "") -> RunRecord:
        """Put `run.json` together anew."""
        record = assemble(self.folder, self.header, self.missing, whole=whole)
        write_record(self.folder, record)
        return record

    def note_progress(self) -> None:
        """Put `run.json` together as it stands in the middle of a run: INCOMPLETE, whatever passed."""
        self.update_record(whole=NOT_ENDED)

    def certify(self, *, whole: str = "") -> tuple[RunRecord, Path]:
        """Write the certificate, and then the record, which never says PASS without a certificate."""
        from gyrotest.certificate.pdf import write_certificate

        record = assemble(self.folder, self.header, self.missing, whole=whole)
        path = write_certificate(record, self.folder.path)
        try:
            write_record(self.folder, record)
        except GyrotestError:
            path.unlink()
            raise
        return record, path

    def withdraw(self, certificate: Path, reason: str) -> tuple[RunRecord, Path]:
        """Put an INCOMPLETE certificate in the place of one that was written just now."""
        certificate.unlink()
        return self.certify(whole=reason)

    def _standing(self, item: PlannedItem) -> Attempt | None:
        """The attempt that stands: nobody tests until it passes."""
        attempts = self.folder.attempts(item.name)
        if not attempts or attempts[-1].outcome in {Outcome.ERROR, Outcome.INTERRUPTED, Outcome.SKIPPED}:
            return None
        failed = sum(one.outcome is Outcome.FAILED for one in attempts)
        retests = self.header.spec.spec.cases[item.case].retests
        if attempts[-1].outcome is Outcome.FAILED and failed <= retests:
            return None
        return attempts[-1]

    def _acquired_before(self, item: PlannedItem, attempt: Attempt) -> Acquired:
        if attempt.outcome is not Outcome.ACQUIRED:
            return Acquired(attempt=attempt, reduction=None)
        return Acquired(attempt=attempt, reduction=self._reduce(item, attempt))

    def _begun(self, item: PlannedItem) -> Attempt:
        now = datetime.now(UTC)
        return Attempt(
            item=item.name,
            number=len(self.folder.attempts(item.name)) + 1,
            outcome=Outcome.INTERRUPTED,
            started_utc=now,
            ended_utc=now,
            issued_utc=now,
        )

    def _latest(self, attempt: Attempt) -> Attempt:
        """The attempt as it stands on record, which knows more than the one that was begun."""
        found = [one for one in self.folder.attempts(attempt.item) if one.number == attempt.number]
        return found[0] if found else attempt

    def _with_recording(self, item: PlannedItem, attempt: Attempt) -> Attempt:
        bench = self.bench()
        opened = bench.source(self.header.slot, self.header.serial_number)
        attempt = replace(attempt, origin=origin_of(opened.use.identity), instruments=(opened.use,))
        try:
            sampling = opened.source.configure(self.planned_case(item).plan.interval_s)
            self._make_ready(item, bench, opened, sampling)
            return self._record(item, attempt, bench, opened, sampling)
        except GyrotestError:
            bench.drop(opened)
            raise

    def _make_ready(
        self, item: PlannedItem, bench: Bench, opened: OpenSource, sampling: Sampling
    ) -> None:
        planned = self.planned_case(item)
        plan = planned.plan
        cycled = planned.case.between_repeats is Between.POWER_CYCLE and item.repeat != 1
        if cycled:
            if self.header.station.station.simulation is None:
                self.confirm(f"{item.name}: switch the unit off and on again")
            bench.power_was_cycled()
        # What this takes passes while the unit warms up, and before the record is stamped.
        self.progress.prepare(
            Coming(sampling=sampling, source=opened.use.identity, samples=plan.samples)
        )
        warm_at_s = bench.powered_on_s + plan.warm_up_s
        if bench.clock.now_s() < warm_at_s and not isinstance(opened.source, Playback):
            self.progress.note(f"{item.name}: warming up until {planned.case.warm_up} after power-on")
            bench.clock.sleep_until(warm_at_s)
        starts = moment(self.header.spec.spec, item)
        bench.stage(self.header.slot, self.header.serial_number, item, moment=starts, plan=plan)
        if isinstance(opened.source, Playback):
            opened.source.cue(starts.acquired_s)

    def _record(
        self, item: PlannedItem, attempt: Attempt, bench: Bench, opened: OpenSource, sampling: Sampling
    ) -> Attempt:
        plan = self.planned_case(item).plan
        acquisition = Acquisition(
            source=opened.source,
            clock=bench.clock,
            progress=self.progress,
            run_folder=self.folder.path,
            header=self._recording_header(item, attempt, bench, opened, sampling),
            plan=plan,
        )
        outcome = Outcome.INTERRUPTED
        try:
            acquisition.run()
            outcome = Outcome.ACQUIRED
        finally:
            played = opened.source.remarks() if isinstance(opened.source, Playback) else ()
            attempt = replace(
                attempt,
                outcome=outcome,
                ended_utc=bench.clock.utc(),
                started_utc=acquisition.header.started_utc,
                recording=acquisition.recording,
                events=tuple(acquisition.events),
                remarks=played,
                truth=bench.truth(self.header.slot, plan),
            )
            self._put(attempt)
        return attempt

    def _recording_header(
        self, item: PlannedItem, attempt: Attempt, bench: Bench, opened: OpenSource, sampling: Sampling
    ) -> RecordingHeader:
        return RecordingHeader(
            run_id=self.header.run_id,
            item=attempt.item,
            attempt=attempt.number,
            serial_number=self.header.serial_number,
            model=self.header.model,
            spec_sha256=self.header.spec.sha256,
            started_utc=bench.clock.utc(),
            planned_samples=self.planned_case(item).plan.samples,
            sampling=sampling,
            source=opened.use.identity,
            since_power_on_s=self._since_power_on_s(item, bench, opened),
            meta=self.header.meta,
        )

    def _since_power_on_s(self, item: PlannedItem, bench: Bench, opened: OpenSource) -> float | None:
        if opened.use.identity.replayed:
            return None
        if self.header.station.station.simulation is not None:
            return moment(self.header.spec.spec, item).elapsed_s
        return bench.clock.now_s() - bench.powered_on_s

    def _reduce(self, item: PlannedItem, attempt: Attempt) -> Reduction:
        planned = self.planned_case(item)
        if attempt.recording is None:
            raise InsufficientDataError(f"{item.name}: attempt {attempt.number} has no recording")
        context = self._context(item, planned, attempt, attempt.recording)
        samples = read_samples(self.folder.path / attempt.recording.path)
        return planned.procedure.reduce(samples, context)

    def _context(
        self,
        item: PlannedItem,
        planned: PlannedCase,
        attempt: Attempt | None,
        recording: Recording | None,
    ) -> Context:
        spec, station = self.header.spec.spec, self.header.station.station
        return Context(
            case_name=item.case,
            case=planned.case,
            parameters=planned.parameters,
            output=spec.output,
            datasheet=spec.datasheet,
            accuracy=station.instruments[station.slots[self.header.slot].source].accuracy,
            site=station.site,
            source=attempt.instruments[0].identity if attempt and attempt.instruments else None,
            gaps=recording.gaps if recording else (),
            since_power_on_s=recording.header.since_power_on_s if recording else None,
        )

    def _judged(
        self, item: PlannedItem, attempt: Attempt, reduction: Reduction, over: Over | None
    ) -> Attempt:
        planned = self.planned_case(item)
        measurands = planned.measured(over)
        results = judge_all(planned, item.repeat, measurands, reduction.results)
        met = all(one.verdict in {None, Verdict.PASS} for one in results)
        judged = replace(
            attempt,
            outcome=Outcome.PASSED if met else Outcome.FAILED,
            message="" if met else "\n".join(failed_lines(results)),
            ended_utc=attempt.ended_utc,
            issued_utc=datetime.now(UTC),
            results=results,
            figures=reduction.figures,
            remarks=(*attempt.remarks, *reduction.remarks),
        )
        self._put(judged)
        return judged

    def _last_judged(self, item: PlannedItem) -> Attempt | None:
        attempts = self.folder.attempts(item.name)
        if attempts and attempts[-1].outcome in {Outcome.PASSED, Outcome.FAILED}:
            return attempts[-1]
        return None

    def _record_fault(self, attempt: Attempt, fault: BaseException) -> None:
        interrupted = not isinstance(fault, Exception)
        self._put(
            replace(
                attempt,
                outcome=Outcome.INTERRUPTED if interrupted else Outcome.ERROR,
                message=str(fault) if interrupted else f"{fault}" or type(fault).__name__,
                issued_utc=datetime.now(UTC),
            )
        )

    def _put(self, attempt: Attempt) -> None:
        self.folder.write_attempt(attempt)


def judge_all(
    planned: PlannedCase, repeat: int | None, measurands: Sequence[Measurand], results: Sequence[Result]
) -> tuple[JudgedResult, ...]:
    """Judge each measurand of a case: one that was not measured is judged as missing, never left out."""
    measured: Mapping[str, Result] = {one.name: one for one in results}
    limits = planned.case.limits
    return tuple(
        judge(one, measured.get(one.name), limits.get(one.name), case=planned.name, repeat=repeat)
        for one in measurands
        if one.name in measured or one.name in limits
    )


def failed_lines(results: Sequence[JudgedResult]) -> list[str]:
    """One line for each limit that is not met."""
    return [line(one) for one in results if one.verdict not in {None, Verdict.PASS}]


def _as_result(judged: JudgedResult) -> Result:
    return Result(
        name=judged.name,
        label=judged.label,
        value=float("nan") if judged.value is None else judged.value,
        unit=judged.unit,
        expanded_uncertainty=judged.expanded_uncertainty,
        coverage_factor=judged.coverage_factor,
        lower_95=judged.lower_95,
        upper_95=judged.upper_95,
        at_most=judged.at_most,
        condition=judged.condition,
        budget=judged.budget,
        not_included=judged.not_included,
    )


def origin_of(identity: Identity) -> Origin:
    """Where the samples of an instrument come from, by what it says of itself."""
    if identity.replayed:
        return Origin.REPLAYED
    return Origin.SIMULATED if identity.simulated else Origin.MEASURED
