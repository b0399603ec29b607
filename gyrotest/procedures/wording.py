"""Numbers inside texts: plain digits, engineering prefixes, never an exponent."""

import math
from decimal import Decimal

from gyrotest.units import printed_unit

_PREFIXES = {-9: "n", -6: "µ", -3: "m", 0: "", 3: "k"}
_PREFIXED = ("V", "s", "Hz")
_WHOLE_FROM = 10.0
_SMALL_DPS = 0.01
_MOST_PLACES = 9
_MINUS = "\N{MINUS SIGN}"


def plain(value: float, digits: int) -> str:
    """Return a number rounded to so many significant digits, without an exponent: `2530`."""
    return f"{Decimal(f'{value:.{digits}g}').normalize():f}"


def places_of(uncertainty: float) -> int:
    """Return the decimal places with which two digits of an uncertainty end (JCGM 100, 7.2.6)."""
    if not uncertainty > 0.0:
        return _MOST_PLACES
    return min(max(1 - math.floor(math.log10(float(f"{uncertainty:.2g}"))), 0), _MOST_PLACES)


def ending(value: float, places: int) -> str:
    """Return a number with so many decimal places, zeros among them, and the true minus."""
    text = f"{value:.{places}f}"
    return (text if text.strip("-0.") else text.removeprefix("-")).replace("-", _MINUS)


def engineering(value: float, unit: str, digits: int = 2) -> str:
    """Return a quantity in the prefixed unit that suits it: `88 µV`; other units than V, s, Hz as they are."""
    name = printed_unit(unit)
    if unit not in _PREFIXED or value == 0.0:
        return f"{plain(value, digits)} {name}"
    rounded = float(f"{value:.{digits}g}")
    thousands = 3 * math.floor(math.log10(abs(rounded)) / 3 + 1e-9)
    power = min(max(thousands, min(_PREFIXES)), max(_PREFIXES))
    return f"{plain(rounded / 10.0**power, digits)} {_PREFIXES[power]}{name}"


def freedom(degrees: float) -> str:
    """Return degrees of freedom: whole from ten on."""
    return f"{plain(float(round(degrees)), 3) if degrees >= _WHOLE_FROM else plain(degrees, 2)} d.o.f."


def rate_text(rate_dps: float, digits: int = 2) -> str:
    """Return a rate in °/h where that is the handier unit."""
    small = abs(rate_dps) < _SMALL_DPS
    text = f"{plain(rate_dps * 3600.0, digits)} °/h" if small else f"{plain(rate_dps, digits)} °/s"
    return text.replace("-", "\N{MINUS SIGN}")
