"""Units and quantities: a strict `NUMBER UNIT` reader in front of pint's unit parser.

Pint never sees a user's number or expression: the number is read by one regular expression, the
unit is tokenised here against a closed list of names and rewritten before pint resolves it.
"""

import functools
import math
import re
from dataclasses import dataclass
from enum import StrEnum
from typing import TYPE_CHECKING, Any

from gyrotest.errors import UnitError

if TYPE_CHECKING:
    import pint

# Angle is a dimension of its own, so that hertz is no rate; g is standard gravity.
_DEFINITIONS = """
micro- = 1e-6 = u-
milli- = 1e-3 = m-
kilo- = 1e3 = k-
mega- = 1e6 = M-
second = [time] = s = sec
minute = 60 * second = min
hour = 3600 * second = h = hr
day = 24 * hour = d
degree = [angle] = deg
radian = 57.29577951308232 * degree = rad
arcminute = degree / 60 = arcmin
arcsecond = degree / 3600 = arcsec
turn = 360 * degree = rev
rpm = turn / minute
dps = degree / second
dph = degree / hour
hertz = 1 / second = Hz
volt = [voltage] = V
ampere = [current] = A
ohm = volt / ampere
metre = [length] = m
gravity = 9.80665 * metre / second ** 2 = g
count = [count] = LSB
percent = 0.01 = pct
ppm = 1e-6
kelvin = [temperature] = K
degC = [celsius]
"""


class Dimension(StrEnum):
    """The kinds of quantity that specs and stations use; the value is the canonical unit."""

    NUMBER = ""
    TIME = "s"
    FREQUENCY = "Hz"
    ANGLE = "deg"
    RATE = "deg/s"
    ANGLE_RANDOM_WALK = "deg/s**0.5"
    RATE_RANDOM_WALK = "deg/s**1.5"
    RATE_RAMP = "deg/s**2"
    VOLTAGE = "V"
    TEMPERATURE = "degC"
    SCALE_FACTOR_VOLTAGE = "V*s/deg"
    COUNT = "count"
    SCALE_FACTOR_COUNT = "count*s/deg"
    ACCELERATION = "m/s**2"

    def spoken(self) -> str:
        """The name for messages, with its article."""
        return _SPOKEN[self]

    def example(self) -> str:
        """A quantity of this dimension, as a user would write it."""
        return _EXAMPLES[self]


_SPOKEN = {
    Dimension.NUMBER: "a ratio",
    Dimension.TIME: "a time",
    Dimension.FREQUENCY: "a frequency",
    Dimension.ANGLE: "an angle",
    Dimension.RATE: "an angular rate",
    Dimension.ANGLE_RANDOM_WALK: "an angle random walk",
    Dimension.RATE_RANDOM_WALK: "a rate random walk",
    Dimension.RATE_RAMP: "a rate ramp",
    Dimension.VOLTAGE: "a voltage",
    Dimension.TEMPERATURE: "a temperature",
    Dimension.SCALE_FACTOR_VOLTAGE: "a scale factor in volts per angular rate",
    Dimension.COUNT: "a number of counts",
    Dimension.SCALE_FACTOR_COUNT: "a scale factor in counts per angular rate",
    Dimension.ACCELERATION: "an acceleration",
}

_EXAMPLES = {
    Dimension.NUMBER: "0.5 %",
    Dimension.TIME: "10 s",
    Dimension.FREQUENCY: "50 Hz",
    Dimension.ANGLE: "45 deg",
    Dimension.RATE: "30 deg/h",
    Dimension.ANGLE_RANDOM_WALK: "0.5 deg/sqrt(h)",
    Dimension.RATE_RANDOM_WALK: "5 deg/h/sqrt(h)",
    Dimension.RATE_RAMP: "1 deg/h/h",
    Dimension.VOLTAGE: "2.5 V",
    Dimension.TEMPERATURE: "23 degC",
    Dimension.SCALE_FACTOR_VOLTAGE: "50 mV/(deg/s)",
    Dimension.COUNT: "131 count",
    Dimension.SCALE_FACTOR_COUNT: "131 count/(deg/s)",
    Dimension.ACCELERATION: "1 g",
}

_NUMBER = re.compile(r"[+-]?(?:[0-9]+(?:\.[0-9]*)?|\.[0-9]+)(?:[eE][+-]?[0-9]{1,3})?")
_TOKEN = re.compile(r"\s*(?:(sqrt|√)|([A-Za-z]+)|(\*\*|\^)\s*(-?[0-9](?:\.5)?)|([()*/]))")
_SPELLING = str.maketrans({"°": "degree ", "µ": "u", "μ": "u", "·": "*", "%": "percent", "²": "^2"})


@dataclass(frozen=True, slots=True)
class Quantity:
    """A finite number and its unit, as the user wrote them."""

    value: float
    unit: str

    def to(self, unit: str) -> float:
        """Return the value in another unit of the same dimension; raises `UnitError`."""
        return self.value * conversion_factor(self.unit, unit)

    def __str__(self) -> str:
        return f"{repr(self.value).removesuffix('.0')} {self.unit}"


def parse_quantity(text: Any, dimension: Dimension | tuple[Dimension, ...]) -> Quantity:
    """Read `NUMBER UNIT` of a dimension (or of one of several); raises `UnitError`."""
    accepted = dimension if isinstance(dimension, tuple) else (dimension,)
    hint = f"write e.g. '{accepted[0].example()}'"
    if isinstance(text, bool) or not isinstance(text, str):
        found = "nothing" if text is None else f"{text!r}"
        raise UnitError(f"{found} is not a quantity (a number and its unit); {hint}")
    match = _NUMBER.match(text.strip())
    if match is None:
        raise UnitError(f"'{text}' does not begin with a decimal number; {hint}")
    value, unit = float(match.group()), text.strip()[match.end() :]
    if not math.isfinite(value):
        raise UnitError(f"'{text}' is not finite; {hint}")
    if not unit.strip():
        raise UnitError(f"'{text}' has no unit; {hint}")
    if unit[0] not in " \t%°" and not unit[0].isalpha():
        raise UnitError(f"'{text}' is not a decimal number and a unit; {hint}")
    return Quantity(value, _checked_unit(unit.strip(), text, accepted, hint))


def _checked_unit(unit: str, text: str, accepted: tuple[Dimension, ...], hint: str) -> str:
    try:
        found = _resolve(unit)
    except UnitError as error:
        raise UnitError(f"'{text}': {error}; {hint}") from None
    if not any(found.dimensionality == _resolve(one.value).dimensionality for one in accepted):
        spoken = " or ".join(one.spoken() for one in accepted)
        raise UnitError(f"'{text}' is not {spoken}; {hint}")
    return unit


def conversion_factor(unit: str, to: str) -> float:
    """Return the factor from one unit to another; raises `UnitError` if the dimensions differ."""
    if unit == to:
        return 1.0
    source, target = _resolve(unit), _resolve(to)
    if source.dimensionality != target.dimensionality:
        raise UnitError(f"'{unit}' cannot be converted to '{to}'")
    return float((1 * source).to(target).magnitude)


def same_dimension(unit: str, other: str) -> bool:
    """Whether two units measure the same kind of quantity."""
    return bool(_resolve(unit).dimensionality == _resolve(other).dimensionality)


@functools.cache
def _registry() -> "pint.UnitRegistry[Any]":
    import pint

    registry: pint.UnitRegistry[Any] = pint.UnitRegistry(None, cache_folder=None)
    registry.load_definitions(_DEFINITIONS.strip().splitlines())
    return registry


@functools.lru_cache(maxsize=512)
def _resolve(unit: str) -> Any:
    """Tokenise a unit, refuse anything unknown, and let pint resolve the rewritten text."""
    if not unit:
        return _registry().Unit("")
    import pint

    rewritten = _rewrite(unit)
    try:
        return _registry().parse_units(rewritten)
    except (pint.PintError, ValueError, SyntaxError, TypeError, AttributeError) as error:
        raise UnitError(f"'{unit}' is no unit that gyrotest knows") from error


def _rewrite(unit: str) -> str:
    text = unit.replace("°C", "degC").translate(_SPELLING)
    tokens: list[str] = []
    position, operand_before = 0, False
    while position < len(text.rstrip()):
        match = _TOKEN.match(text, position)
        if match is None:
            raise UnitError(f"'{unit}' is no unit: '{text[position:].strip()[:10]}' is not understood")
        position = match.end()
        root, name, power, exponent, symbol = match.groups()
        opens = root or name or symbol == "("
        if opens and operand_before:
            raise UnitError(f"'{unit}' is no unit: '*' or '/' is missing before '{match.group().strip()}'")
        if root:
            tokens.append("sqrt")
            operand_before = False
        elif name:
            tokens.append(name)
            operand_before = True
        elif power:
            tokens.append(f"**{exponent}")
        else:
            tokens.append(symbol)
            operand_before = symbol == ")"
    return _roots_as_powers(tokens, unit)


def _roots_as_powers(tokens: list[str], unit: str) -> str:
    """Rewrite `sqrt X` and `sqrt ( … )` as powers of one half."""
    out: list[str] = []
    index = 0
    while index < len(tokens):
        if tokens[index] != "sqrt":
            out.append(tokens[index])
            index += 1
            continue
        end = _operand_end(tokens, index + 1, unit)
        out.append(f"({_roots_as_powers(tokens[index + 1 : end], unit)})**0.5")
        index = end
    return "".join(out)


def _operand_end(tokens: list[str], start: int, unit: str) -> int:
    if start >= len(tokens) or tokens[start] in {")", "*", "/"}:
        raise UnitError(f"'{unit}' is no unit: nothing follows the root")
    if tokens[start] != "(":
        return start + 1
    depth = 0
    for index in range(start, len(tokens)):
        depth += {"(": 1, ")": -1}.get(tokens[index], 0)
        if depth == 0:
            return index + 1
    raise UnitError(f"'{unit}' is no unit: a bracket is not closed")


_PRINTED = (
    (re.compile(r"sqrt\(([A-Za-z]+)\)"), r"√\1"),
    (re.compile(r"\bdeg(?:ree)?\b(?!C)"), "°"),
    (re.compile(r"\bdegC\b"), "°C"),
    (re.compile(r"\bdps\b"), "°/s"),
    (re.compile(r"\bdph\b"), "°/h"),
    (re.compile(r"\bu(?=[A-Za-z])"), "µ"),
)


def printed_unit(unit: str) -> str:
    """The unit as it is printed for people: `deg/sqrt(h)` becomes `°/√h`."""
    for pattern, replacement in _PRINTED:
        unit = pattern.sub(replacement, unit)
    return unit


class OfDimension:
    """Annotation of a `Quantity` field: the dimensions accepted (none given: any)."""

    def __init__(self, *dimensions: Dimension) -> None:
        self.dimensions = dimensions
