"""Dead time: what a meter that looks away between readings does to white noise."""

import math
from dataclasses import dataclass


@dataclass(frozen=True, slots=True, kw_only=True)
class DeadTime:
    """The factor from the apparent to the true angle random walk, and its relative half-width."""

    factor: float
    half_width: float


def white_noise_inflation(*, aperture_s: float, interval_s: float) -> float:
    """Return by how much white rate noise reads too large: √(interval/aperture)."""
    return math.sqrt(interval_s / aperture_s)


def dead_time_correction(
    *, aperture_s: float, interval_s: float, reading_s: float, bandwidth_hz: float | None
) -> DeadTime | None:
    """Return the correction of the angle random walk for dead time, or None where it is not allowed.

    Parameters
    ----------
    aperture_s, interval_s
        Time integrated in each interval, and the interval.
    reading_s
        Aperture of one reading.
    bandwidth_hz
        The gyro's; None where not known.

    Notes
    -----
    White noise folds back as √(p/a) only where the gyro passes it: the bandwidth must exceed
    1/(2·reading). What a gyro of first order, time constant T = 1/(2π·bandwidth), holds back from a
    reading of length r is the share m = T/r·(1 − exp(−r/T)) of its variance: the correction is
    √(a/p)/√(1 − m). The order of the gyro's response is an assumption, so that the whole of the
    second factor is the half-width.
    """
    if aperture_s >= interval_s * (1.0 - 1e-9):
        return DeadTime(factor=1.0, half_width=0.0)
    if bandwidth_hz is None or bandwidth_hz <= 1.0 / (2.0 * reading_s):
        return None
    constants = 2.0 * math.pi * bandwidth_hz * reading_s
    held_back = -math.expm1(-constants) / constants
    passed = 1.0 / math.sqrt(1.0 - held_back)
    return DeadTime(factor=math.sqrt(aperture_s / interval_s) * passed, half_width=passed - 1.0)
