"""How well a frequency response repeats: three standard deviations over runs, and its largest in the band."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gyrotest.analysis.response_curve import ResponseCurve

_Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True, kw_only=True)
class Largest:
    """The largest 3σ in the band, the 95 % interval of what underlies it, and what noise alone gives."""

    value: float
    at_hz: float
    lower_95: float
    upper_95: float
    noise: float


@dataclass(frozen=True, slots=True, kw_only=True)
class ResponseRepeatability:
    """3σ over runs at frequencies (n,): `amplitude` in %, `phase` in °."""

    frequency_hz: _Array
    amplitude_percent: _Array
    phase_deg: _Array
    amplitude: Largest
    phase: Largest


def response_repeatability(
    runs: Sequence[ResponseCurve], *, frequency_hz: _Array | None = None
) -> ResponseRepeatability:
    """Compare the fitted curves of two or more runs."""
    raise NotImplementedError
