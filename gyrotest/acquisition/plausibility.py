"""Faults that are visible in the samples themselves: overload, not a number, a stuck reading."""

import numpy as np

from gyrotest.errors import InstrumentProtocolError, OverloadError
from gyrotest.records.recording import Block, SampleFlag, Sampling

STUCK_AFTER = 60


class Plausibility:
    """Watches the blocks of one step; raises at the first sample that cannot be right.

    A source with a known noise of its own cannot give the same value for long: after
    `STUCK_AFTER` identical samples in a row the reading is stuck. Where the step `may_saturate`,
    overloaded and steady samples are what it looks for.
    """

    def __init__(self, name: str, sampling: Sampling, *, may_saturate: bool = False) -> None:
        self._name = name
        self._sampling = sampling
        self._may_saturate = may_saturate
        self._last: float | None = None
        self._repeated = 0

    def push(self, block: Block) -> None:
        """Look at a block; raises `OverloadError` or `InstrumentProtocolError`."""
        self._refuse_flags(block)
        if self._sampling.noise and not self._may_saturate:
            self._refuse_stuck(block)

    def _refuse_flags(self, block: Block) -> None:
        tolerated = int(SampleFlag.OVERLOAD) if self._may_saturate else 0
        bad = np.flatnonzero(block.flags & ~np.uint8(tolerated))
        if bad.size:
            flags = SampleFlag(int(block.flags[bad[0]]))
            raise OverloadError(f"{self._name}: {self._fault(flags, block.first + int(bad[0]))}")

    def _fault(self, flags: SampleFlag, at: int) -> str:
        if SampleFlag.OVERLOAD in flags:
            reach = self._sampling.range
            limit = "" if reach is None else f" (range {reach:g} {self._sampling.unit})"
            return f"overload at sample {at}{limit}; is the gyro connected and the range wide enough?"
        if SampleFlag.START_UP in flags:
            return f"the unit starts up anew at sample {at}; did its power fail?"
        if SampleFlag.FAULT in flags:
            return (
                f"the unit reports a channel error or a failed self-check at sample {at}, or a channel beside"
                " its output (an encoder's) is clipped there"
            )
        return f"sample {at} is not a number; look at the wiring and the source"

    def _refuse_stuck(self, block: Block) -> None:
        # Step by step: most blocks of a meter are one sample, for which arrays cost ten times as much.
        for value in block.values[:, 0].tolist():
            self._repeated = self._repeated + 1 if value == self._last else 0
            self._last = value
            if self._repeated >= STUCK_AFTER:
                raise InstrumentProtocolError(
                    f"{self._name}: the reading is stuck at {value:.9g} {self._sampling.unit} for"
                    f" {STUCK_AFTER} samples; is the meter triggered and the gyro powered?"
                )
