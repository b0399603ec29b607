"""The grammar of units: text such as `mV/(deg/s)` or `°/√h` → names with their exponents.

Written here and not left to pint, whose parser multiplies what merely stands side by side and
evaluates numbers: there is no implicit multiplication, every name is on a closed list, and the
work is bounded by the text's length.

    unit    = factor { ("*" | "·" | "/") factor }
    factor  = root | (name | "(" unit ")") [ power ]
    root    = ("√" | "sqrt") ( name | "(" unit ")" [ power ] )
    power   = ("**" | "^") exponent | "²" | "³"
"""

import difflib
import re
from dataclasses import dataclass
from fractions import Fraction

from gyrotest.errors import UnitError

LONGEST = 80
DEEPEST = 10
GREATEST_EXPONENT = 9

_PREFIXES = ("u", "m", "k", "M")
_WITH_PREFIX = ("s", "deg", "rad", "dps", "dph", "V", "A", "Hz", "ohm", "m", "K", "arcsec")
_ALONE = {
    "g": "g",
    "mg": "mg",
    "ug": "ug",
    "ns": "ns",
    "sec": "s",
    "second": "s",
    "seconds": "s",
    "min": "min",
    "minute": "min",
    "minutes": "min",
    "h": "h",
    "hr": "h",
    "hour": "h",
    "hours": "h",
    "d": "d",
    "day": "d",
    "days": "d",
    "degree": "deg",
    "degrees": "deg",
    "radian": "rad",
    "radians": "rad",
    "arcmin": "arcmin",
    "turn": "turn",
    "turns": "turn",
    "rev": "turn",
    "rpm": "rpm",
    "volt": "V",
    "volts": "V",
    "hertz": "Hz",
    "degC": "degC",
    "count": "count",
    "counts": "count",
    "LSB": "count",
    "percent": "percent",
    "pct": "percent",
    "ppm": "ppm",
}
_NAMES = _ALONE | {prefix + name: prefix + name for name in _WITH_PREFIX for prefix in ("", *_PREFIXES)}

_TOKEN = re.compile(
    r"[ \t]*(?:(?P<root>√|sqrt(?![A-Za-z]))|(?P<name>°C|°|%|[A-Za-zµμ]+)"
    r"|(?P<power>(?:\*\*|\^)[ \t]*(?P<exponent>-?(?:[0-9](?:\.5)?|\.5)(?![0-9.]))|²|³)"
    r"|(?P<symbol>[()*·/]))"
)
_SIGNS = {"°": "deg", "°C": "degC", "%": "percent"}


@dataclass(frozen=True, slots=True)
class _Token:
    kind: str
    text: str
    exponent: Fraction = Fraction(1)


Factors = dict[str, Fraction]


def factors(unit: str) -> Factors:
    """Return a unit's names (as `units` defines them) with their exponents; raises `UnitError`."""
    if len(unit) > LONGEST:
        raise UnitError(f"a unit of {len(unit)} characters is longer than the {LONGEST} allowed")
    return _Parser(unit).whole()


class _Parser:
    """Recursive descent over the tokens of one unit."""

    def __init__(self, unit: str) -> None:
        self._unit = unit
        self._tokens = _tokens(unit)
        self._next = 0
        self._depth = 0

    def whole(self) -> Factors:
        """Read the whole text as one unit."""
        found = self._product()
        if (extra := self._peek()) is not None:
            if extra.text == ")":
                raise self._fault("a bracket is closed that was never opened")
            raise self._fault(f"'*' or '/' is missing before '{extra.text}'")
        return found

    def _product(self) -> Factors:
        product = self._factor("")
        while (operator := self._take("*", "·", "/")) is not None:
            sign = -1 if operator == "/" else 1
            for name, exponent in self._factor(operator).items():
                product[name] = product.get(name, Fraction(0)) + sign * exponent
        return product

    def _factor(self, after: str) -> Factors:
        token = self._peek()
        if token is None or token.text in {"*", "·", "/", ")"}:
            where = f"after '{after}'" if after else "at its beginning"
            raise self._fault(f"a name is missing {where}")
        self._next += 1
        if token.kind == "root":
            return self._root(token.text)
        if token.kind == "power":
            raise self._fault(f"'{token.text}' follows no name")
        return self._powered(self._primary(token))

    def _root(self, sign: str) -> Factors:
        token = self._peek()
        if token is None or (token.kind != "name" and token.text != "("):
            raise self._fault(f"nothing to take the root of follows '{sign}'")
        self._next += 1
        rooted = self._raised(self._primary(token), Fraction(1, 2))
        follows = self._peek()
        if token.text != "(" and follows is not None and follows.kind == "power":
            raise self._fault("a power of a root is ambiguous without brackets")
        return self._powered(rooted)

    def _primary(self, token: _Token) -> Factors:
        if token.kind == "name":
            return {_known(token.text, self._unit): Fraction(1)}
        self._depth += 1
        if self._depth > DEEPEST:
            raise self._fault(f"brackets are nested deeper than {DEEPEST}")
        inner = self._product()
        if self._take(")") is None:
            follows = self._peek()
            if follows is not None:
                raise self._fault(f"'*' or '/' is missing before '{follows.text}'")
            raise self._fault("a bracket is not closed")
        self._depth -= 1
        return inner

    def _powered(self, base: Factors) -> Factors:
        token = self._peek()
        if token is None or token.kind != "power":
            return base
        self._next += 1
        follows = self._peek()
        if follows is not None and follows.kind == "power":
            raise self._fault("a power of a power is not allowed")
        return self._raised(base, token.exponent)

    def _raised(self, base: Factors, exponent: Fraction) -> Factors:
        raised = {name: power * exponent for name, power in base.items()}
        if any(abs(power) > GREATEST_EXPONENT for power in raised.values()):
            raise self._fault(f"an exponent is beyond ±{GREATEST_EXPONENT}")
        return raised

    def _peek(self) -> _Token | None:
        return self._tokens[self._next] if self._next < len(self._tokens) else None

    def _take(self, *symbols: str) -> str | None:
        token = self._peek()
        if token is None or token.kind != "symbol" or token.text not in symbols:
            return None
        self._next += 1
        return token.text

    def _fault(self, reason: str) -> UnitError:
        return UnitError(f"'{self._unit}' is no unit: {reason}")


def _tokens(unit: str) -> tuple[_Token, ...]:
    found: list[_Token] = []
    text = unit.rstrip(" \t")
    position = 0
    while position < len(text):
        match = _TOKEN.match(text, position)
        if match is None or match.end() == position:
            rest = text[position:].lstrip(" \t")
            raise UnitError(f"{unit!r} is no unit: {rest[:10]!r} is not understood")
        position = match.end()
        found.append(_token(match))
    return tuple(found)


def _token(match: re.Match[str]) -> _Token:
    kind = match.lastgroup or ""
    if match["power"]:
        exponent = match["exponent"] or {"²": "2", "³": "3"}[match["power"]]
        return _Token("power", match["power"], Fraction(exponent))
    return _Token(kind, match[kind])


def _known(name: str, unit: str) -> str:
    """Return the name under which `units` defines it, or refuse it, naming the nearest."""
    plain = _SIGNS.get(name, name.replace("µ", "u").replace("μ", "u"))
    if plain in _NAMES:
        return _NAMES[plain]
    if not plain.isascii() or not plain.isalpha():
        raise UnitError(f"'{unit}' is no unit: '{name}' is not understood")
    same = [known for known in _NAMES if known.lower() == plain.lower()]
    near = same or difflib.get_close_matches(plain, _NAMES, n=1, cutoff=0.7)
    meant = f"; did you mean '{near[0]}'?" if near else ""
    raise UnitError(f"'{unit}' is no unit: '{name}' is not known{meant}")
