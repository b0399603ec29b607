"""Units and quantities: a strict `NUMBER UNIT` reader in front of pint.

Pint never sees a user's text: the number is read by one regular expression, the unit by the
grammar of `unit_grammar`, and pint is given a product of names that it was told about here.
"""

import functools
import math
import re
from dataclasses import dataclass
from enum import StrEnum
from typing import TYPE_CHECKING, Any, get_args

from gyrotest.errors import UnitError
from gyrotest.unit_grammar import factors

if TYPE_CHECKING:
    import pint
    from pydantic_core import core_schema

# Angle is a dimension of its own, so that hertz is no rate; g is standard gravity.
_DEFINITIONS = """
micro- = 1e-6 = u-
milli- = 1e-3 = m-
kilo- = 1e3 = k-
mega- = 1e6 = M-
second = [time] = s = sec
nanosecond = 1e-9 * second = ns
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
    CURRENT = "A"
    RATE_PER_TEMPERATURE = "deg/s/degC"
    RATIO_PER_TEMPERATURE = "ppm/degC"
    RATE_PER_ACCELERATION = "deg/s/g"
    RATE_PER_VOLTAGE = "deg/s/V"

    def spoken(self) -> str:
        """Return the name for messages, with its article."""
        return _SPOKEN[self]

    def example(self) -> str:
        """Return a quantity of this dimension, as a user would write it."""
        return _EXAMPLES[self]


_SPOKEN = {
    Dimension.NUMBER: "a ratio",
    Dimension.TIME: "a time",
    Dimension.FREQUENCY: "a frequency",
    Dimension.ANGLE: "an angle",
    Dimension.RATE: "an angular rate",
    Dimension.ANGLE_RANDOM_WALK: "an angle random walk",
    Dimension.RATE_RANDOM_WALK: "a rate random walk",
    Dimension.RATE_RAMP: "a rate ramp or angular acceleration",
    Dimension.VOLTAGE: "a voltage",
    Dimension.TEMPERATURE: "a temperature",
    Dimension.SCALE_FACTOR_VOLTAGE: "a scale factor in volts per angular rate",
    Dimension.COUNT: "a number of counts",
    Dimension.SCALE_FACTOR_COUNT: "a scale factor in counts per angular rate",
    Dimension.ACCELERATION: "an acceleration",
    Dimension.CURRENT: "a current",
    Dimension.RATE_PER_TEMPERATURE: "a rate per temperature",
    Dimension.RATIO_PER_TEMPERATURE: "a ratio per temperature",
    Dimension.RATE_PER_ACCELERATION: "an angular rate per acceleration",
    Dimension.RATE_PER_VOLTAGE: "an angular rate per voltage",
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
    Dimension.CURRENT: "200 mA",
    Dimension.RATE_PER_TEMPERATURE: "10 deg/h/degC",
    Dimension.RATIO_PER_TEMPERATURE: "100 ppm/degC",
    Dimension.RATE_PER_ACCELERATION: "0.05 deg/s/g",
    Dimension.RATE_PER_VOLTAGE: "20 deg/s/V",
}

_NUMBER = re.compile(r"[+-]?(?:[0-9]+(?:\.[0-9]*)?|\.[0-9]+)(?:[eE][+-]?[0-9]{1,3})?(?![0-9])")
_LONGEST = 100
# Shown as examples where a quantity of any dimension may stand.
_ANY = (Dimension.RATE, Dimension.NUMBER)
QUANTITY_PATTERN = r"^\s*[+-]?([0-9]+(\.[0-9]*)?|\.[0-9]+)([eE][+-]?[0-9]{1,3})?\s*[A-Za-z°%√µμ(]"
_UNIT_BEGINS = re.compile(r"[ \t]*[A-Za-z°%√µμ(]")


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


def parse_quantity(text: Any, dimension: Dimension | tuple[Dimension, ...] = ()) -> Quantity:
    """Read `NUMBER UNIT` of a dimension (one of several; none given: any); raises `UnitError`."""
    dimensions = dimension if isinstance(dimension, tuple) else (dimension,)
    hint = f"write e.g. {' or '.join(repr(one.example()) for one in dimensions[:1] or _ANY)}"
    if isinstance(text, bool) or not isinstance(text, str):
        raise UnitError(f"{_found(text)} is not a quantity (a number and its unit); {hint}")
    stripped = text.strip(" \t\r\n")
    if len(stripped) > _LONGEST:
        raise UnitError(
            f"'{stripped[:20]}…' ({len(stripped)} characters) is too long for a quantity; {hint}"
        )
    match = _NUMBER.match(stripped)
    if match is None:
        raise UnitError(f"{text!r} does not begin with a finite decimal number; {hint}")
    value = _finite(match.group(), text, hint)
    return Quantity(value, _checked_unit(stripped[match.end() :], text, dimensions, hint))


def _found(value: Any) -> str:
    if value is None:
        return "nothing"
    shown = {True: "true", False: "false"}[value] if isinstance(value, bool) else repr(value)
    return shown if len(shown) <= 60 else f"{shown[:60]}…"


def _finite(number: str, text: str, hint: str) -> float:
    value = float(number)
    if not math.isfinite(value):
        raise UnitError(f"{text!r} is not finite; {hint}")
    if value == 0 and re.search("[1-9]", re.split("[eE]", number)[0]):
        raise UnitError(f"{text!r} is too small to be told from zero; {hint}")
    return value


def _checked_unit(unit: str, text: str, accepted: tuple[Dimension, ...], hint: str) -> str:
    if not unit.strip(" \t"):
        raise UnitError(f"{text!r} has no unit; {hint}")
    if not _UNIT_BEGINS.match(unit):
        raise UnitError(f"{text!r} is not one decimal number and a unit; {hint}")
    unit = unit.strip(" \t")
    try:
        found = _resolve(unit).dimensionality
    except UnitError as error:
        raise UnitError(f"{text!r}: {error}; {hint}") from None
    if accepted and not any(found == _resolve(one.value).dimensionality for one in accepted):
        spoken = " or ".join(one.spoken() for one in accepted)
        raise UnitError(f"{text!r} is not {spoken}; {hint}")
    return unit


@functools.lru_cache(maxsize=512)
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
    """Let pint resolve a unit from the factors that our own grammar reads; raises `UnitError`."""
    if not unit:
        return _registry().Unit("")
    product = " * ".join(f"{name} ** {float(power)!r}" for name, power in factors(unit).items() if power)
    return _registry().parse_units(product)


_PRINTED = (
    (re.compile(r"sqrt\(([A-Za-z]+)\)"), r"√\1"),
    (re.compile(r"\bdeg(?:ree)?\b(?!C)"), "°"),
    (re.compile(r"\bdegC\b"), "°C"),
    (re.compile(r"\bdps\b"), "°/s"),
    (re.compile(r"\bdph\b"), "°/h"),
    (re.compile(r"\bu(?=[A-Za-z])"), "µ"),
)


def printed_unit(unit: str) -> str:
    """Return the unit as it is printed for people: `deg/sqrt(h)` becomes `°/√h`."""
    for pattern, replacement in _PRINTED:
        unit = pattern.sub(replacement, unit)
    return unit


class OfDimension:
    """Annotation of a `Quantity` field: the dimensions accepted (none given: any).

    It teaches pydantic, where that is loaded, to read the field from text and to write it as text.
    """

    def __init__(self, *dimensions: Dimension) -> None:
        self.dimensions = dimensions

    def example(self) -> str:
        """Return a quantity that is accepted, as a user would write it."""
        return (self.dimensions[0] if self.dimensions else Dimension.RATE).example()

    def checked(self, value: Any) -> Quantity:
        """Return the quantity that a text (or a quantity) gives; raises `UnitError`."""
        return parse_quantity(str(value) if isinstance(value, Quantity) else value, self.dimensions)

    def __get_pydantic_core_schema__(self, source: Any, handler: Any) -> "core_schema.CoreSchema":
        """Tell pydantic how the field is checked and written."""
        from pydantic_core import PydanticCustomError, core_schema

        def check(value: Any) -> Quantity:
            try:
                return self.checked(value)
            except UnitError as error:
                raise PydanticCustomError("quantity", "{reason}", {"reason": str(error)}) from None

        schema: core_schema.CoreSchema = core_schema.no_info_plain_validator_function(
            check, serialization=core_schema.to_string_ser_schema()
        )
        return core_schema.nullable_schema(schema) if type(None) in get_args(source) else schema

    def __get_pydantic_json_schema__(self, schema: Any, handler: Any) -> dict[str, Any]:
        """Describe the field as text of the form `NUMBER UNIT`."""
        spoken = " or ".join(one.spoken() for one in self.dimensions) or "a quantity"
        described: dict[str, Any] = {"type": "string", "pattern": QUANTITY_PATTERN, "x-quantity": spoken}
        if self.dimensions:
            described["examples"] = [one.example() for one in self.dimensions]
        return described
