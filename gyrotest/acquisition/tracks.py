"""The tracks of an acquisition: each unit's share of what one source gives, in a recording of its own."""

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from gyrotest.errors import GyrotestError
from gyrotest.recordings.writer import RecordingWriter
from gyrotest.records.recording import Block, Dwell, Gap, Recording, RecordingHeader


@dataclass(frozen=True, slots=True, kw_only=True)
class Track:
    """Where a unit's samples go, and which of the source's columns they are (none given: all)."""

    run_folder: Path
    header: RecordingHeader
    columns: tuple[int, ...] = ()


class Tracks:
    """Recordings that are written side by side."""

    def __init__(self, tracks: tuple[Track, ...]) -> None:
        self._tracks = tracks
        self._writers: list[RecordingWriter] = []
        try:
            for track in tracks:
                self._writers.append(RecordingWriter(track.run_folder, track.header))
        except GyrotestError:
            self.close(complete=False)
            raise

    def push(self, block: Block) -> Block:
        """Record a block, and return the first unit's share of it; raises `RecordingError`."""
        shares = [_share(block, track.columns) for track in self._tracks]
        for share, writer in zip(shares, self._writers, strict=True):
            writer.push(share)
        return shares[0]

    def new_segment(self, gap: Gap) -> None:
        """Go on after a gap; raises `RecordingError`."""
        for writer in self._writers:
            writer.new_segment(gap)

    def dwell(self, dwell: Dwell) -> None:
        """Put a step that was carried out on record."""
        for writer in self._writers:
            writer.dwell(dwell)

    def close(self, *, complete: bool) -> tuple[Recording, ...]:
        """End all recordings; the same answer when asked again; raises `RecordingError`."""
        return tuple(writer.close(complete=complete) for writer in self._writers)


def _share(block: Block, columns: tuple[int, ...]) -> Block:
    if not columns:
        return block
    return replace(block, values=np.ascontiguousarray(block.values[:, columns]))
