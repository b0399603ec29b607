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
    """Return the correction √(a/p) of the angle random walk, or None where it is not allowed.

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
    Noise folds back fully only where the gyro passes it: the bandwidth must exceed 1/(2·reading).
    Of the white noise that a reading takes in, 1/(π²·reading·bandwidth) lies above the bandwidth
    and may be missing; the half-width is half of that (a root), times the share that is folded.
    """
    if aperture_s >= interval_s * (1.0 - 1e-9):
        return DeadTime(factor=1.0, half_width=0.0)
    if bandwidth_hz is None or bandwidth_hz <= 1.0 / (2.0 * reading_s):
        return None
    folded = 1.0 - aperture_s / interval_s
    missing = 1.0 / (math.pi**2 * reading_s * bandwidth_hz)
    return DeadTime(factor=math.sqrt(aperture_s / interval_s), half_width=0.5 * folded * missing)
