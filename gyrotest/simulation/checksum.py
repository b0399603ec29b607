"""The checksums at the end of a digital gyro's frames, for many frames at once."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True, slots=True, kw_only=True)
class Checksum:
    """A CRC with its most significant bit first, nothing reflected and nothing inverted at the end.

    The message is followed by zeros, which are not sent, up to a multiple of `padded` bytes.
    """

    size: int
    polynomial: int
    start: int
    padded: int = 1

    def table(self) -> NDArray[np.uint32]:
        """What each value of the register's first byte becomes when it is shifted out, (256,)."""
        bits = 8 * self.size
        mask = (1 << bits) - 1
        made = []
        for value in range(256):
            register = value << (bits - 8)
            for _ in range(8):
                carried = register >> (bits - 1) & 1
                register = (register << 1 & mask) ^ (self.polynomial if carried else 0)
            made.append(register)
        return np.array(made, dtype=np.uint32)

    def of(self, message: bytes) -> bytes:
        """The checksum of one message."""
        table, bits = self.table().tolist(), 8 * self.size
        mask, register = (1 << bits) - 1, self.start
        for byte in message + bytes(-len(message) % self.padded):
            register = (register << 8 & mask) ^ table[register >> (bits - 8) ^ byte]
        return int(register).to_bytes(self.size, "big")


STIM210_CHECKSUM = Checksum(size=1, polynomial=0x07, start=0xFF)
STIM300_CHECKSUM = Checksum(size=4, polynomial=0x04C11DB7, start=0xFFFFFFFF, padded=4)


class FrameChecksum:
    """The checksums of frames of one length."""

    def __init__(self, checksum: Checksum, length: int) -> None:
        self.size = checksum.size
        table, bits = checksum.table(), 8 * checksum.size
        mask = np.uint32((1 << bits) - 1)
        # By linearity each byte adds what it alone, followed by zeros to the end, would leave.
        words = [table]
        for _ in range(length + -length % checksum.padded - 1):
            last = words[-1]
            words.append((last << np.uint32(8) & mask) ^ table[last >> np.uint32(bits - 8)])
        self._words = np.stack(words[::-1][:length])
        self._start = int.from_bytes(checksum.of(bytes(length)), "big")
        self._places = np.arange(length)[:, None]

    def of(self, columns: NDArray[np.uint8]) -> NDArray[np.uint8]:
        """The checksums of messages, (length, n), a message in each column; (size, n)."""
        found = np.bitwise_xor.reduce(self._words[self._places, columns], axis=0) ^ np.uint32(
            self._start
        )
        rows: NDArray[np.uint8] = found.astype(">u4").view(np.uint8).reshape(-1, 4)
        return rows.T[4 - self.size :]
