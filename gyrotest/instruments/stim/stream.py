"""A stream of frames as readings, and what is wrong with one that gives none."""

import numpy as np

from gyrotest.instruments.stim.decoding import OUTSIDE_CONDITIONS, FrameDecoder
from gyrotest.instruments.stim.diagnosis import likely_cause
from gyrotest.instruments.stim.framing import Framer
from gyrotest.instruments.stim.models import COUNTER_MODULUS, TICKS_PER_SECOND, Model
from gyrotest.instruments.streaming.flow import many
from gyrotest.instruments.streaming.readings import Counter, Readings


class FrameStream:
    """Frames of one kind, found in bytes and decoded."""

    def __init__(self, model: Model, decoder: FrameDecoder) -> None:
        self._model, self._decoder = model, decoder
        self._framer = Framer(decoder)
        self._outside = 0
        self.reading_bytes = float(decoder.size)

    def restart(self) -> None:
        """Forget what has arrived."""
        self._framer.restart()

    def push(self, data: bytes) -> Readings:
        """Take bytes; returns the readings of the frames that are whole."""
        framed = self._framer.push(data)
        statuses = framed.frames[:, self._decoder.frame.statuses]
        self._outside += int(np.count_nonzero((statuses & OUTSIDE_CONDITIONS).any(axis=1)))
        decoded = self._decoder.decode(framed.frames, known_whole=True)
        counter = None if decoded.counter is None else decoded.counter.astype(np.int64)
        return Readings(values=decoded.values, flags=decoded.flags, counter=counter, lost=framed.broken)

    def waiting(self) -> int:
        """Bytes that wait for the rest of their frame."""
        return self._framer.waiting

    def complaint(self) -> str:
        """What arrived in place of frames, and the likely cause."""
        return likely_cause(self._framer.skipped(), self._model, self._decoder.frame)

    def forget(self) -> None:
        """Count anew."""
        self._framer.forget()
        self._outside = 0

    def remarks(self) -> tuple[str, ...]:
        """Broken frames and bytes that belong to none."""
        counts, told = self._framer.counts, []
        if counts.broken:
            told.append(f"{many(counts.broken, 'frame')} with bad CRC")
        if counts.resynchronised:
            told.append(
                f"step with the frames lost {many(counts.resynchronised, 'time')},"
                f" {counts.skipped_bytes} bytes skipped"
            )
        if self._outside:
            told.append(
                f"{many(self._outside, 'frame')} from outside the operating conditions, as the unit says"
            )
        return tuple(told)


def counter_of(decoder: FrameDecoder, sample_rate_hz: float) -> Counter | None:
    """The counter of this kind of frame: it counts the internal clock, and so by more than one."""
    if decoder.frame.counter is None:
        return None
    return Counter(modulus=COUNTER_MODULUS, step=round(TICKS_PER_SECOND / sample_rate_hz))
