"""The check of a run's recordings: what is whole, incomplete, damaged, missing or altered."""

import json
from collections.abc import Iterator
from dataclasses import dataclass, replace
from enum import StrEnum
from pathlib import Path
from typing import Any

from gyrotest.errors import RecordingError
from gyrotest.recordings import parquet
from gyrotest.recordings.digest import sha256_of
from gyrotest.recordings.layout import FOLDER, SEGMENT_SUFFIX
from gyrotest.recordings.reader import Recovery, iterate, recover

RECORD = "run.json"


class State(StrEnum):
    """What became of a recording, from best to worst."""

    COMPLETE = "complete"
    INCOMPLETE = "incomplete"
    ALTERED = "altered"
    DAMAGED = "damaged"
    MISSING = "missing"


@dataclass(frozen=True, slots=True, kw_only=True)
class Finding:
    """What was found of one recording. `sha256_agrees` is None where no record tells its hash."""

    path: str
    state: State
    rows: int
    message: str
    sha256_agrees: bool | None = None

    @property
    def good(self) -> bool:
        """Whether nothing is wrong with it: complete, and as the record says."""
        return self.state is State.COMPLETE

    def __str__(self) -> str:
        return f"{self.path}: {self.state.value}, {self.rows} samples: {self.message}"


@dataclass(frozen=True, slots=True, kw_only=True)
class _Listed:
    sha256: str | None
    samples: int


def verify_folder(path: Path) -> tuple[Finding, ...]:
    """Verify every recording of a run's folder, of all runs below a folder, or one recording.

    Raises `RecordingError` if there is nothing to verify or the run's record cannot be read.
    """
    if not path.exists():
        raise RecordingError(f"{path}: does not exist")
    findings = _verified_run(path)
    if not findings and path.is_dir():
        findings = [one for run in _runs_below(path) for one in _verified_below(run, path)]
    if not findings:
        raise RecordingError(
            f"{path}: holds no recordings ({FOLDER}/*.parquet or folders of *{SEGMENT_SUFFIX})"
        )
    return tuple(findings)


def _verified_run(path: Path) -> list[Finding]:
    """Findings of one run, or of one recording; empty where there is none."""
    run_folder, found = _recordings(path)
    listed = _listed(run_folder / RECORD)
    findings = [_verified(one, listed) for one in found]
    if found != (path,):
        findings += [
            Finding(
                path=name,
                state=State.MISSING,
                rows=0,
                message=f"{RECORD} lists it; the file is not there",
            )
            for name in listed
            if not (run_folder / name).exists()
        ]
    return findings


def _runs_below(path: Path) -> list[Path]:
    return sorted(one.parent for one in path.rglob(FOLDER) if one.is_dir() and one.parent != path)


def _verified_below(run: Path, path: Path) -> list[Finding]:
    """Findings of one run of several: a record that cannot be read does not hide the other runs."""
    name = run.relative_to(path).as_posix()
    try:
        return [replace(one, path=f"{name}/{one.path}") for one in _verified_run(run)]
    except RecordingError as error:
        message = f"the run's recordings cannot be held against it: {error}"
        return [Finding(path=f"{name}/{RECORD}", state=State.DAMAGED, rows=0, message=message)]


def _recordings(path: Path) -> tuple[Path, tuple[Path, ...]]:
    """The run's folder and the recordings asked for."""
    if path.is_file() or any(path.glob(f"*{SEGMENT_SUFFIX}")):
        return path.absolute().parent.parent, (path,)
    folder = path / FOLDER if (path / FOLDER).is_dir() else path
    folders = [one for one in folder.iterdir() if one.is_dir() and any(one.glob(f"*{SEGMENT_SUFFIX}"))]
    return folder.absolute().parent, tuple(sorted([*folders, *folder.glob("*.parquet")]))


def _listed(record: Path) -> dict[str, _Listed]:
    if not record.is_file():
        return {}
    try:
        return dict(_entries(json.loads(record.read_text(encoding="utf-8"))))
    except (OSError, ValueError, KeyError, TypeError) as error:
        raise RecordingError(f"{record}: cannot be read as a run record: {error}") from error


def _entries(record: Any) -> Iterator[tuple[str, _Listed]]:
    for item in record["items"]:
        for attempt in item["attempts"]:
            if (one := attempt.get("recording")) is not None:
                yield one["path"], _Listed(sha256=one["sha256"], samples=one["samples"])


def _verified(path: Path, listed: dict[str, _Listed]) -> Finding:
    name = f"{FOLDER}/{path.name}"
    known = listed.get(name)
    finding = _of_segments(path, name) if path.is_dir() else _of_parquet(path, name)
    return finding if known is None else _compared(finding, path, known)


def _of_parquet(path: Path, name: str) -> Finding:
    rows = 0
    try:
        facts = parquet.read_facts(path)
        for part in iterate(path):
            rows += len(part)
    except RecordingError as error:
        return Finding(path=name, state=State.DAMAGED, rows=rows, message=str(error))
    missing = sum(gap.missing for gap in facts.gaps)
    message = f"{len(facts.gaps)} gaps, {missing} samples missing" if facts.gaps else "no gaps"
    return Finding(path=name, state=State.COMPLETE, rows=rows, message=message)


def _of_segments(folder: Path, name: str) -> Finding:
    try:
        found = recover(folder)
    except RecordingError as error:
        return Finding(path=name, state=State.DAMAGED, rows=0, message=str(error))
    state = State.COMPLETE if found.recording.complete else State.INCOMPLETE
    state = State.DAMAGED if found.damage or found.lost_rows else state
    return Finding(path=name, state=state, rows=found.recording.samples, message=_told(found))


def _told(found: Recovery) -> str:
    rows, planned = found.recording.samples, found.recording.header.planned_samples
    if found.damage or found.lost_rows:
        lost = (f"at least {found.lost_rows} samples are lost",) if found.lost_rows else ()
        return "; ".join((*found.damage, *lost, f"{rows} of {planned} are readable"))
    if not found.closed:
        return f"the writer was stopped before the end; the first {rows} of {planned} are intact"
    if not found.recording.complete:
        return f"ended early, {rows} of {planned} planned"
    return "not yet converted to Parquet"


def _compared(finding: Finding, path: Path, known: _Listed) -> Finding:
    agrees = None if known.sha256 is None else sha256_of(path) == known.sha256
    altered = agrees is False or known.samples != finding.rows
    state, message = finding.state, finding.message
    if altered and state is not State.DAMAGED:
        state = State.ALTERED
        message = f"{RECORD} lists {known.samples} samples and another content (SHA-256)"
    return Finding(
        path=finding.path, state=state, rows=finding.rows, message=message, sha256_agrees=agrees
    )
