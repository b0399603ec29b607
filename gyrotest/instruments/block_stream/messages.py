"""What a server of the block protocol sends, found in bytes as they arrive: replies and blocks of samples."""

import struct
import zlib
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gyrotest.errors import InstrumentProtocolError

MAGIC = b"GBLK"
VERSION = 1
HEADER = struct.Struct("<4sHHIIIQI")
MOST_SAMPLES = 65_536
CLIPPED = 2**31 - 1
_WORD = 4
_CHECKED = HEADER.size - _WORD
_LONGEST_LINE = 1 << 20
_BEGINNINGS = b"G{["


@dataclass(frozen=True, slots=True, kw_only=True)
class Reply:
    """A line of JSON."""

    line: bytes


@dataclass(frozen=True, slots=True, kw_only=True)
class Packet:
    """A block as it was sent: `raw` (n, channels) int32."""

    overrun: bool
    last: bool
    sequence: int
    index: int
    raw: NDArray[np.int32]


class Messages:
    """Splits what arrives. A block that is damaged is left out and counted in `damaged`."""

    def __init__(self, who: str) -> None:
        self.who = who
        self.channels = 0
        self.damaged = 0
        self.restart()

    def restart(self) -> None:
        """Forget what has arrived."""
        self._rest = b""
        self._astray = False

    @property
    def waiting(self) -> int:
        """Bytes that wait for the rest of their message."""
        return len(self._rest)

    def push(self, data: bytes) -> list[Reply | Packet]:
        """Take bytes; what is complete by now. Raises `InstrumentProtocolError`."""
        data, place, found = self._rest + data, 0, list[Reply | Packet]()
        while place < len(data):
            step = self._one(data, place, found)
            if not step:
                break
            place += step
        self._rest = data[place:]
        return found

    def _one(self, data: bytes, place: int, found: list[Reply | Packet]) -> int:
        """How far the message reaches that begins here; 0 where it is not complete."""
        if data[place] == _BEGINNINGS[0]:
            return self._packet(data, place, found)
        if data[place] not in _BEGINNINGS:
            return self._skipped(data, place, 0)
        end = data.find(b"\n", place)
        if end < 0:
            return 0 if len(data) - place < _LONGEST_LINE else self._skipped(data, place, 0)
        self._astray = False
        found.append(Reply(line=data[place:end]))
        return end + 1 - place

    def _packet(self, data: bytes, place: int, found: list[Reply | Packet]) -> int:
        if len(data) - place < HEADER.size:
            return 0
        magic, version, channels, flags, sequence, samples, index, crc = HEADER.unpack_from(data, place)
        if magic != MAGIC or samples > MOST_SAMPLES:
            return self._skipped(data, place, 0)
        self._refuse_other(version, channels)
        size: int = HEADER.size + _WORD * samples * channels
        if len(data) - place < size:
            return 0
        whole = memoryview(data)[place : place + size]
        if zlib.crc32(whole[HEADER.size :], zlib.crc32(whole[:_CHECKED])) != crc:
            return self._skipped(data, place, size)
        self._astray = False
        raw = np.frombuffer(data, "<i4", samples * channels, place + HEADER.size)
        found.append(
            Packet(
                overrun=bool(flags & 1),
                last=bool(flags & 2),
                sequence=sequence,
                index=index,
                raw=raw.reshape(samples, channels),
            )
        )
        return size

    def _refuse_other(self, version: int, channels: int) -> None:
        if version != VERSION:
            raise InstrumentProtocolError(
                f"{self.who}: speaks version {version} of the block protocol; version {VERSION} is"
                " understood: use a server of that version"
            )
        if channels != self.channels:
            raise InstrumentProtocolError(
                f"{self.who}: sends a block of {channels} channels; {self.channels} are configured"
            )

    def _skipped(self, data: bytes, place: int, size: int) -> int:
        """Pass over what is damaged: where something begins behind it, else to the next mark of a block."""
        if not self._astray:
            self.damaged += 1
        self._astray = True
        behind = data[place + size : place + size + 1]
        if size and (not behind or behind in _BEGINNINGS):
            return size
        mark = data.find(MAGIC, place + 1)
        return (mark if mark >= 0 else max(place + 1, len(data) - len(MAGIC) + 1)) - place
