"""What is made again from a run's folder: the certificate, and a judgement by another spec."""

from dataclasses import replace
from datetime import UTC, datetime
from pathlib import Path

from gyrotest.acquisition.progress import Silence
from gyrotest.certificate.pdf import write_certificate
from gyrotest.certificate.record import read_record
from gyrotest.errors import CertificateError, GyrotestError
from gyrotest.records.recording import Recording
from gyrotest.records.result import Verdict
from gyrotest.records.run import Attempt, Outcome, PlannedItem, RunHeader, RunRecord
from gyrotest.records.spec import SpecDocument
from gyrotest.runner.bench import Bench
from gyrotest.runner.flow import UnitRun
from gyrotest.runner.folder import ATTEMPTS, RECORD, RunFolder
from gyrotest.runner.items import planned_items
from gyrotest.runner.record import assemble, write_record


def report(path: Path) -> Path:
    """Make a run's certificate again from its record.

    The record of a run that was killed is put together from what it left; that of a finished run
    is not touched.
    """
    folder = RunFolder(path)
    record = read_run(path)
    if record.verdict is Verdict.INCOMPLETE and not list(path.glob("*.pdf")):
        record = assemble(folder, folder.header(), {}, whole="the run did not end by itself")
        write_record(folder, record)
    return write_certificate(record, path)


def read_run(path: Path) -> RunRecord:
    """Read `run.json` of a run's folder; raises `CertificateError`."""
    try:
        return read_record((path / RECORD).read_bytes())
    except CertificateError as error:
        raise CertificateError(f"{path / RECORD}: {error}") from error
    except OSError as error:
        raise CertificateError(
            f"{path / RECORD}: cannot be read ({error.strerror}); is '{path}' a run's folder?"
        ) from error


def judge_again(path: Path, spec: SpecDocument) -> tuple[RunRecord, Path]:
    """Judge a run's recordings by another spec, as an amendment in a folder of its own below the run."""
    original = read_run(path)
    if original.model != spec.spec.model:
        raise CertificateError(
            f"{path}: a {original.model} was measured, and {spec.path} is for a {spec.spec.model}"
        )
    folder = _amendment_folder(path)
    header = replace(
        original.header,
        run_id=f"{original.run_id}-{folder.path.name}",
        spec=spec,
        plan=planned_items(spec.spec, original.serial_number),
        deviations=(
            *original.header.deviations,
            f"Amendment: the recordings of {original.run_id} judged again by {Path(spec.path).name}.",
        ),
    )
    folder.write_header(header)
    _judge_items(original, folder, header)
    record = replace(assemble(folder, header, {}), amends=original.run_id)
    write_record(folder, record)
    return record, write_certificate(record, folder.path)


def _amendment_folder(path: Path) -> RunFolder:
    for count in range(1, 1000):
        folder = path / f"amendment-{count}"
        try:
            folder.mkdir()
        except FileExistsError:
            continue
        (folder / ATTEMPTS).mkdir()
        return RunFolder(folder)
    raise CertificateError(f"{path}: has a thousand amendments already")


def _judge_items(original: RunRecord, folder: RunFolder, header: RunHeader) -> None:
    before = {one.plan.name: one.last for one in original.items}
    run = UnitRun(folder=folder, header=header, bench=_no_bench, progress=Silence(), confirm=_nobody)
    for item in header.plan:
        attempt = before.get(item.name)
        if item.repeat is not None and attempt is not None and attempt.recording is not None:
            _judge_one(run, item, attempt, attempt.recording)
    for item in header.plan:
        if item.repeat is None:
            _judge_repeats(run, item)


def _judge_one(run: UnitRun, item: PlannedItem, attempt: Attempt, recording: Recording) -> None:
    outcome = Outcome.ACQUIRED if recording.complete else Outcome.INTERRUPTED
    run.folder.write_attempt(
        replace(
            attempt,
            number=1,
            outcome=outcome,
            message="",
            issued_utc=datetime.now(UTC),
            recording=replace(recording, path=f"../{recording.path}"),
            results=(),
            figures=(),
            exports=(),
        )
    )
    if recording.complete:
        try:
            run.judge(item, run.acquire(item))
        except GyrotestError as error:
            run.fail(item.name, str(error))


def _judge_repeats(run: UnitRun, item: PlannedItem) -> None:
    try:
        run.judge_repeats(item)
    except GyrotestError:
        return  # it is on record, with what it lacks


def _nobody(_text: str) -> None:
    raise CertificateError("judging again asks nobody for anything")


def _no_bench() -> Bench:
    raise CertificateError("judging again acquires nothing")
