"""The channels of a vibration test, made ready: at one instant each, the encoder decoded, dwell by dwell."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gyrotest.analysis.ellipse import Ellipse
from gyrotest.procedures.scaling import Scaling
from gyrotest.records.plan import Context
from gyrotest.records.recording import Dwell, SampleStream

ENCODER = "encoder_"
"""How the names of an encoder's channels begin: what a plan asks for beside the output."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Piece:
    """Consecutive samples of a dwell, the `number`th of the recording (from 0).

    `first` is the position of the first sample on the acquisition's grid. `output` (n,) is the gyro's less
    the nominal one at rest, in `scaling.unit`; `angle_deg` (n,) the table's, which goes on from the piece
    before unless this one `begins` a stretch.
    """

    number: int
    dwell: Dwell
    first: int
    begins: bool
    output: NDArray[np.float64]
    angle_deg: NDArray[np.float64]


@dataclass(frozen=True, slots=True, kw_only=True)
class VibrationChannels:
    """Output and angle of a vibration test; `ellipse` is None where the encoder gives the angle itself."""

    stream: SampleStream
    context: Context
    scaling: Scaling
    ellipse: Ellipse | None

    @property
    def interval_s(self) -> float:
        """Time from sample to sample, s."""
        return self.stream.sampling.interval_s

    @property
    def rate_hz(self) -> float:
        """Sampling rate, Hz."""
        return 1.0 / self.interval_s

    def pieces(self) -> Iterator[Piece]:
        """Give every dwell's samples in their order; may be called again.

        Where samples are missing inside a dwell, a new stretch begins.

        Raises
        ------
        InsufficientDataError
            The encoder is starved of samples, or lost its signal.
        """
        raise NotImplementedError


def vibration_channels(
    stream: SampleStream, context: Context, *, highest_hz: float
) -> VibrationChannels:
    """Look through a recording once and make its channels ready.

    `highest_hz` is the highest working frequency.

    Raises
    ------
    InsufficientDataError
        The source is not synchronous, there is no encoder, sampling is too slow without an analogue
        filter, the output is clipped or stuck, samples are bad, some are missing and the case refuses
        gaps, the encoder's signals give no ellipse.
    """
    raise NotImplementedError
