"""What a decoder makes of a stream of bytes, and what it must tell so that lost readings are found."""

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True, slots=True, kw_only=True)
class Readings:
    """Consecutive readings as they arrived.

    `values` (n, columns) in the units of the sampling, `flags` (n,) `SampleFlag` as uint8, `counter` (n,)
    as sent (None: there is none), `lost` (n,) readings that are known to be lost right before each one.
    """

    values: NDArray[np.float64]
    flags: NDArray[np.uint8]
    counter: NDArray[np.int64] | None
    lost: NDArray[np.int64]

    def __len__(self) -> int:
        return len(self.flags)

    def part(self, part: slice) -> "Readings":
        """Some of them."""
        counter = None if self.counter is None else self.counter[part]
        return Readings(
            values=self.values[part], flags=self.flags[part], counter=counter, lost=self.lost[part]
        )

    def as_first(self) -> "Readings":
        """The same as the first ones of all: nothing is lost before them."""
        lost = self.lost.copy()
        lost[:1] = 0
        return Readings(values=self.values, flags=self.flags, counter=self.counter, lost=lost)


def joined(parts: list[Readings]) -> Readings:
    """Readings one after the other; at least one part."""
    if len(parts) == 1:
        return parts[0]
    counters = [part.counter for part in parts if part.counter is not None]
    return Readings(
        values=np.concatenate([part.values for part in parts]),
        flags=np.concatenate([part.flags for part in parts]),
        counter=np.concatenate(counters) if counters else None,
        lost=np.concatenate([part.lost for part in parts]),
    )


@dataclass(frozen=True, slots=True, kw_only=True)
class Counter:
    """A counter in each reading: it grows by `step` from one to the next, and begins anew at `modulus`."""

    modulus: int
    step: int

    @property
    def period(self) -> int:
        """Readings after which it begins anew."""
        return self.modulus // self.step


class Decoder(Protocol):
    """Finds readings in bytes as they arrive."""

    @property
    def reading_bytes(self) -> float:
        """Bytes of one reading, of the shortest where they differ."""

    def restart(self) -> None:
        """Forget what has arrived; what comes first may be part of a reading."""

    def push(self, data: bytes) -> Readings:
        """Take bytes; returns the readings that are complete by now."""

    def waiting(self) -> int:
        """Bytes that wait for the rest of their reading."""

    def complaint(self) -> str:
        """What is wrong with bytes that make no readings, and the likely cause."""

    def remarks(self) -> tuple[str, ...]:
        """What was wrong with the bytes since the last `forget`; empty where nothing was."""

    def forget(self) -> None:
        """Count anew."""
