"""Frames in a stream of bytes: found, checked, and found again after garbage."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gyrotest.instruments.stim.decoding import FrameDecoder

# Places that are tried at once when frames are looked for.
_SEARCHED = 4096
# Bytes of garbage that are kept, to tell from them what is wrong.
_KEPT = 4096


@dataclass(frozen=True, slots=True, kw_only=True)
class Framed:
    """Whole frames in the order of their arrival, (n, size), and how many broken ones lay before each, (n,)."""

    frames: NDArray[np.uint8]
    broken: NDArray[np.int64]


@dataclass(slots=True, kw_only=True)
class Counts:
    """What was wrong with the stream so far."""

    broken: int = 0
    resynchronised: int = 0
    skipped_bytes: int = 0


class Framer:
    """Keeps step with the frames of a stream.

    In step, a frame that fails its check is broken if the next one lies where it should. Out of step, a
    frame counts only if another follows it: the eight bits of the shorter checksum fit by chance too often.
    """

    def __init__(self, decoder: FrameDecoder) -> None:
        self._decoder = decoder
        self._size = decoder.size
        self.counts = Counts()
        self.restart()

    def restart(self) -> None:
        """Forget what has arrived; what comes first may be part of a frame."""
        self._rest = np.empty(0, dtype=np.uint8)
        self._in_step = False
        self._begun = False
        self._skipped = 0
        self._broken_here = False
        self._garbage = bytearray()

    @property
    def waiting(self) -> int:
        """Bytes that have arrived and wait for the rest of their frame."""
        return len(self._rest)

    def skipped(self) -> bytes:
        """The latest bytes that belong to no frame."""
        return bytes(self._garbage) + self._rest.tobytes()

    def forget(self) -> None:
        """Count anew."""
        self.counts = Counts()

    def push(self, data: bytes) -> Framed:
        """Take bytes as they arrive; returns the frames that are complete by now."""
        arrived = np.frombuffer(data, dtype=np.uint8)
        stream = np.concatenate((self._rest, arrived)) if len(self._rest) else arrived
        found: list[Framed] = []
        place = 0
        while True:
            if not self._in_step:
                place = self._search(stream, place)
            if not self._in_step:
                break
            taken, run = self._follow(stream, place)
            found += run
            self._begun = self._begun or bool(run)
            place += taken
            if self._in_step:
                break
        self._rest = stream[place:].copy()
        return _joined(found, self._size)

    def _follow(self, stream: NDArray[np.uint8], place: int) -> tuple[int, list[Framed]]:
        """Take the frames that lie one behind the other; gives the bytes taken, and loses step at garbage."""
        count = (len(stream) - place) // self._size
        rows = stream[place : place + count * self._size].reshape(count, self._size)
        whole = self._decoder.whole(rows)
        if whole.all():
            broken = np.zeros(count, dtype=np.int64)
            if count and self._skipped:
                broken[0] = self._back_in_step()
            return count * self._size, [Framed(frames=rows, broken=broken)] if count else []
        good = np.flatnonzero(whole)
        gaps = np.diff(good, prepend=-1) - 1
        lost = np.flatnonzero(gaps > 0)
        # In step all the same: one broken frame and the next one whole. Anything longer is searched.
        long = lost[gaps[lost] > 1]
        ends = len(good) if not len(long) else int(long[0])
        broken = gaps[:ends].astype(np.int64)
        self.counts.broken += int(broken.sum())
        if ends and self._skipped:
            broken[0] += self._back_in_step()
        taken = (int(good[ends - 1]) + 1) * self._size if ends else 0
        run = [Framed(frames=rows[good[:ends]], broken=broken)] if ends else []
        behind = count - taken // self._size
        if behind > 1 or ends < len(good):
            self._lose_step(stream, place + taken)
        return taken, run

    def _lose_step(self, stream: NDArray[np.uint8], place: int) -> None:
        self._in_step = False
        self._broken_here = bool(stream[place] == self._decoder.frame.identifier)

    def _back_in_step(self) -> int:
        """Frames lost in the garbage that was skipped: counted where it began like a frame."""
        skipped, self._skipped = self._skipped, 0
        if not self._begun:
            return 0
        in_place = skipped % self._size == 0
        lost = max(1, round(skipped / self._size)) if self._broken_here or in_place else 0
        self.counts.resynchronised += not in_place
        self.counts.broken += lost
        self.counts.skipped_bytes += skipped
        return lost

    def _search(self, stream: NDArray[np.uint8], place: int) -> int:
        """Where two whole frames lie one behind the other, and in step then; else where to search on."""
        last = len(stream) - 2 * self._size
        for begin in range(place, last + 1, _SEARCHED):
            found = self._first_pair(stream, begin, min(begin + _SEARCHED, last + 1))
            if found is not None:
                self._skipped += found - place
                self._garbage.clear()
                self._in_step = True
                return found
        on = max(place, last + 1)
        self._skipped += on - place
        self._garbage += stream[place:on].tobytes()
        del self._garbage[:-_KEPT]
        return on

    def _first_pair(self, stream: NDArray[np.uint8], begin: int, end: int) -> int | None:
        likely = begin + np.flatnonzero(stream[begin:end] == self._decoder.frame.identifier)
        likely = likely[stream[likely + self._size] == self._decoder.frame.identifier]
        rows = stream[likely[:, None] + np.arange(2 * self._size)]
        pairs = self._decoder.whole(rows[:, : self._size]) & self._decoder.whole(rows[:, self._size :])
        return int(likely[pairs][0]) if pairs.any() else None


def _joined(found: list[Framed], size: int) -> Framed:
    if len(found) == 1:
        return found[0]
    if not found:
        return Framed(frames=np.empty((0, size), dtype=np.uint8), broken=np.empty(0, dtype=np.int64))
    return Framed(
        frames=np.concatenate([one.frames for one in found]),
        broken=np.concatenate([one.broken for one in found]),
    )
