"""What makes a record unfit for any result: bad samples, a stuck reading, a dead output."""

import math

import numpy as np
from numpy.typing import NDArray

from gyrotest.analysis.continuity import stuck_stretch
from gyrotest.analysis.noise_model import NoiseModel
from gyrotest.errors import InsufficientDataError
from gyrotest.procedures.wording import engineering, plain
from gyrotest.records.recording import SampleFlag, Sampling

_METER_MARGIN = 3.0
_OF_A_STEP = 1.0 / math.sqrt(12.0)
_BETTER_BY_CHANCE = 1e-6


def refuse_bad(values: NDArray[np.float64], flags: NDArray[np.uint8], start: int) -> None:
    """Refuse samples that are flagged or not finite; `start` is the first one's place in the record."""
    if flags.any():
        bad = np.flatnonzero(flags)
        first = int(bad[0])
        kind = SampleFlag(int(flags[first])).name or "flagged"
        raise InsufficientDataError(
            f"sample {start + first} is flagged {kind.lower().replace('_', ' ')}"
            f" ({bad.size} of {flags.size} samples are); a result needs every sample"
        )
    if not np.isfinite(values.sum()) and not np.isfinite(values).all():
        first = int(np.flatnonzero(~np.isfinite(values))[0])
        raise InsufficientDataError(
            f"sample {start + first} is {values[first]}; a result needs every sample"
        )


def refuse_lifeless(values: NDArray[np.float64], sampling: Sampling, start: int) -> None:
    """Refuse a record that is no gyro's: constant, stuck, or no more than what reads it makes by itself.

    That is the meter's own noise, where it is known.
    """
    if values.min() == values.max():
        raise InsufficientDataError(
            f"all {values.size} samples read {plain(float(values[0]), 9)} {sampling.unit}: signal not"
            " distinguishable from the meter; is the gyro connected and powered?"
        )
    _refuse_stuck(values, sampling, start)
    spread = float(values.std(ddof=1))
    if sampling.noise is not None and spread < _METER_MARGIN * sampling.noise:
        raise InsufficientDataError(
            f"signal not distinguishable from the meter: its standard deviation is"
            f" {engineering(spread, sampling.unit)},"
            f" the meter's own noise {engineering(sampling.noise, sampling.unit)}"
            f" (at least {_METER_MARGIN:g} times that is expected); is the gyro connected and powered?"
        )


def rounding_complaint(values: NDArray[np.float64], step: float | None, unit: str) -> str:
    """Say why a record tells nothing of the gyro's noise: its samples vary less than rounding to steps does."""
    spread = float(values.std(ddof=1))
    if step is None or spread >= _OF_A_STEP * step:
        return ""
    return (
        f"not distinguishable from rounding: σ = {engineering(spread, unit)},"
        f" steps of {engineering(step, unit)}"
    )


def regularity_complaint(model: NoiseModel) -> str:
    """Ask whether a record is noise at all: chance gives a fit this good less than once in a million times."""
    if 1.0 - model.fit_probability >= _BETTER_BY_CHANCE:
        return ""
    return (
        f"The record's noise is more regular than noise can be (χ²/ν = {plain(model.misfit, 2)}): has it been"
        " smoothed, resampled or made up?"
    )


def _refuse_stuck(values: NDArray[np.float64], sampling: Sampling, start: int) -> None:
    stuck = stuck_stretch(values)
    if stuck is not None:
        raise InsufficientDataError(
            f"samples {start + stuck.start} … {start + stuck.stop - 1} all read"
            f" {plain(float(values[stuck.start]), 9)} {sampling.unit}: the reading is stuck,"
            " or its steps are too coarse for the noise"
        )
