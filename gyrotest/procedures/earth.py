"""The Earth's rate in a bias: the share that is subtracted, and what is left of it."""

import math

from gyrotest.analysis.earth import EARTH_RATE_DPS, earth_share_dps
from gyrotest.procedures.uncertainty import rectangular
from gyrotest.procedures.wording import plain, rate_text
from gyrotest.records.plan import Context
from gyrotest.records.result import Contribution

POINTING_DEG = 1.0
"""How far the sensitive axis is assumed to point from where mounting and site say."""

_DPH = 3600.0
_MINUS = "\N{MINUS SIGN}"


def earth_share(context: Context) -> float | None:
    """Return the Earth's rate along the sensitive axis, °/s; None where site or mounting is not known."""
    site = context.site
    return earth_share_dps(
        context.case.mounting,
        latitude_deg=None if site is None else site.latitude.to("deg"),
        heading_deg=None if site is None or site.heading is None else site.heading.to("deg"),
    )


def earth_words(share_dps: float | None) -> str:
    """Say whether the Earth's share is subtracted."""
    if share_dps is None:
        return "Earth's rate not subtracted"
    return f"Earth's share {plain(share_dps * _DPH, 3)} °/h subtracted".replace("-", _MINUS)


def of_earth(share_dps: float | None) -> Contribution:
    """Give what is left of the Earth's rate: all of it, or what a small error of pointing leaves."""
    if share_dps is None:
        source, half_dps = "Earth's rate, not subtracted", EARTH_RATE_DPS
    else:
        source, half_dps = f"Earth's share, axis within {POINTING_DEG:g}°", _pointing_half_dps(share_dps)
    return rectangular(source, rate_text(half_dps), "1", half_dps)


def _pointing_half_dps(share_dps: float) -> float:
    """Return the most by which Ω_E·cos(angle) changes when the angle does."""
    angle = math.radians(POINTING_DEG)
    across = math.sqrt(max(EARTH_RATE_DPS**2 - share_dps**2, 0.0))
    return across * math.sin(angle) + abs(share_dps) * (1.0 - math.cos(angle))
