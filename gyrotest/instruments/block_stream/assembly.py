"""Blocks of samples put on the grid: what is missing stays missing, what was clipped is flagged."""

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from gyrotest.errors import InstrumentError, InstrumentProtocolError
from gyrotest.instruments.block_stream.messages import CLIPPED, Packet
from gyrotest.instruments.synchronous.choice import Choice
from gyrotest.instruments.synchronous.clipping import Clipping
from gyrotest.records.recording import Block

_SEQUENCES = 1 << 32


@dataclass(slots=True)
class Losses:
    """How many samples were lost in how many places."""

    samples: int = 0
    places: int = 0

    def add(self, samples: int) -> None:
        """Lose some more, in one place."""
        self.samples += samples
        self.places += 1


@dataclass(slots=True)
class _Run:
    """Rows without a gap, the first of which has this position."""

    first: int
    rows: list[NDArray[np.int32]] = field(default_factory=list)


class Assembly:
    """Makes samples of one acquisition's packets, which `begin` anew at each start of the source."""

    def __init__(self, who: str, choice: Choice, interval_s: float) -> None:
        self._who, self._interval_s = who, interval_s
        self._factors = np.array(choice.factors)
        self.overrun, self.on_the_way = Losses(), Losses()
        self.clipping = Clipping(choice)
        self.begin(0, 0)

    def begin(self, first: int, end: int) -> None:
        """The source's sample 0 has the position `first`; samples up to `end - 1` are asked for."""
        self._base, self.end = first, end
        self.position, self._sequence = first, 0
        self.ended = first >= end
        self._runs: list[_Run] = []

    def take(self, packet: Packet) -> None:
        """Put a packet in its place; raises `InstrumentError` where it has none."""
        first, count = self._base + packet.index, len(packet.raw)
        self._refuse_wrong(packet, first, count)
        missing = first - self.position
        if packet.overrun:
            self.overrun.add(missing)
        elif missing:
            self.on_the_way.add(missing)
        if count:
            if missing or not self._runs:
                self._runs.append(_Run(first))
            self._runs[-1].rows.append(packet.raw)
        self._sequence = (packet.sequence + 1) % _SEQUENCES
        self.position = first + count
        self.ended = packet.last or self.position == self.end
        if self.ended and self.position < self.end:
            raise InstrumentError(
                f"{self._who}: ended after {self.position - self._base} of {self.end - self._base} samples;"
                " has somebody stopped it?"
            )

    def block(self) -> Block | None:
        """The next samples without a gap, of what was taken; None where nothing is left."""
        if not self._runs:
            return None
        run = self._runs.pop(0)
        raw = run.rows[0] if len(run.rows) == 1 else np.concatenate(run.rows)
        position = np.arange(run.first, run.first + len(raw), dtype=np.float64)
        return Block(
            first=run.first,
            time_s=position * self._interval_s,
            values=raw * self._factors,
            flags=self._flags(raw),
        )

    def _flags(self, raw: NDArray[np.int32]) -> NDArray[np.uint8]:
        if raw.max() < CLIPPED and raw.min() > -CLIPPED:
            return np.zeros(len(raw), dtype=np.uint8)
        return self.clipping.flags((raw >= CLIPPED) | (raw <= -CLIPPED))

    def _refuse_wrong(self, packet: Packet, first: int, count: int) -> None:
        behind = (packet.sequence - self._sequence) % _SEQUENCES >= _SEQUENCES // 2
        if first < self.position or behind:
            raise InstrumentProtocolError(
                f"{self._who}: block {packet.sequence} with sample {packet.index} comes after block"
                f" {self._sequence - 1} and sample {self.position - self._base - 1}; did it start anew?"
            )
        if first + count > self.end:
            raise InstrumentProtocolError(
                f"{self._who}: gives {packet.index + count} samples of {self.end - self._base} asked for"
            )
        if packet.overrun and first == self.position:
            raise InstrumentProtocolError(
                f"{self._who}: says that samples were lost before sample {packet.index}, but not how many: its"
                " index goes on; where the samples after it belong is not known"
            )
