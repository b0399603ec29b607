"""The units in which rates and times are drawn, so that their numbers are of ordinary size."""

from dataclasses import dataclass

_SMALL_RATE_DPS = 0.5


@dataclass(frozen=True, slots=True, kw_only=True)
class Unit:
    """A unit to draw in: how many of them make 1 °/s, or 1 s."""

    name: str
    factor: float


def rate_unit(largest_dps: float) -> Unit:
    """Return °/h for small rates, °/s for others."""
    if largest_dps < _SMALL_RATE_DPS:
        return Unit(name="°/h", factor=3600.0)
    return Unit(name="°/s", factor=1.0)


def time_unit(duration_s: float) -> Unit:
    """Return the unit in which a duration is a number of ordinary size."""
    if duration_s <= 300.0:
        return Unit(name="s", factor=1.0)
    if duration_s <= 4.0 * 3600.0:
        return Unit(name="min", factor=1.0 / 60.0)
    return Unit(name="h", factor=1.0 / 3600.0)
