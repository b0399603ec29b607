"""The writer of a recording: crash-safe segments while it runs, one Parquet file when complete."""

import logging
import shutil
import time
from collections.abc import Callable
from datetime import UTC, datetime
from pathlib import Path
from types import TracebackType
from typing import Self

from gyrotest.errors import RecordingError, RefusedError
from gyrotest.recordings.convert import segments_to_parquet
from gyrotest.recordings.digest import sha256_of
from gyrotest.recordings.facts import Facts
from gyrotest.recordings.journal import Journal, Rows, rows_of
from gyrotest.recordings.layout import BATCH_ROWS, FOLDER, recording_name
from gyrotest.recordings.tally import Tally
from gyrotest.records.recording import Block, Dwell, Gap, Recording, RecordingHeader

_log = logging.getLogger(__name__)

# Blocks that follow each other faster than this, in real time, share a batch (a simulated bench
# gives hours in seconds); slower ones are written at once.
GATHER_S = 0.5
SYNC_S = 5.0

# What must stay free for the record and the certificate.
_RESERVE_BYTES = 20_000_000


def _utc() -> datetime:
    return datetime.now(UTC)


def check_free_space(folder: Path, needed: int) -> None:
    """Raise `RefusedError` if the disk of a folder (or of where it will be) has not `needed` bytes."""
    there = next(place for place in (folder.absolute(), *folder.absolute().parents) if place.exists())
    free = shutil.disk_usage(there).free
    if free < needed + _RESERVE_BYTES:
        raise RefusedError(
            f"{folder}: {free / 1e6:.0f} MB are free on the disk, the recordings of this run may need "
            f"{(needed + _RESERVE_BYTES) / 1e6:.0f} MB; make room or choose another folder"
        )


class RecordingWriter:
    """A sink that keeps every block on the disk as it arrives.

    An existing recording is never touched. After a failed write (`RecordingError`) the batches
    before it are intact, nothing more is accepted and `close(complete=False)` says what was kept.
    """

    def __init__(
        self,
        run_folder: Path,
        header: RecordingHeader,
        *,
        monotonic_s: Callable[[], float] = time.monotonic,
        utc: Callable[[], datetime] = _utc,
    ) -> None:
        self._folder = run_folder / FOLDER / recording_name(header.item, header.attempt)
        self._target = self._folder.with_name(f"{self._folder.name}.parquet")
        self._header, self._monotonic_s = header, monotonic_s
        self._journal = Journal(self._folder, header, utc)
        self._tally = Tally(header.sampling.interval_s)
        self._dwells: list[Dwell] = []
        self._pending: list[Block] = []
        self._next_index = self._pending_rows = 0
        self._written_s = self._synced_s = float("-inf")
        self._failed = False
        self._recording: Recording | None = None
        self._begin()

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close(complete=False)

    def _begin(self) -> None:
        if self._target.exists() or self._folder.exists():
            raise RecordingError(
                f"{self._folder}: there is a recording of this attempt; it is not overwritten"
            )
        try:
            self._folder.mkdir(parents=True)
            self._journal.begin()
        except OSError as error:
            raise self._failure(error) from error

    def push(self, block: Block) -> None:
        """Take a block; raises `RecordingError` if it cannot be kept."""
        self._check_open()
        self._check(block)
        self._pending.append(block)
        self._pending_rows += len(block.flags)
        self._next_index = block.first + len(block.flags)
        due = self._monotonic_s() - self._written_s >= GATHER_S
        if due or self._pending_rows >= BATCH_ROWS:
            self.flush()

    def flush(self) -> None:
        """Write what was gathered and hand it to the operating system; raises `RecordingError`."""
        self._check_open()
        try:
            if self._pending:
                self._write(rows_of(self._pending))
            self._pending, self._pending_rows = [], 0
            self._written_s = self._monotonic_s()
            if self._written_s - self._synced_s >= SYNC_S:
                self._journal.sync()
                self._synced_s = self._written_s
        except OSError as error:
            raise self._failure(error) from error

    def new_segment(self, gap: Gap) -> None:
        """Go on in a new file after a restart; the samples then missing get `gap.reason`."""
        self.flush()
        self._tally.reasons[self._next_index - 1] = gap.reason
        try:
            self._journal.end("restart")
            self._journal.begin(gap.reason)
        except OSError as error:
            raise self._failure(error) from error

    def dwell(self, dwell: Dwell) -> None:
        """Put a step of the plan that was carried out on record."""
        self._dwells.append(dwell)

    def close(self, *, complete: bool) -> Recording:
        """End the recording; a complete one becomes Parquet. The same answer when asked again.

        Raises `RecordingError` if the last samples cannot be written; `close(complete=False)` then
        still tells what was kept.
        """
        if self._recording is None:
            if not self._failed:
                self._end(complete=complete)
            self._recording = self._kept(complete=complete and not self._failed)
        return self._recording

    def _end(self, *, complete: bool) -> None:
        try:
            self.flush()
            self._journal.end("complete" if complete else "incomplete")
        except (OSError, RecordingError) as error:
            failure = error if isinstance(error, RecordingError) else self._failure(error)
            if complete:
                raise failure from error
            _log.warning("%s", failure)

    def _kept(self, *, complete: bool) -> Recording:
        path = self._target if complete and self._converted() else self._folder
        return Recording(
            path=f"{FOLDER}/{path.name}",
            sha256=sha256_of(path),
            header=self._header,
            samples=self._journal.rows,
            complete=complete,
            gaps=tuple(self._tally.gaps),
            dwells=tuple(self._dwells),
            flagged=self._tally.flagged,
            largest_lateness_s=self._tally.largest_lateness_s,
        )

    def _converted(self) -> bool:
        """Whether the segments became Parquet; if not they stay, for nothing measured is lost."""
        try:
            segments_to_parquet(
                self._folder,
                self._target,
                Facts(
                    header=self._header,
                    rows=self._journal.rows,
                    gaps=tuple(self._tally.gaps),
                    dwells=tuple(self._dwells),
                ),
            )
        except (OSError, RecordingError) as error:
            _log.warning(
                "%s: stays as it was recorded, for it cannot become Parquet: %s", self._folder, error
            )
            return False
        return True

    def _write(self, rows: Rows) -> None:
        for start in range(0, len(rows), BATCH_ROWS):
            part = slice(start, start + BATCH_ROWS)
            batch = Rows(
                index=rows.index[part],
                time_s=rows.time_s[part],
                values=rows.values[part],
                flags=rows.flags[part],
            )
            self._journal.append(batch)
            self._tally.add(batch)

    def _check_open(self) -> None:
        if self._recording is not None:
            raise RecordingError(f"{self._folder}: the recording is closed")
        if self._failed:
            raise RecordingError(f"{self._folder}: an earlier write failed; nothing more is accepted")

    def _check(self, block: Block) -> None:
        if block.first < self._next_index:
            raise RecordingError(
                f"{self._folder}: sample {block.first} comes after sample {self._next_index - 1}; "
                f"positions only go forward"
            )
        expected = (len(block.flags), len(self._header.sampling.columns))
        if block.values.shape != expected or block.time_s.shape != expected[:1]:
            raise RecordingError(
                f"{self._folder}: a block has {block.values.shape} values, {block.time_s.shape} times; "
                f"its {expected[0]} flags and {expected[1]} channels ask for {expected}"
            )

    def _failure(self, error: OSError) -> RecordingError:
        self._failed = True
        self._journal.abandon()
        return RecordingError(
            f"{self._folder}: cannot be written ({error.strerror or error}); "
            f"the first {self._journal.rows} of {self._header.planned_samples} samples are kept"
        )
