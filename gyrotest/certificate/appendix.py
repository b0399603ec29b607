"""What stands behind the results: the attempts, and hashes of the data."""

from dataclasses import dataclass

from gyrotest.certificate.numbers import plain
from gyrotest.records.recording import Recording
from gyrotest.records.run import ExportedFile, Outcome, RunRecord


@dataclass(frozen=True, slots=True, kw_only=True)
class AttemptLine:
    """One try at an item."""

    item: str
    number: int
    outcome: str
    begun: str
    ended: str
    message: str


@dataclass(frozen=True, slots=True, kw_only=True)
class RecordingLine:
    """A file of raw data."""

    path: str
    samples: str
    missing: str
    sha256: str


def attempts(record: RunRecord) -> tuple[AttemptLine, ...]:
    """List all attempts where an item needed more than one, or one of them did not finish."""
    unfinished = {Outcome.ERROR, Outcome.INTERRUPTED, Outcome.SKIPPED}
    telling = any(
        len(item.attempts) > 1 or any(one.outcome in unfinished for one in item.attempts)
        for item in record.items
    )
    return tuple(
        AttemptLine(
            item=item.plan.name,
            number=attempt.number,
            outcome=attempt.outcome.value,
            begun=f"{attempt.started_utc:%Y-%m-%d %H:%M:%S}",
            ended=f"{attempt.ended_utc:%Y-%m-%d %H:%M:%S}",
            message=attempt.message,
        )
        for item in record.items
        for attempt in item.attempts
        if telling
    )


def recordings(record: RunRecord) -> tuple[RecordingLine, ...]:
    """List the raw data of all attempts."""
    files = [one.recording for item in record.items for one in item.attempts if one.recording]
    return tuple(
        RecordingLine(
            path=one.path,
            samples=f"{plain(one.samples)} of {plain(one.header.planned_samples)} samples{_steps(one)}",
            missing=plain(sum(gap.missing for gap in one.gaps)),
            sha256=one.sha256 or "not closed",
        )
        for one in files
    )


def exports(record: RunRecord) -> tuple[ExportedFile, ...]:
    """List the files for other programs of all attempts."""
    return tuple(one for item in record.items for attempt in item.attempts for one in attempt.exports)


def _steps(recording: Recording) -> str:
    return f" in {len(recording.dwells)} steps" if len(recording.dwells) > 1 else ""
