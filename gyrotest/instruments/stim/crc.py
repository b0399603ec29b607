"""The checksums of serial gyros over many frames at once.

A cyclic redundancy check is linear over GF(2): each byte adds a word that depends on its value and
its place alone. So a table for each place, and frames are checked column by column.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True, slots=True, kw_only=True)
class Crc:
    """A CRC, most significant bit first, no reflection, no final inversion.

    The message is filled up with zeros, which are not sent, to a multiple of `align` bytes.
    """

    width: int
    polynomial: int
    seed: int
    align: int = 1

    @property
    def size(self) -> int:
        """Its bytes in a frame."""
        return self.width // 8

    def of(self, message: bytes) -> int:
        """The checksum of one message."""
        padded = message + bytes(-len(message) % self.align)
        return self._run(self.seed, padded)

    def _run(self, register: int, message: bytes) -> int:
        top, mask = 1 << (self.width - 1), (1 << self.width) - 1
        for byte in message:
            register ^= byte << (self.width - 8)
            for _ in range(8):
                register = (register << 1 ^ self.polynomial if register & top else register << 1) & mask
        return register


CRC_8 = Crc(width=8, polynomial=0x07, seed=0xFF)
CRC_32_MPEG_2 = Crc(width=32, polynomial=0x04C11DB7, seed=0xFFFFFFFF, align=4)


class ColumnCheck:
    """Checks frames of one length: `size` bytes of message and the CRC, big-endian, behind them."""

    def __init__(self, crc: Crc, size: int) -> None:
        self._crc, self._size = crc, size
        self._constant = crc.of(bytes(size))
        self._tables = tuple(self._table(place) for place in range(size))

    def passes(self, columns: NDArray[np.uint8]) -> NDArray[np.bool_]:
        """Which frames are whole; `columns` (bytes, n), a frame in each column, at least message and CRC."""
        found = np.full(columns.shape[1], self._constant, dtype=np.uint32)
        for table, column in zip(self._tables, columns, strict=False):
            np.bitwise_xor(found, table[column], out=found)
        return np.asarray(found == self._sent(columns))

    def _sent(self, columns: NDArray[np.uint8]) -> NDArray[np.uint32]:
        sent = np.zeros(columns.shape[1], dtype=np.uint32)
        for column in columns[self._size : self._size + self._crc.size]:
            sent = np.asarray(sent << 8 | column, dtype=np.uint32)
        return sent

    def _table(self, place: int) -> NDArray[np.uint32]:
        """What each value of the byte at a place adds: by linearity the xor of what its bits add."""
        table = np.zeros(256, dtype=np.uint32)
        for bit in range(8):
            single = bytearray(self._size)
            single[place] = 1 << bit
            added = self._crc.of(bytes(single)) ^ self._constant
            table[np.arange(256) >> bit & 1 == 1] ^= np.uint32(added)
        return table
