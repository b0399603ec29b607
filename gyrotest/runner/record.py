"""The run record, put together from the run's folder: verdict, results, what is missing."""

from collections.abc import Mapping
from datetime import UTC, datetime

from gyrotest.certificate.record import record_bytes
from gyrotest.conformity import worst
from gyrotest.records.result import JudgedResult, Verdict
from gyrotest.records.run import SCHEMA_VERSION, ItemRecord, Origin, RunHeader, RunRecord
from gyrotest.runner.folder import RECORD, RunFolder, write_by_rename


def assemble(
    folder: RunFolder, header: RunHeader, missing: Mapping[str, str], *, whole: str = ""
) -> RunRecord:
    """Put the record together.

    `missing` gives the reason for items that did not run; `whole` one that makes all of the run
    incomplete (an interruption, an internal error).
    """
    items = folder.item_records(header, missing)
    lacking = tuple(f"{one.plan.name}: {one.missing}" for one in items if one.missing)
    lacking = (*lacking, whole) if whole else lacking
    results = tuple(result for one in items if one.last for result in one.last.results)
    origins = {attempt.origin for one in items for attempt in one.attempts}
    return RunRecord(
        schema_version=SCHEMA_VERSION,
        run_id=header.run_id,
        model=header.model,
        serial_number=header.serial_number,
        verdict=Verdict.INCOMPLETE if lacking or not items else _verdict(items, results),
        simulated=Origin.SIMULATED in origins or header.station.station.simulation is not None,
        replayed=Origin.REPLAYED in origins,
        issued_utc=datetime.now(UTC),
        header=header,
        items=items,
        results=results,
        missing=lacking,
    )


def _verdict(items: tuple[ItemRecord, ...], results: tuple[JudgedResult, ...]) -> Verdict:
    """The worst verdict; a failed item fails the run even where none of its results does."""
    verdicts = [one.verdict for one in results if one.verdict is not None]
    failed = [Verdict.FAIL for one in items if one.failed]
    return worst([*verdicts, *failed]) if verdicts or failed else Verdict.INCOMPLETE


def write_record(folder: RunFolder, record: RunRecord) -> None:
    """Replace `run.json` atomically."""
    write_by_rename(folder.path / RECORD, record_bytes(record))
