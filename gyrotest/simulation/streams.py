"""Random streams: one for each purpose, named by what it depends on and by nothing else."""

import hashlib

import numpy as np
from numpy.typing import NDArray

_BUFFER = 8192


def generator(seed: int, purpose: str, *names: str | int) -> np.random.Generator:
    """A generator seeded by a stable hash of the seed, a purpose and the names."""
    text = "\x1f".join((str(seed), purpose, *(str(name) for name in names)))
    digest = hashlib.sha256(text.encode()).digest()
    return np.random.default_rng(np.random.SeedSequence(int.from_bytes(digest, "big")))


class Normals:
    """Standard normal numbers in the same order however many are taken at a time."""

    def __init__(self, source: np.random.Generator) -> None:
        self._source = source
        self._buffer: NDArray[np.float64] = np.empty(0)
        self._used = 0

    def take(self, count: int) -> NDArray[np.float64]:
        """The next `count` numbers, (count,); a view that the caller does not change."""
        end = self._used + count
        if end > self._buffer.size:
            self._refill(count)
            end = count
        taken = self._buffer[self._used : end]
        self._used = end
        return taken

    def _refill(self, count: int) -> None:
        left = self._buffer[self._used :]
        # Whole buffers only, so that the order does not depend on the sizes asked for.
        buffers = -(-(count - left.size) // _BUFFER)
        self._buffer = np.concatenate([left, self._source.standard_normal(buffers * _BUFFER)])
        self._used = 0
