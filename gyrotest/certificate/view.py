"""What the template fills in: a run record as texts, tables and images."""

from collections.abc import Iterator
from dataclasses import dataclass
from datetime import datetime
from pathlib import PureWindowsPath

from gyrotest.certificate import appendix, statement
from gyrotest.certificate.budgets import Budget, budgets
from gyrotest.certificate.case_tables import CaseTable, case_tables
from gyrotest.certificate.conditions import conditions
from gyrotest.certificate.datasheet import datasheet_tables
from gyrotest.certificate.equipment import NOT_STATED, Equipment, equipment
from gyrotest.certificate.looks import LOOKS, Look
from gyrotest.certificate.pictures import PictureGroup, picture_groups
from gyrotest.certificate.printing import printed_text
from gyrotest.certificate.procedure_table import TableView
from gyrotest.records.result import Verdict
from gyrotest.records.run import ExportedFile, RunRecord
from gyrotest.records.spec import OutputMode

_HASH_BEGINNING = 16
_NO_BREAK = "\N{NO-BREAK SPACE}"


@dataclass(frozen=True, slots=True, kw_only=True)
class Fact:
    """A line of an identification table."""

    name: str
    value: str


@dataclass(frozen=True, slots=True, kw_only=True)
class View:
    """Everything that is printed, in the order of the pages."""

    title: str
    maker: str
    certificate: str
    serial_number: str
    description: str
    specification: str
    watermark: str
    look: Look
    tally: str
    rule: str
    unit_facts: tuple[Fact, ...]
    test_facts: tuple[Fact, ...]
    banners: tuple[statement.Banner, ...]
    tables: tuple[CaseTable, ...]
    conformity: str
    decision_rules: tuple[str, ...]
    uncertainty: str
    operator: str
    tested_on: str
    conditions: tuple[str, ...]
    deviations: tuple[str, ...]
    pictures: tuple[PictureGroup, ...]
    datasheet: tuple[TableView, ...]
    equipment: tuple[Equipment, ...]
    budgets: tuple[Budget, ...]
    attempts: tuple[appendix.AttemptLine, ...]
    recordings: tuple[appendix.RecordingLine, ...]
    exports: tuple[ExportedFile, ...]
    hashes: tuple[Fact, ...]
    sha256: str
    sha256_beginning: str
    created: str
    keywords: str
    generator: str


def view(record: RunRecord, sha256: str) -> View:
    """Prepare a record, whose JSON has this hash, for the template."""
    header, spec = record.header, record.header.spec.spec
    station = header.station.station
    return View(
        title=spec.title,
        maker=station.laboratory or spec.manufacturer or station.name,
        certificate=record.run_id,
        serial_number=record.serial_number,
        description=spec.description,
        specification=f"{spec.document or _file_name(header.spec.path)} (SHA-256 {header.spec.sha256[:8]})",
        watermark=_watermark(record),
        look=LOOKS[record.verdict],
        tally=statement.tally(record),
        rule=statement.rule_names(record),
        unit_facts=tuple(_unit_facts(record)),
        test_facts=tuple(_test_facts(record)),
        banners=tuple(statement.banners(record)),
        tables=case_tables(record),
        conformity=statement.conformity(record),
        decision_rules=statement.decision_rules(record),
        uncertainty=statement.uncertainty(record),
        operator=header.operator,
        tested_on=f"{_ended(record):%Y-%m-%d}",
        conditions=conditions(record),
        deviations=statement.deviations(record),
        pictures=picture_groups(record),
        datasheet=datasheet_tables(record),
        equipment=equipment(record),
        budgets=budgets(record),
        attempts=appendix.attempts(record),
        recordings=appendix.recordings(record),
        exports=appendix.exports(record),
        hashes=(
            Fact(name="Run record (attached: run.json)", value=sha256),
            Fact(name=f"Spec {_file_name(header.spec.path)}", value=header.spec.sha256),
            Fact(name=f"Station {_file_name(header.station.path)}", value=header.station.sha256),
        ),
        sha256=sha256,
        sha256_beginning=sha256[:_HASH_BEGINNING],
        created=f"{record.issued_utc:%Y-%m-%dT%H:%M:%SZ}",
        keywords=f"SHA-256 {sha256}",
        generator=f"gyrotest {header.software.get('gyrotest', '')}".strip(),
    )


def _file_name(path: str) -> str:
    """The name alone: where the file lay is of no use to a certificate's reader."""
    return PureWindowsPath(path).name  # splits at either system's separator


def _watermark(record: RunRecord) -> str:
    marks = (
        ("SIMULATED", record.simulated),
        ("REPLAYED", record.replayed),
        ("INCOMPLETE", record.verdict is Verdict.INCOMPLETE),
    )
    return " · ".join(word for word, applies in marks if applies)


def _unit_facts(record: RunRecord) -> Iterator[Fact]:
    spec = record.header.spec.spec
    yield Fact(name="Model", value=record.model)
    yield Fact(name="Serial number", value=record.serial_number)
    if spec.manufacturer:
        yield Fact(name="Manufacturer", value=spec.manufacturer)
    output = spec.output
    nominal = [output.kind.value]
    nominal += [f"from {output.mode.value.replace('_', ' ')}s"] * (output.mode is not OutputMode.RATE)
    nominal += [f"axes {', '.join(output.axes)}"] * bool(output.axes)
    nominal += [
        str(one).replace(" ", _NO_BREAK)
        for one in (output.scale_factor, output.full_scale)
        if one is not None
    ]
    yield Fact(name="Output, nominal", value=printed_text(", ".join(nominal)))
    for key, value in record.header.meta.items():
        yield Fact(name=key[:1].upper() + key[1:], value=value)


def _test_facts(record: RunRecord) -> Iterator[Fact]:
    header, station = record.header, record.header.station.station
    performed = "Performed (virtual)" if record.simulated else "Performed"
    yield Fact(name=performed, value=_span(header.started_utc, _ended(record)))
    yield Fact(name="Issued", value=f"{record.issued_utc:%Y-%m-%d %H:%M} UTC")
    slot = f", slot {header.slot}" if header.slot else ""
    yield Fact(name="Station", value=f"{station.name}{slot}")
    if station.address:
        yield Fact(name="Place", value=station.address)
    ambient = ", ".join(f"{name} {value}" for name, value in station.ambient.items())
    yield Fact(name="Ambient", value=ambient or NOT_STATED)
    yield Fact(name="Operator", value=header.operator or NOT_STATED)
    versions = sorted(header.software.items(), key=lambda one: one[0] != "gyrotest")
    software = ", ".join(f"{name} {version}" for name, version in versions)
    yield Fact(name="Software", value=software or NOT_STATED)
    yield Fact(name="Attempt", value=_attempt(record))


def _attempt(record: RunRecord) -> str:
    header = record.header
    earlier = f"; earlier: {', '.join(header.earlier_runs)}" if header.earlier_runs else ""
    return f"{header.attempt} of this serial number{earlier}"


def _ended(record: RunRecord) -> datetime:
    ends = [attempt.ended_utc for item in record.items for attempt in item.attempts]
    return max(ends, default=record.header.started_utc)


def _span(begin: datetime, end: datetime) -> str:
    if begin == end:
        return f"begun {begin:%Y-%m-%d %H:%M} UTC"
    if begin.date() == end.date():
        return f"{begin:%Y-%m-%d %H:%M}–{end:%H:%M} UTC"
    return f"{begin:%Y-%m-%d %H:%M} – {end:%Y-%m-%d %H:%M} UTC"
