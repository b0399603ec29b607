"""Scale-factor repeatability: the spread of the scale factor over the repeats, in proportion to it."""

import math

import numpy as np

from gyrotest.analysis.interval import deviation_bounds
from gyrotest.errors import InsufficientDataError
from gyrotest.records.plan import Context
from gyrotest.records.result import Result
from gyrotest.records.spec import Between

_PPM = 1e6


def scale_factor_repeatability(repeats: tuple[tuple[Result, ...], ...], context: Context) -> Result:
    """Return the sample standard deviation over the mean; raises `InsufficientDataError`.

    S3.4. The table's and the meter's errors are the same in all repeats, and do not join.
    """
    values = np.array(
        [
            one.value
            for results in repeats
            for one in results
            if one.name == "scale_factor" and one.value is not None and math.isfinite(one.value)
        ]
    )
    if values.size < max(len(repeats), 2):
        raise InsufficientDataError(
            f"{context.case_name}: {values.size} of {len(repeats)} repeats have a scale factor;"
            " its repeatability needs at least 2, and all of them"
        )
    if np.unique(values).size == 1:
        raise InsufficientDataError(
            f"{context.case_name}: all {values.size} repeats have the same scale factor to the last digit, as"
            " the same samples would give; was a recorded file played again?"
        )
    deviation = _PPM * float(values.std(ddof=1)) / abs(float(values.mean()))
    bounds = deviation_bounds(deviation, values.size - 1, confidence=0.95)
    cycled = context.case.between_repeats is Between.POWER_CYCLE
    return Result(
        name="scale_factor_repeatability",
        label="Scale-factor repeatability",
        value=deviation,
        unit="ppm",
        lower_95=float(bounds.lower),
        upper_95=float(bounds.upper),
        condition=f"{values.size} repeats, {'with' if cycled else 'no'} power cycle between",
    )
