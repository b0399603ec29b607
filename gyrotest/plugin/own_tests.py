"""What a user's own tests beside a spec work with: an instrument, acquisitions, judged values."""

from collections.abc import Callable
from datetime import UTC, datetime
from typing import TypeVar

import pytest

from gyrotest.acquisition.acquire import Acquisition
from gyrotest.acquisition.tracks import Track
from gyrotest.conformity import judge, line
from gyrotest.errors import AcquisitionError, GyrotestError, InstrumentError
from gyrotest.plugin.properties import add_properties
from gyrotest.plugin.session import GyroSession
from gyrotest.recordings.reader import read_samples
from gyrotest.records.plan import Plan, Step
from gyrotest.records.recording import Block, Identity, Recording, RecordingHeader, Samples
from gyrotest.records.result import JudgedResult, Measurand, Result, Verdict
from gyrotest.records.run import Attempt, Outcome, PlannedItem
from gyrotest.records.spec import DecisionRule, Limit
from gyrotest.runner.bench import Bench, OpenSource
from gyrotest.runner.channels import Share, configured
from gyrotest.runner.flow import UnitRun
from gyrotest.runner.folder import item_file_name
from gyrotest.runner.items import Moment
from gyrotest.runner.taking import origin_of
from gyrotest.units import Dimension, parse_quantity, same_dimension

T = TypeVar("T")


class GyroInstrument:
    """The source that reads the unit under test. A fault is tried to be mended once, by reconnecting."""

    def __init__(self, session: GyroSession, serial_number: str) -> None:
        self._session = session
        self._serial_number = serial_number
        _stage(
            session,
            serial_number,
            "instrument",
            1,
            Plan(warm_up_s=0.0, interval_s=1.0, steps=(Step(samples=3600),)),
        )

    @property
    def identity(self) -> Identity:
        """Who answers at the address."""
        return self._opened().use.identity

    def read(self, interval: str = "1 s") -> float:
        """One sample (the mean over `interval`), in the source's unit (V or deg/s)."""
        return float(self._mended(lambda opened: self._one(opened, interval)).values[-1, 0])

    def query(self, command: str) -> str:
        """Send a command to the instrument and return its reply; raises `InstrumentError`."""
        return self._mended(lambda opened: _query(opened, command))

    def _opened(self) -> OpenSource:
        run = self._session.runs[self._serial_number]
        return self._session.bench().source(run.header.slot, self._serial_number)

    def _mended(self, use: Callable[[OpenSource], T]) -> T:
        opened = self._opened()
        try:
            return use(opened)
        except InstrumentError:
            self._session.bench().drop(opened)
            return use(self._opened())

    def _one(self, opened: OpenSource, interval: str) -> Block:
        opened.source.configure(parse_quantity(interval, Dimension.TIME).to("s"))
        opened.source.start(0, 1)
        block = opened.source.fetch()
        if block is None:
            raise InstrumentError(f"{opened.use.resource}: no sample came")
        return block


def _query(opened: OpenSource, command: str) -> str:
    query: Callable[[str], str] | None = getattr(opened.source, "query", None)
    if query is None:
        raise InstrumentError(f"{opened.use.resource}: a '{opened.use.driver}' takes no commands")
    return query(command)


class GyroAcquire:
    """Acquires records for a user's own test; they are kept with the run."""

    def __init__(self, session: GyroSession, serial_number: str, item: pytest.Item) -> None:
        self._session = session
        self._serial_number = serial_number
        self._item = item
        self._count = 0

    def __call__(self, *, duration: str, interval: str = "1 s") -> Samples:
        """Acquire and return the samples; raises `GyrotestError` where it cannot be finished."""
        plan = _plan(duration, interval)
        self._count += 1
        run, bench = self._session.runs[self._serial_number], self._session.bench()
        opened = bench.source(run.header.slot, self._serial_number)
        _stage(self._session, self._serial_number, self._item.nodeid, self._count, plan)
        try:
            slot = self._session.order.station.station.slots[run.header.slot]
            axes = self._session.order.spec.spec.output.axes
            (share,) = configured(opened, [slot], plan.interval_s, axes)
            header = self._header(run, bench, opened, plan, share)
            acquisition = Acquisition(
                source=opened.source,
                clock=bench.clock,
                progress=self._session.progress,
                tracks=(Track(run_folder=run.folder.path, header=header, columns=share.columns),),
                plan=plan,
            )
            (recording,) = acquisition.run()
        except GyrotestError:
            bench.drop(opened)
            raise
        self._put_on_record(run, opened, recording)
        return read_samples(run.folder.path / recording.path)

    def _put_on_record(self, run: UnitRun, opened: OpenSource, recording: Recording) -> None:
        """Enter the recording into the run, so that its hash is certified and verified."""
        name = f"{self._item.nodeid}, record {self._count}"
        run.folder.write_attempt(
            Attempt(
                item=name,
                number=len(run.folder.attempts(name)) + 1,
                outcome=Outcome.PASSED,
                started_utc=recording.header.started_utc,
                ended_utc=datetime.now(UTC),
                issued_utc=datetime.now(UTC),
                origin=origin_of(opened.use.identity),
                recording=recording,
                instruments=(opened.use,),
                remarks=("A user's own test acquired it, outside of the spec's plan and warm-up.",),
            )
        )

    def _header(
        self, run: UnitRun, bench: Bench, opened: OpenSource, plan: Plan, share: Share
    ) -> RecordingHeader:
        item = item_file_name(f"{self._item.nodeid}-{self._count}")
        return RecordingHeader(
            run_id=run.header.run_id,
            item=item,
            attempt=run.folder.next_recording(item),
            serial_number=self._serial_number,
            model=run.header.model,
            spec_sha256=run.header.spec.sha256,
            started_utc=bench.clock.utc(),
            planned_samples=plan.samples,
            sampling=share.sampling,
            source=opened.use.identity,
            meta=run.header.meta,
        )


class GyroVerify:
    """Judges values of a user's own test; all of them, before the test fails."""

    def __init__(self, session: GyroSession, run: UnitRun, item: pytest.Item) -> None:
        self._session = session
        self._run = run
        self._item = item
        self._results: list[JudgedResult] = []
        self._started = datetime.now(UTC)
        self._outcome = Outcome.INTERRUPTED
        before = run.folder.attempts(item.nodeid)
        self._number = len(before) + 1
        failed = [one for one in before if one.outcome is Outcome.FAILED]
        self.failed_before = f"attempt {failed[-1].number} failed and stands" if failed else ""
        self._write()

    def __call__(
        self,
        name: str,
        value: float,
        *,
        unit: str,
        min: str | None = None,  # noqa: A002 — the spec's own word
        max: str | None = None,  # noqa: A002 — the spec's own word
        expanded_uncertainty: float | None = None,
        decision: str = "simple",
    ) -> Verdict | None:
        """Put a value, in `unit`, on record and judge it; raises `GyrotestError` for a senseless limit."""
        dimension = _dimension_of(unit)
        limit = _limit(min, max, decision, dimension)
        measurand = Measurand(name=name, label=name.replace("_", " "), dimension=dimension, unit=unit)
        result = Result(
            name=name,
            label=measurand.label,
            value=float(value),
            unit=unit,
            expanded_uncertainty=expanded_uncertainty,
            condition="user's own test",
        )
        judged = judge(measurand, result, limit, case=self._item.name, repeat=None)
        self._results.append(judged)
        add_properties(self._item, [judged])
        return judged.verdict

    def not_met(self) -> list[str]:
        """A line for each limit that is not met."""
        return [line(one) for one in self._results if one.verdict not in {None, Verdict.PASS}]

    def close(self, outcome: Outcome, message: str) -> None:
        """Put the test on record with its outcome."""
        self._outcome = outcome
        self._write(message)

    def spoil(self, message: str) -> None:
        """Something went wrong around the test: it does not stand as passed."""
        if self._outcome is not Outcome.FAILED:
            self.close(Outcome.ERROR, message)

    def _write(self, message: str = "") -> None:
        if self.failed_before:
            return
        now = datetime.now(UTC)
        uses = self._session.instruments_used(self._run.header.slot)
        self._run.folder.write_attempt(
            Attempt(
                item=self._item.nodeid,
                number=self._number,
                outcome=self._outcome,
                started_utc=self._started,
                ended_utc=now,
                issued_utc=now,
                message=message,
                origin=origin_of(uses[0].identity) if uses else None,
                instruments=uses,
                results=tuple(self._results),
            )
        )


def _plan(duration: str, interval: str) -> Plan:
    interval_s = parse_quantity(interval, Dimension.TIME).to("s")
    duration_s = parse_quantity(duration, Dimension.TIME).to("s")
    samples = round(duration_s / interval_s) if interval_s > 0 else 0
    if samples < 1 or abs(samples * interval_s - duration_s) > 1e-9 * duration_s:
        raise AcquisitionError(
            f"gyro_acquire: a duration of {duration} is no whole number of intervals of {interval}"
        )
    return Plan(warm_up_s=0.0, interval_s=interval_s, steps=(Step(samples=samples),))


def _limit(low: str | None, high: str | None, decision: str, dimension: Dimension) -> Limit | None:
    if decision not in set(DecisionRule):
        raise GyrotestError(
            f"gyro_verify: decision '{decision}' is not known; accepted: {', '.join(DecisionRule)}"
        )
    if low is None and high is None:
        return None
    limit = Limit(
        min=None if low is None else parse_quantity(low),
        max=None if high is None else parse_quantity(high),
        decision=DecisionRule(decision),
    )
    if limit.min and limit.max and limit.min.to(dimension.value) > limit.max.to(dimension.value):
        raise GyrotestError(f"gyro_verify: min {low} is more than max {high}; nothing could pass")
    return limit


def _stage(session: GyroSession, serial_number: str, name: str, count: int, plan: Plan) -> None:
    bench, run = session.bench(), session.put_on_bench(serial_number)
    since_power_on_s = bench.clock.now_s() - bench.powered_on_s(run.header.slot)
    bench.stage(
        run.header.slot,
        serial_number,
        PlannedItem(name=name, case=name, repeat=count),
        moment=Moment(power_cycle=1, elapsed_s=since_power_on_s),
        plan=plan,
        case=None,
    )


def _dimension_of(unit: str) -> Dimension:
    return next((one for one in Dimension if same_dimension(unit, one.value)), Dimension.NUMBER)
