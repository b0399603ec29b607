"""Dead time: what a meter that looks away between readings does to white noise."""

import math
from dataclasses import dataclass

_NEARLY_WHOLE = 0.98


@dataclass(frozen=True, slots=True, kw_only=True)
class DeadTime:
    """The factor from the apparent to the true angle random walk, and its relative half-width."""

    factor: float
    half_width: float


def dead_time_correction(
    *, reading_s: float, spacing_s: float, bandwidth_hz: float | None
) -> DeadTime | None:
    """Return the correction of the angle random walk for dead time, or None where it is not allowed.

    Parameters
    ----------
    reading_s
        Aperture a of one reading.
    spacing_s
        Time p from reading to reading, on average.
    bandwidth_hz
        The gyro's; None where not known.

    Notes
    -----
    White noise folds back as √(p/a) only where the gyro passes it: the bandwidth must exceed 1/(2a).
    What a gyro of first order passes, time constant T = 1/(2π·bandwidth), is inflated by the root of
    p · Σ C(k·p) over all k, C being the covariance of readings k·p apart (of unit white density at
    frequency 0); it goes to 1 with the dead time. The order of the gyro's response is an
    assumption, so that the whole departure from √(a/p) is the half-width.
    Below 2 % of dead time it does not matter whether noise is folded: the correction lies between
    √(a/p) and 1.
    """
    if reading_s >= spacing_s * (1.0 - 1e-9):
        return DeadTime(factor=1.0, half_width=0.0)
    white = math.sqrt(reading_s / spacing_s)
    if bandwidth_hz is not None and bandwidth_hz > 1.0 / (2.0 * reading_s):
        factor = 1.0 / math.sqrt(_inflation(reading_s, spacing_s, 1.0 / (2.0 * math.pi * bandwidth_hz)))
        return DeadTime(factor=factor, half_width=1.0 - white / factor)
    if reading_s >= _NEARLY_WHOLE * spacing_s:
        return DeadTime(factor=(1.0 + white) / 2.0, half_width=(1.0 - white) / (1.0 + white))
    return None


def _inflation(reading_s: float, spacing_s: float, constant_s: float) -> float:
    """p·[C(0) + 2·Σ C(k·p)] of first-order noise averaged over readings."""
    share = constant_s / reading_s
    filled = -math.expm1(-reading_s / constant_s)
    own = (1.0 - share * filled) / reading_s
    others = share * filled**2 / reading_s
    others *= math.exp(-(spacing_s - reading_s) / constant_s) / -math.expm1(-spacing_s / constant_s)
    return spacing_s * (own + others)
