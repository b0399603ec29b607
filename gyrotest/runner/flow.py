"""The run of one serial number: acquire an item, judge it, certify the whole."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from datetime import UTC, datetime
from pathlib import Path

from gyrotest.acquisition.progress import Progress
from gyrotest.conformity import line
from gyrotest.errors import GyrotestError, InsufficientDataError
from gyrotest.records.plan import Context
from gyrotest.records.recording import Recording
from gyrotest.records.result import JudgedResult, Result, Verdict
from gyrotest.records.run import Attempt, Outcome, PlannedItem, RunHeader, RunRecord
from gyrotest.records.spec import Over
from gyrotest.runner.axes import (
    AxisReduction,
    axes_of,
    axis_case,
    axis_results,
    judge_axes,
    reduced,
)
from gyrotest.runner.bench import Bench
from gyrotest.runner.folder import RunFolder
from gyrotest.runner.items import PlannedCase, planned_case
from gyrotest.runner.places import moved_together
from gyrotest.runner.record import assemble, write_record
from gyrotest.runner.taking import TakesPart, Taking

NOT_ENDED = "the run has not ended"


class LackingError(GyrotestError):
    """What is computed over the repeats lacks some of them."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Acquired:
    """An attempt that has a complete recording; `reduction` is None where it was judged before."""

    attempt: Attempt
    reduction: tuple[AxisReduction, ...] | None


@dataclass
class UnitRun:
    """The run of one serial number, in whatever process does a part of it.

    `confirm` asks the operator to do something by hand and returns when it is done. `partners` are the
    runs of other units that the same source reads: what is acquired for one is acquired for all.
    """

    folder: RunFolder
    header: RunHeader
    bench: Callable[[], Bench]
    progress: Progress
    confirm: Callable[[str], None]
    partners: Callable[[], Sequence["UnitRun"]] = tuple
    missing: dict[str, str] = field(default_factory=dict)

    def planned_case(self, item: PlannedItem) -> PlannedCase:
        """The case of an item."""
        return planned_case(item.case, self.header.spec.spec)

    def acquire(self, item: PlannedItem) -> Acquired:
        """Acquire and reduce an item, unless it stands acquired already.

        Every way out leaves an attempt on record. Raises what ended the attempt.
        """
        standing = self.standing(item)
        if standing is not None:
            return self._acquired_before(item, standing)
        parts = (self.takes_part(item), *self._others(item))
        try:
            Taking(
                parts,
                self.planned_case(item),
                bench=self.bench(),
                progress=self.progress,
                confirm=self.confirm,
            ).acquire()
        except BaseException as fault:
            for part in parts:
                record_fault(part.folder, part.attempt, fault)
            raise
        attempt = parts[0].attempt
        try:
            reduction = self._reduce(item, attempt)
        except BaseException as fault:
            record_fault(self.folder, attempt, fault)
            raise
        return Acquired(attempt=attempt, reduction=reduction)

    def takes_part(self, item: PlannedItem) -> TakesPart:
        """Begin an attempt at an item that is acquired now."""
        attempt = self._begun(item)
        self._put(attempt)  # so that a killed process leaves an interrupted attempt
        return TakesPart(folder=self.folder, header=self.header, item=item, attempt=attempt)

    def _others(self, item: PlannedItem) -> Iterator[TakesPart]:
        """The same item of the other units that the source reads, where it is still due.

        Units that other instruments move are acquired by themselves.
        """
        slots, plan = self.header.station.station.slots, self.planned_case(item).plan
        for partner in self.partners():
            if not moved_together(plan, slots[self.header.slot], slots[partner.header.slot]):
                continue
            for theirs in partner.header.plan:
                same = (theirs.case, theirs.repeat) == (item.case, item.repeat)
                if same and partner.standing(theirs) is None:
                    yield partner.takes_part(theirs)

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
            reduction = tuple(
                self._reduced_repeats(item, planned, found, axis) for axis in self._axes(planned)
            )
        except GyrotestError as fault:
            record_fault(self.folder, attempt, fault)
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

    def standing(self, item: PlannedItem) -> Attempt | None:
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

    def _axes(self, planned: PlannedCase) -> tuple[str, ...]:
        return axes_of(self.header.spec.spec.output, planned.case)

    def _reduce(self, item: PlannedItem, attempt: Attempt) -> tuple[AxisReduction, ...]:
        """Reduce each axis by itself."""
        planned = self.planned_case(item)
        if attempt.recording is None:
            raise InsufficientDataError(f"{item.name}: attempt {attempt.number} has no recording")
        recording, path = attempt.recording, self.folder.path / attempt.recording.path
        return tuple(
            AxisReduction(
                axis=axis,
                reduction=reduced(
                    planned, recording, path, self._context(item, planned, attempt, recording, axis)
                ),
            )
            for axis in self._axes(planned)
        )

    def _reduced_repeats(
        self, item: PlannedItem, planned: PlannedCase, found: Sequence[Attempt], axis: str
    ) -> AxisReduction:
        context = self._context(item, planned, None, found[0].recording, axis)
        results = tuple(axis_results(attempt, axis) for attempt in found)
        return AxisReduction(axis=axis, reduction=planned.procedure.reduce_repeats(results, context))

    def _context(
        self,
        item: PlannedItem,
        planned: PlannedCase,
        attempt: Attempt | None,
        recording: Recording | None,
        axis: str,
    ) -> Context:
        spec, station = self.header.spec.spec, self.header.station.station
        slot, instruments = station.slots[self.header.slot], station.instruments
        return Context(
            case_name=item.case,
            case=axis_case(planned.case, axis),
            parameters=planned.parameters,
            output=spec.output,
            datasheet=spec.datasheet,
            accuracy=instruments[slot.source].accuracy,
            site=station.site,
            source=attempt.instruments[0].identity if attempt and attempt.instruments else None,
            gaps=recording.gaps if recording else (),
            since_power_on_s=recording.header.since_power_on_s if recording else None,
            axis=axis,
            dwells=recording.dwells if recording else (),
            table=instruments[slot.table].accuracy if slot.table else None,
            chamber=instruments[slot.chamber].accuracy if slot.chamber else None,
            earlier=self._earlier(item, axis),
            repeat=item.repeat,
            encoder=slot.encoder,
            frame=slot.frame,
            placement=planned.plan.placement(item.repeat),
            shaft=instruments[slot.table].shaft if slot.table else None,
        )

    def _earlier(self, item: PlannedItem, axis: str) -> Mapping[str, tuple[Result, ...]]:
        """An axis's results of the cases before this one, each case's repeats one after another."""
        found: dict[str, tuple[Result, ...]] = {}
        for planned in self.header.plan:
            if planned.case == item.case:
                break
            judged = self._last_judged(planned)
            if judged is not None:
                found[planned.case] = (*found.get(planned.case, ()), *axis_results(judged, axis))
        return found

    def _judged(
        self,
        item: PlannedItem,
        attempt: Attempt,
        reduction: Sequence[AxisReduction],
        over: Over | None,
    ) -> Attempt:
        planned = self.planned_case(item)
        results = judge_axes(planned, item.repeat, over, reduction)
        met = all(one.verdict in {None, Verdict.PASS} for one in results)
        judged = replace(
            attempt,
            outcome=Outcome.PASSED if met else Outcome.FAILED,
            message="" if met else "\n".join(failed_lines(results)),
            ended_utc=attempt.ended_utc,
            issued_utc=datetime.now(UTC),
            results=results,
            figures=tuple(figure for one in reduction for figure in one.figures),
            remarks=(
                *attempt.remarks,
                *dict.fromkeys(text for one in reduction for text in one.remarks),
            ),
            exports=tuple(
                self.folder.write_export(item.name, one.axis, export)
                for one in reduction
                for export in one.reduction.exports
            ),
        )
        self._put(judged)
        return judged

    def _last_judged(self, item: PlannedItem) -> Attempt | None:
        attempts = self.folder.attempts(item.name)
        if attempts and attempts[-1].outcome in {Outcome.PASSED, Outcome.FAILED}:
            return attempts[-1]
        return None

    def _put(self, attempt: Attempt) -> None:
        self.folder.write_attempt(attempt)


def failed_lines(results: Sequence[JudgedResult]) -> list[str]:
    """One line for each limit that is not met."""
    return [line(one) for one in results if one.verdict not in {None, Verdict.PASS}]


def record_fault(folder: RunFolder, attempt: Attempt, fault: BaseException) -> None:
    """Put on record what ended an attempt."""
    interrupted = not isinstance(fault, Exception)
    folder.write_attempt(
        replace(
            attempt,
            outcome=Outcome.INTERRUPTED if interrupted else Outcome.ERROR,
            message=str(fault) if interrupted else f"{fault}" or type(fault).__name__,
            issued_utc=datetime.now(UTC),
        )
    )
