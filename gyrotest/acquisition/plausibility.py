"""Faults that are visible in the samples themselves: overload, not a number, a stuck reading."""

import numpy as np

from gyrotest.errors import InstrumentProtocolError, OverloadError
from gyrotest.records.recording import Block, SampleFlag, Sampling

STUCK_AFTER = 60


class Plausibility:
    """Watches the blocks of one acquisition; raises at the first sample that cannot be right.

    A source with a known noise of its own cannot give the same value for long: after
    `STUCK_AFTER` identical samples in a row the reading is stuck.
    """

    def __init__(self, name: str, sampling: Sampling) -> None:
        self._name = name
        self._sampling = sampling
        self._last: float | None = None
        self._repeated = 0

    def push(self, block: Block) -> None:
        """Look at a block; raises `OverloadError` or `InstrumentProtocolError`."""
        self._refuse_flags(block)
        if self._sampling.noise:
            self._refuse_stuck(block)

    def _refuse_flags(self, block: Block) -> None:
        bad = np.flatnonzero(block.flags)
        if not bad.size:
            return
        at = block.first + int(bad[0])
        if block.flags[bad[0]] & SampleFlag.OVERLOAD:
            limit = "" if self._sampling.range is None else f" (range {self._sampling.range:g} V)"
            raise OverloadError(
                f"{self._name}: overload at sample {at}{limit}; is the gyro connected and the range wide enough?"
            )
        raise OverloadError(
            f"{self._name}: sample {at} is not a number; look at the wiring and the source"
        )

    def _refuse_stuck(self, block: Block) -> None:
        for value in block.values[:, 0].tolist():
            self._repeated = self._repeated + 1 if value == self._last else 0
            self._last = value
            if self._repeated >= STUCK_AFTER:
                raise InstrumentProtocolError(
                    f"{self._name}: the reading is stuck at {value:.9g} {self._sampling.unit} for"
                    f" {STUCK_AFTER} samples; is the meter triggered and the gyro powered?"
                )
