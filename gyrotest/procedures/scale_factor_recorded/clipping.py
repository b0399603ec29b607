"""Outputs that stood at their limit in a turn."""

import numpy as np
from numpy.typing import NDArray

from gyrotest.analysis.resolution import digital_step
from gyrotest.analysis.turn import Parts
from gyrotest.errors import InsufficientDataError
from gyrotest.procedures.scale_factor_recorded.outputs import Outputs
from gyrotest.procedures.wording import plain
from gyrotest.records.plan import Context

_FEWEST = 5
_LEAPS = 3.0


def refuse_clipped_turn(outputs: Outputs, parts: Parts, rest_level: float, context: Context) -> None:
    """Raise `InsufficientDataError` where the greatest output of a turn is a plateau with leaps on both sides.

    The top of a smooth turn has small steps beside it; what was cut off is entered and left in leaps.
    """
    turn = outputs.values[parts.begin : parts.end]
    sign = 1.0 if abs(turn.max() - rest_level) >= abs(turn.min() - rest_level) else -1.0
    run = _longest_top(sign * turn)
    if run.size >= _FEWEST and _leaps(turn, run):
        raise InsufficientDataError(
            f"{context.case_name}: {run.size} samples from sample {int(outputs.place[parts.begin + run[0]])} on"
            f" all read {plain(float(turn[run[0]]), 6)} {outputs.unit}: the output stood at its limit; turn"
            " more slowly"
        )


def _longest_top(values: NDArray[np.float64]) -> NDArray[np.intp]:
    """Return the longest run of samples that read the greatest value."""
    top = np.flatnonzero(values == values.max())
    return max(np.split(top, np.flatnonzero(np.diff(top) != 1) + 1), key=len)


def _leaps(turn: NDArray[np.float64], run: NDArray[np.intp]) -> bool:
    if run[0] == 0 or run[-1] == turn.size - 1:
        return True
    sides = abs(turn[run[0]] - turn[run[0] - 1]), abs(turn[run[-1]] - turn[run[-1] + 1])
    return bool(min(sides) > _LEAPS * (digital_step(turn) or 0.0))
