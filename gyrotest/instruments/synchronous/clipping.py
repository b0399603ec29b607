"""What a clipped channel makes of a sample: an overload where it is a gyro's, a fault where it is beside."""

import numpy as np
from numpy.typing import NDArray

from gyrotest.instruments.streaming.flow import many
from gyrotest.instruments.synchronous.choice import Choice
from gyrotest.records.recording import SampleFlag


class Clipping:
    """Flags samples, and counts those in which a channel beside the outputs was clipped."""

    def __init__(self, choice: Choice) -> None:
        self._outputs = choice.outputs
        self._counts = dict.fromkeys(choice.names[choice.outputs :], 0)

    def flags(self, clipped: NDArray[np.bool_]) -> NDArray[np.uint8]:
        """The flags (n,) of samples of which these channels (n, columns) were clipped."""
        flags = np.zeros(len(clipped), dtype=np.uint8)
        outputs = self._outputs
        flags[clipped[:, :outputs].any(axis=1)] |= np.uint8(SampleFlag.OVERLOAD)
        # What is beside the outputs is their reference: without it a sample is worth nothing.
        flags[clipped[:, outputs:].any(axis=1)] |= np.uint8(SampleFlag.FAULT)
        for at, name in enumerate(self._counts, start=outputs):
            self._counts[name] += int(np.count_nonzero(clipped[:, at]))
        return flags

    def remarks(self) -> list[str]:
        """Which channels beside the outputs were clipped, and how often."""
        return [
            f"'{name}' is clipped in {many(count, 'sample')}"
            for name, count in self._counts.items()
            if count
        ]
