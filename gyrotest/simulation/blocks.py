"""Blocks of the block protocol as a simulated acquisition system sends them."""

import struct
import zlib
from enum import IntFlag

import numpy as np
from numpy.typing import NDArray

_HEADER = struct.Struct("<4sHHIIIQ")
_SUM = struct.Struct("<I")
_MAGIC = b"GBLK"
_VERSION = 1
_SEQUENCES = 1 << 32
CLIPPED = 2**31 - 1
"""What stands, with its sign, for a sample beyond full scale."""


class BlockFlag(IntFlag):
    """What a block's header says of it."""

    NONE = 0
    OVERRUN = 1
    LAST = 2


class BlockWriter:
    """Writes one acquisition's blocks of so many channels, numbered through."""

    def __init__(self, channels: int) -> None:
        self._channels = channels
        self._sequence = 0

    def write(
        self,
        index: int,
        samples: NDArray[np.int32],
        flags: BlockFlag = BlockFlag.NONE,
        *,
        damaged: bool = False,
    ) -> bytes:
        """A block of samples, (n, channels), from this index on; a damaged one has a wrong sum."""
        payload = samples.astype("<i4", copy=False).tobytes()
        header = _HEADER.pack(
            _MAGIC, _VERSION, self._channels, flags, self._sequence, len(samples), index
        )
        total = zlib.crc32(payload, zlib.crc32(header))
        self._sequence = (self._sequence + 1) % _SEQUENCES
        return b"".join((header, _SUM.pack(total ^ damaged), payload))
