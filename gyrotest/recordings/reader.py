"""The reader of our own recordings: a Parquet file, or the folder of segments before it."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from gyrotest.errors import RecordingError
from gyrotest.recordings import parquet
from gyrotest.recordings.assembly import Assembly
from gyrotest.recordings.batches import read_batches, read_opening, segment_files
from gyrotest.recordings.digest import sha256_of
from gyrotest.recordings.journal import Rows
from gyrotest.recordings.layout import FOLDER
from gyrotest.recordings.tally import Tally, gaps_in
from gyrotest.records.recording import Recording, RecordingHeader, Samples, SampleStream, Sampling

__all__ = ["Recovery", "gaps_in", "iterate", "read_header", "read_samples", "recover", "stream_samples"]


@dataclass(frozen=True, slots=True, kw_only=True)
class Recovery:
    """What can be read of a folder of segments.

    `closed` is the word that the writer ended with, empty if it was killed. `lost_rows` were
    written and cannot be read, as far as later segments tell; `damage` says where, empty if nowhere.
    """

    recording: Recording
    closed: str
    lost_rows: int
    damage: tuple[str, ...]


def read_header(path: Path) -> RecordingHeader:
    """The header of a recording; raises `RecordingError`."""
    if path.is_dir():
        return read_opening(segment_files(path)[0]).header
    return parquet.read_facts(path).header


def iterate(path: Path, columns: Sequence[int] | None = None) -> Iterator[Rows]:
    """The rows of a recording, batch by batch, verified; raises `RecordingError` at damage.

    `columns` are the places of the values that are wanted, ascending (None: all).
    """
    if not path.is_dir():
        yield from parquet.iterate(path, columns)
        return
    for rows in _iterate_segments(path):
        yield rows if columns is None else replace(rows, values=rows.values[:, columns])


def read_samples(
    path: Path,
    *,
    columns: Sequence[int] | None = None,
    sampling: Sampling | None = None,
    own_time: bool = False,
) -> Samples:
    """A whole recording in memory; raises `RecordingError` if any of it is damaged.

    `columns` are the places of those that are read (None: all), ascending. `sampling` replaces the one
    in the header, and describes what is read. `own_time` also gives the time stamps.
    `Samples.index` is None where no sample is missing.
    """
    header = read_header(path)
    rows = parquet.read_facts(path).rows if path.is_file() else _count(path)
    count = len(header.sampling.columns if columns is None else columns)
    assembly = Assembly(rows, count, own_time=own_time)
    for part in iterate(path, columns):
        assembly.add(part)
    return assembly.samples(sampling or header.sampling)


def stream_samples(
    path: Path, *, columns: Sequence[int] | None = None, sampling: Sampling | None = None
) -> SampleStream:
    """A recording block by block; its blocks raise `RecordingError` if any of it is damaged.

    `columns` are the places of those that are read (None: all), ascending; `sampling` describes them.
    """
    header = read_header(path)
    described = sampling or header.sampling

    def blocks() -> Iterator[Samples]:
        for rows in iterate(path, columns):
            yield Samples(sampling=described, values=rows.values, flags=rows.flags, index=rows.index)

    rows = parquet.read_facts(path).rows if path.is_file() else _count(path)
    return SampleStream(sampling=described, samples=rows, blocks=blocks)


def recover(folder: Path) -> Recovery:
    """Read what segments hold up to the damage in each; changes nothing on the disk.

    Raises `RecordingError` only if not even the first header can be read.
    """
    files = segment_files(folder)
    header = read_opening(files[0]).header
    tally, damage, closed, lost = Tally(header.sampling.interval_s), [], "", 0
    for file in files:
        try:
            opening = read_opening(file)
            lost = opening.row - tally.rows
            tally.reasons[tally.last_index] = opening.reason
            closed = ""
            for batch in read_batches(file):
                tally.add(batch.rows)
                closed = batch.outcome
        except RecordingError as error:
            damage.append(str(error))
    recording = Recording(
        path=f"{FOLDER}/{folder.name}",
        sha256=sha256_of(folder),
        header=header,
        samples=tally.rows,
        complete=closed == "complete" and not (damage or lost),
        gaps=tuple(tally.gaps),
        flagged=tally.flagged,
        largest_lateness_s=tally.largest_lateness_s,
    )
    return Recovery(recording=recording, closed=closed, lost_rows=lost, damage=tuple(damage))


def _iterate_segments(folder: Path) -> Iterator[Rows]:
    row = 0
    for file in segment_files(folder):
        if (begins := read_opening(file).row) != row:
            raise RecordingError(
                f"{file}: begins with row {begins}, yet {row} rows come before: rows are lost"
            )
        for batch in read_batches(file):
            row += len(batch.rows)
            yield batch.rows


def _count(folder: Path) -> int:
    return sum(len(rows) for rows in _iterate_segments(folder))
