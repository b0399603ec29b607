"""Numbers as they are printed: rounded by the GUM, with the true minus sign.

An uncertainty keeps two significant digits and its value ends at the same place (JCGM 100, 7.2.6);
an interval keeps two digits of its shorter side. Where that rounding would hide on which side of a
limit a value lies, more places are shown.
"""

import math
from collections.abc import Iterable
from dataclasses import dataclass
from decimal import ROUND_HALF_EVEN, Context, Decimal

MINUS = "\N{MINUS SIGN}"
_SUPERSCRIPTS = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")
_CONTEXT = Context(prec=60, rounding=ROUND_HALF_EVEN)
_WIDEST, _FINEST = 7, -6  # powers of ten from which on, and below which, numbers get an exponent
_SMALL = -3  # nearer to 1 than so, a power of ten would only make a number of many places longer
_MORE_PLACES = 12


@dataclass(frozen=True, slots=True, kw_only=True)
class Printed:
    """A value and what surrounds it, all ending at the same place; absent parts are empty."""

    value: str
    uncertainty: str = ""
    lower: str = ""
    upper: str = ""


def printed(
    value: float,
    *,
    uncertainty: float | None = None,
    lower: float | None = None,
    upper: float | None = None,
    limits: Iterable[float] = (),
) -> Printed:
    """Round a value with its expanded uncertainty, or with its 95 % interval, for print.

    `limits` are the numbers that the rounded value must stay on its side of.
    """
    place = _place(value, uncertainty, lower, upper)
    place = _faithful_place(value, place, tuple(limits))
    exponent = _exponent((value, lower or 0.0, upper or 0.0), place)
    parts = [
        "" if part is None else _text(part, place, exponent)
        for part in (value, uncertainty, lower, upper)
    ]
    return Printed(value=parts[0], uncertainty=parts[1], lower=parts[2], upper=parts[3])


def bounded(number: str, *, at_most: bool, at_least: bool) -> str:
    """A number that is only an upper or a lower bound, with the sign that says so."""
    sign = "≤ " if at_most else "≥ " if at_least else ""
    return f"{sign}{number}"


def plain(value: float, *, digits: int = 10) -> str:
    """A number as a person wrote it: the fewest digits, at most `digits` of them."""
    if value == 0:
        return "0"
    place = max(_magnitude(value) - digits + 1, _last_place(value, digits))
    return _text(value, place, _exponent((value,), place))


def significant(value: float, *, digits: int) -> str:
    """A number rounded to so many significant digits."""
    if value == 0:
        return "0"
    place = _rounded_place(value, digits)
    return _text(value, place, _exponent((value,), place))


def _place(value: float, uncertainty: float | None, lower: float | None, upper: float | None) -> int:
    """The power of ten of the last digit that is shown."""
    sides = [abs(value - end) for end in (lower, upper) if end is not None and end != value]
    width = uncertainty if uncertainty else min(sides, default=0.0)
    if width > 0:
        return _rounded_place(width, 2)
    return _rounded_place(value, 4) if value else 0


def _faithful_place(value: float, place: int, limits: tuple[float, ...]) -> int:
    for finer in range(place, place - _MORE_PLACES, -1):
        rounded = _rounded(value, finer)
        if all(_sign(rounded - Decimal(plain_digits(one))) == _side(value, one) for one in limits):
            return finer
    return place


def _side(value: float, limit: float) -> int:
    return _sign(Decimal(repr(float(value))) - Decimal(plain_digits(limit)))


def plain_digits(value: float) -> str:
    """The digits that `plain` prints, as Decimal reads them."""
    return repr(float(f"{value:.10g}"))


def _sign(number: Decimal) -> int:
    return (number > 0) - (number < 0)


def _magnitude(value: float) -> int:
    return math.floor(math.log10(abs(value)))


def _rounded_place(value: float, digits: int) -> int:
    """The last place of a value rounded to so many digits (9.96 to two digits is 10)."""
    return Decimal(f"{value:.{digits - 1}e}").adjusted() - digits + 1


def _last_place(value: float, digits: int) -> int:
    exponent = Decimal(f"{value:.{digits}g}").normalize().as_tuple().exponent
    return int(exponent)


def _exponent(values: tuple[float, ...], place: int) -> int:
    """The power of ten that is taken out, 0 for numbers of an ordinary size."""
    largest = max(abs(value) for value in values)
    magnitude = _magnitude(largest) if largest else place
    small = place < _FINEST and magnitude <= _SMALL
    return magnitude if magnitude >= _WIDEST or small else 0


def _rounded(value: float, place: int) -> Decimal:
    return Decimal(repr(float(value))).quantize(Decimal(1).scaleb(place, _CONTEXT), context=_CONTEXT)


def _text(value: float, place: int, exponent: int) -> str:
    shown = _rounded(value, place).scaleb(-exponent, _CONTEXT)
    digits = f"{abs(shown):f}" if place - exponent <= 0 else f"{abs(int(shown))}"
    sign = MINUS if shown < 0 else ""
    power = f" × 10{str(exponent).translate(_SUPERSCRIPTS)}" if exponent else ""
    return sign + _grouped(digits) + power


def _grouped(digits: str) -> str:
    """Thousands set apart by a thin space, from five figures on."""
    whole, point, fraction = digits.partition(".")
    if len(whole) > 4:
        whole = f"{int(whole):,}".replace(",", "\N{NARROW NO-BREAK SPACE}")
    return whole + point + fraction
