"""What a user's own tests beside a spec work with: an instrument, acquisitions, judged values."""

from collections.abc import Callable
from datetime import UTC, datetime
from typing import TypeVar

import pytest

from gyrotest.acquisition.acquire import Acquisition
from gyrotest.acquisition.progress import Silence
from gyrotest.conformity import judge, line
from gyrotest.errors import InstrumentError
from gyrotest.plugin.session import GyroSession
from gyrotest.recordings.reader import read_samples
from gyrotest.records.plan import Plan
from gyrotest.records.recording import Block, Identity, RecordingHeader, Samples
from gyrotest.records.result import JudgedResult, Measurand, Result, Verdict
from gyrotest.records.run import Attempt, Outcome, PlannedItem
from gyrotest.records.spec import DecisionRule, Limit
from gyrotest.runner.bench import OpenSource
from gyrotest.runner.items import Moment
from gyrotest.units import Dimension, parse_quantity, same_dimension

T = TypeVar("T")


class GyroInstrument:
    """The source that reads the unit under test. A fault is tried to be mended once, by reconnecting."""

    def __init__(self, session: GyroSession, serial_number: str) -> None:
        self._session = session
        self._serial_number = serial_number
        _stage(
            session, serial_number, "instrument", 1, Plan(warm_up_s=0.0, interval_s=1.0, samples=3600)
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
        interval_s = parse_quantity(interval, Dimension.TIME).to("s")
        samples = round(parse_quantity(duration, Dimension.TIME).to("s") / interval_s)
        self._count += 1
        run, bench = self._session.runs[self._serial_number], self._session.bench()
        opened = bench.source(run.header.slot, self._serial_number)
        plan = Plan(warm_up_s=0.0, interval_s=interval_s, samples=samples)
        _stage(self._session, self._serial_number, self._item.nodeid, self._count, plan)
        header = RecordingHeader(
            run_id=run.header.run_id,
            item=f"{self._item.nodeid}-{self._count}",
            attempt=len(run.folder.attempts(self._item.nodeid)) + 1,
            serial_number=self._serial_number,
            model=run.header.model,
            spec_sha256=run.header.spec.sha256,
            started_utc=bench.clock.utc(),
            planned_samples=samples,
            sampling=opened.source.configure(interval_s),
            source=opened.use.identity,
        )
        recording = Acquisition(
            source=opened.source,
            clock=bench.clock,
            progress=Silence(),
            run_folder=run.folder.path,
            header=header,
            plan=plan,
        ).run()
        return read_samples(run.folder.path / recording.path)


class GyroVerify:
    """Judges values of a user's own test; all of them, before the test fails."""

    def __init__(self, session: GyroSession, serial_number: str, item: pytest.Item) -> None:
        self._run = session.runs[serial_number]
        self._item = item
        self._session = session
        self._results: list[JudgedResult] = []
        self._started = datetime.now(UTC)
        self._number = len(self._run.folder.attempts(item.nodeid)) + 1
        self._write(Outcome.INTERRUPTED)

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
        limit = Limit(
            min=None if min is None else parse_quantity(min),
            max=None if max is None else parse_quantity(max),
            decision=DecisionRule(decision),
        )
        measurand = Measurand(
            name=name, label=name.replace("_", " "), dimension=_dimension_of(unit), unit=unit
        )
        result = Result(
            name=name,
            label=measurand.label,
            value=float(value),
            unit=unit,
            expanded_uncertainty=expanded_uncertainty,
            condition="user's own test",
        )
        judged = judge(
            measurand, result, limit if min or max else None, case=self._item.name, repeat=None
        )
        self._results.append(judged)
        return judged.verdict

    def not_met(self) -> list[str]:
        """A line for each limit that is not met."""
        return [line(one) for one in self._results if one.verdict not in {None, Verdict.PASS}]

    def close(self, outcome: Outcome | None = None, message: str = "") -> None:
        """Put the test on record with its outcome; without one it stays as it is."""
        if outcome is not None:
            self._write(outcome, message)

    def _write(self, outcome: Outcome, message: str = "") -> None:
        now = datetime.now(UTC)
        self._run.folder.write_attempt(
            Attempt(
                item=self._item.nodeid,
                number=self._number,
                outcome=outcome,
                started_utc=self._started,
                ended_utc=now,
                issued_utc=now,
                message=message,
                origin=None,
                results=tuple(self._results),
            )
        )


def _stage(session: GyroSession, serial_number: str, name: str, count: int, plan: Plan) -> None:
    bench, run = session.bench(), session.put_on_bench(serial_number)
    since_power_on_s = bench.clock.now_s() - bench.powered_on_s
    bench.stage(
        run.header.slot,
        serial_number,
        PlannedItem(name=name, case=name, repeat=count),
        moment=Moment(power_cycle=1, elapsed_s=since_power_on_s),
        plan=plan,
    )


def _dimension_of(unit: str) -> Dimension:
    return next((one for one in Dimension if same_dimension(unit, one.value)), Dimension.NUMBER)
