"""A running Allan deviation in words: its unit, its lowest point, its angle random walk."""

import math
from dataclasses import dataclass

import numpy as np

from gyrotest.plugin.running_allan import RunningCurve

_ROOT_HOUR = 60.0  # √s in a √h


@dataclass(frozen=True, slots=True, kw_only=True)
class DeviationUnit:
    """The unit in which a curve is shown."""

    name: str
    per_dps: float


def unit_of(curve: RunningCurve) -> DeviationUnit:
    """Return the unit that gives a curve readable numbers."""
    if float(curve.deviation_dps.max()) >= 1.0:
        return DeviationUnit(name="°/s", per_dps=1.0)
    return DeviationUnit(name="°/h", per_dps=3600.0)


def longest_certain_s(curve: RunningCurve) -> float:
    """Return the longest averaging time up to which the curve is certain; 0 if none is."""
    found = np.flatnonzero(curve.certain)
    return float(curve.tau_s[found[-1]]) if found.size else 0.0


def lowest_so_far(curve: RunningCurve | None) -> str:
    """Word the lowest point of a curve; empty while there is none."""
    if curve is None or curve.lowest is None:
        return ""
    lowest, unit = curve.lowest, unit_of(curve)
    falling = ", still falling" if curve.falling else ""
    return (
        f"lowest {_two_digits(lowest.deviation_dps * unit.per_dps)} {unit.name}"
        f" at τ = {_three_digits(lowest.tau_s)} s{falling}"
    )


def walk_so_far(curve: RunningCurve | None) -> str:
    """Word the angle random walk as it is read off a curve; empty while it cannot be.

    It is the apparent one: nothing is corrected for a meter's dead time.
    """
    if curve is None or curve.walk is None:
        return ""
    value = _two_digits(curve.walk.value_dps_rts * _ROOT_HOUR)
    return f"apparent angle random walk {value} °/√h at τ = {_three_digits(curve.walk.tau_s)} s"


def _two_digits(value: float) -> str:
    return f"{value:.{max(0, 1 - math.floor(math.log10(value)))}f}"


def _three_digits(value: float) -> str:
    return f"{float(f'{value:.3g}'):g}"
