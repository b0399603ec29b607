"""What a scanner has in its memory: readings with time and channel, sorted into sweeps."""

import re
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gyrotest.errors import InstrumentProtocolError
from gyrotest.instruments.transport.conversation import shown

_FIELDS = 3
_READING = re.compile(rb"[+-]\d\.\d+E[+-]\d\d")
_TIME = re.compile(rb"\d+\.\d+")


@dataclass(frozen=True, slots=True, kw_only=True)
class Sweeps:
    """Whole sweeps: values and times since the scan's begin, (sweeps, channels) in the order of the scan."""

    values: NDArray[np.float64]
    times_s: NDArray[np.float64]


class SweepReader:
    """Takes the memory's content as it comes, a sweep's begin perhaps, and gives whole sweeps.

    `channels` are those of the scan list, in the order in which they are scanned.
    """

    def __init__(self, channels: tuple[int, ...], who: str) -> None:
        self._channels = np.array(channels)
        self._who = who
        self._rest: NDArray[np.float64] = np.empty((0, _FIELDS))

    def push(self, content: bytes) -> None:
        """Take a block's content; raises `InstrumentProtocolError`."""
        if content.strip():
            self._rest = np.concatenate((self._rest, _rows(content, self._who)))

    @property
    def sweeps(self) -> int:
        """Whole sweeps that are there."""
        return len(self._rest) // len(self._channels)

    def take(self, most: int) -> Sweeps:
        """The oldest whole sweeps, at most so many; raises `InstrumentProtocolError`."""
        count, width = min(most, self.sweeps), len(self._channels)
        rows = self._rest[: count * width].reshape(count, width, _FIELDS)
        wrong = np.flatnonzero((rows[:, :, 2] != self._channels).any(axis=1))
        if wrong.size:
            found = ", ".join(f"{one:.0f}" for one in rows[wrong[0], :, 2])
            raise InstrumentProtocolError(
                f"{self._who}: a sweep has the channels {found}, expected"
                f" {', '.join(map(str, self._channels))}; is another program reading its memory?"
            )
        self._rest = self._rest[count * width :]
        return Sweeps(values=rows[:, :, 0], times_s=rows[:, :, 1])


def _rows(content: bytes, who: str) -> NDArray[np.float64]:
    """Reading, time and channel of each; models differ in the order of the latter two."""
    fields = content.strip().split(b",")
    first = fields[:_FIELDS]
    timed = [place for place, text in enumerate(first) if place and _TIME.fullmatch(text)]
    if len(fields) % _FIELDS or len(timed) != 1 or not _READING.fullmatch(first[0]):
        raise InstrumentProtocolError(
            f"{who}: its memory holds {shown(content)}, expected a reading, its time and its channel each:"
            " +1.23456789E+00,00000000.017,101"
        )
    try:
        table = np.array(fields).reshape(-1, _FIELDS).astype(np.float64)
    except ValueError:
        raise InstrumentProtocolError(
            f"{who}: its memory holds something else than numbers: {shown(content)}"
        ) from None
    return table if timed == [1] else table[:, [0, 2, 1]]
