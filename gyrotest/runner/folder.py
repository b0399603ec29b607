"""A run's folder: the record, the attempts, the recordings. Files appear by rename, none is overwritten.

Each attempt is a small file of its own, so that several processes can work on one run; the record
is put together from these files and from nothing else.
"""

import hashlib
import json
import os
from collections.abc import Mapping
from dataclasses import dataclass
from datetime import datetime
from functools import cache
from itertools import count
from pathlib import Path
from typing import TYPE_CHECKING, TypeVar

from gyrotest.errors import CertificateError, RefusedError
from gyrotest.recordings.layout import FOLDER as RECORDINGS
from gyrotest.recordings.layout import recording_name
from gyrotest.records.plan import Export
from gyrotest.records.run import Attempt, ExportedFile, ItemRecord, Outcome, PlannedItem, RunHeader

if TYPE_CHECKING:
    from pydantic import TypeAdapter

T = TypeVar("T")

RECORD = "run.json"
HEADER = "plan.json"
ATTEMPTS = "attempts"
EXPORTS = "exports"
_LONGEST = 120


@dataclass(frozen=True, slots=True)
class RunFolder:
    """The folder of one run of one serial number."""

    path: Path

    @classmethod
    def create(cls, out: Path, serial_number: str, model: str, started_utc: datetime) -> "RunFolder":
        """Make a new folder `<serial>/<UTC>-<model>`; two runs in one second get two folders."""
        stem = f"{started_utc:%Y%m%dT%H%M%SZ}-{safe_name(model)}"
        for number in range(1, 1000):
            path = out / serial_number / (stem if number == 1 else f"{stem}-{number}")
            try:
                path.parent.mkdir(parents=True, exist_ok=True)
                path.mkdir()
                (path / ATTEMPTS).mkdir()
                (path / RECORDINGS).mkdir()
            except FileExistsError:
                continue
            except OSError as error:
                raise RefusedError(
                    f"{path}: the run's folder cannot be made ({error.strerror}); give another with --gyro-out"
                ) from error
            return cls(path)
        raise RefusedError(f"{out / serial_number / stem}: a thousand runs in one second are too many")

    def write_header(self, header: RunHeader) -> None:
        """Write what is known before the first sample."""
        write_by_rename(self.path / HEADER, _header_adapter().dump_json(header, indent=1))

    def header(self) -> RunHeader:
        """Read it back; raises `CertificateError`."""
        return _read(self.path / HEADER, _header_adapter())

    def write_attempt(self, attempt: Attempt) -> None:
        """Write, or replace, an attempt."""
        name = f"{item_file_name(attempt.item)}-a{attempt.number}.json"
        data = _attempt_adapter().dump_python(attempt, mode="json")
        text = json.dumps(data, ensure_ascii=False, allow_nan=False, separators=(",", ":"))
        write_by_rename(self.path / ATTEMPTS / name, text.encode())

    def attempts(self, item: str) -> tuple[Attempt, ...]:
        """Every attempt at an item, oldest first."""
        files = (self.path / ATTEMPTS).glob(f"{item_file_name(item)}-a*.json")
        found = (_read(path, _attempt_adapter()) for path in files)
        return tuple(sorted((one for one in found if one.item == item), key=lambda one: one.number))

    def write_export(self, item: str, axis: str, export: Export) -> ExportedFile:
        """Write a file for other programs; its name begins with the item's and the axis."""
        folder = self.path / EXPORTS
        folder.mkdir(exist_ok=True)
        name = "-".join(
            part for part in (item_file_name(item), safe_name(axis), safe_name(export.name)) if part
        )
        data = export.text.encode()
        write_by_rename(folder / name, data)
        return ExportedFile(path=f"{EXPORTS}/{name}", sha256=hashlib.sha256(data).hexdigest())

    def next_recording(self, item: str) -> int:
        """Return the number of the first attempt at an item that has no recording yet."""
        names = {path.name.removesuffix(".parquet") for path in (self.path / RECORDINGS).iterdir()}
        return next(number for number in count(1) if recording_name(item, number) not in names)

    def unplanned(self, plan: tuple[PlannedItem, ...]) -> tuple[PlannedItem, ...]:
        """Items that were attempted beside the plan: a user's own tests."""
        known = {one.name for one in plan}
        found = (_read(path, _attempt_adapter()) for path in (self.path / ATTEMPTS).glob("*.json"))
        beside = (one for one in found if one.item not in known)
        names = dict.fromkeys(one.item for one in sorted(beside, key=lambda one: one.started_utc))
        return tuple(
            PlannedItem(name=name, case=name.rpartition("::")[2], repeat=None) for name in names
        )

    def item_records(self, header: RunHeader, missing: Mapping[str, str]) -> tuple[ItemRecord, ...]:
        """The plan's items, and those beside it, with their attempts and why they are missing."""
        return tuple(
            _item_record(one, self.attempts(one.name), missing)
            for one in (*header.plan, *self.unplanned(header.plan))
        )


_UNFINISHED = {
    Outcome.ACQUIRED: "acquired, but not judged",
    Outcome.INTERRUPTED: "interrupted",
    Outcome.SKIPPED: "skipped",
    Outcome.ERROR: "error",
}


def _item_record(
    plan: PlannedItem, attempts: tuple[Attempt, ...], missing: Mapping[str, str]
) -> ItemRecord:
    if not attempts:
        return ItemRecord(plan=plan, missing=missing.get(plan.name, "not run"))
    last = attempts[-1]
    if last.outcome not in _UNFINISHED:
        return ItemRecord(plan=plan, attempts=attempts)
    reason = ": ".join(part for part in (_UNFINISHED[last.outcome], last.message) if part)
    return ItemRecord(plan=plan, attempts=attempts, missing=reason)


def safe_name(text: str) -> str:
    """The text with everything but letters, digits, `.`, `_` and `-` replaced."""
    return "".join(one if one.isascii() and (one.isalnum() or one in "._-") else "_" for one in text)


def item_file_name(item: str) -> str:
    """A file name for an item; one for each, also where items differ only in what names may not hold."""
    plain = safe_name(item)
    if plain == item and len(item) <= _LONGEST:
        return item
    return f"{plain[:_LONGEST]}-{hashlib.sha256(item.encode()).hexdigest()[:8]}"


def write_by_rename(path: Path, data: bytes) -> None:
    """Write a file aside and rename it into place, so that a reader sees all of it or nothing."""
    aside = path.with_name(f".{path.name}.{os.getpid()}.part")
    try:
        with aside.open("wb") as stream:
            stream.write(data)
            stream.flush()
            os.fsync(stream.fileno())
        aside.replace(path)
    except OSError as error:
        aside.unlink(missing_ok=True)
        raise CertificateError(f"{path}: cannot be written ({error.strerror})") from error


def _read(path: Path, adapter: "TypeAdapter[T]") -> T:
    from pydantic import ValidationError

    try:
        return adapter.validate_json(path.read_bytes())
    except OSError as error:
        raise CertificateError(
            f"{path}: cannot be read ({error.strerror}); is this a run's folder?"
        ) from error
    except ValidationError as error:
        first = error.errors()[0]
        where = ".".join(str(part) for part in first["loc"])
        raise CertificateError(f"{path}: damaged at '{where}' ({first['msg']})") from error


@cache
def _header_adapter() -> "TypeAdapter[RunHeader]":
    from pydantic import TypeAdapter

    return TypeAdapter(RunHeader)


@cache
def _attempt_adapter() -> "TypeAdapter[Attempt]":
    from pydantic import TypeAdapter

    return TypeAdapter(Attempt)
