"""The SCPI language of a simulated instrument: headers, messages, parameters and the error queue."""

import itertools
import re
from collections import deque
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Generic, TypeVar

InstrumentT = TypeVar("InstrumentT")
Answer = str | bytes | Iterator[bytes] | None
Action = Callable[[InstrumentT, Sequence[str]], Answer]

_NODE = re.compile(r"\[:?(\w+):?\]|:?(\*?\w+)")
_NUMBER = re.compile(r"[+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?")
_QUEUE_LENGTH = 20
_REMEMBERED = 512

MESSAGES = {
    -101: "Invalid character",
    -102: "Syntax error",
    -104: "Data type error",
    -108: "Parameter not allowed",
    -109: "Missing parameter",
    -113: "Undefined header",
    -114: "Header suffix out of range",
    -211: "Trigger ignored",
    -213: "Init ignored",
    -214: "Trigger deadlock",
    -221: "Settings conflict",
    -222: "Data out of range",
    -224: "Illegal parameter value",
    -230: "Data stale",
    -350: "Too many errors",
    -410: "Query INTERRUPTED",
    -420: "Query UNTERMINATED",
    531: "Insufficient memory",
    532: "Cannot achieve requested resolution",
    550: "Command not allowed in local",
}


class ScpiError(Exception):
    """A command that the instrument refuses; the code goes into the error queue."""

    def __init__(self, code: int) -> None:
        self.code = code
        super().__init__(MESSAGES[code])


class ErrorQueue:
    """First in, first out, 20 deep; an overflow replaces the last entry."""

    def __init__(self) -> None:
        self._codes: deque[int] = deque()

    def push(self, code: int) -> None:
        """Add an error."""
        if len(self._codes) < _QUEUE_LENGTH:
            self._codes.append(code)
        else:
            self._codes[-1] = -350

    def pop(self) -> str:
        """The oldest error as `SYST:ERR?` answers it."""
        if not self._codes:
            return '+0,"No error"'
        code = self._codes.popleft()
        return f'{code:+d},"{MESSAGES[code]}"'

    def clear(self) -> None:
        """Forget all errors."""
        self._codes.clear()

    def __len__(self) -> int:
        return len(self._codes)


def spellings(pattern: str) -> Iterator[str]:
    """Every accepted spelling of a header: `[SENSe:]ZERO` gives ZERO, SENS:ZERO and SENSE:ZERO."""
    nodes: list[tuple[str, ...]] = []
    for optional, required in _NODE.findall(pattern):
        node = optional or required
        short = "".join(letter for letter in node if not letter.islower())
        forms = dict.fromkeys((short, node.upper()))
        nodes.append((*forms, "") if optional else tuple(forms))
    for chosen in itertools.product(*nodes):
        yield ":".join(filter(None, chosen))


@dataclass(frozen=True, slots=True)
class Call(Generic[InstrumentT]):
    """One command of a message: the action found for it and its parameters, or a refusal."""

    action: Action[InstrumentT] | None
    parameters: tuple[str, ...] = ()
    refusal: int = 0


class Table(Generic[InstrumentT]):
    """The commands of an instrument by header pattern; the pattern of a query ends in `?`."""

    def __init__(self, commands: Mapping[str, Action[InstrumentT]]) -> None:
        self._actions = {
            spelling + mark: action
            for pattern, action in commands.items()
            for mark in ("?" if pattern.endswith("?") else "",)
            for spelling in spellings(pattern.removesuffix("?"))
        }
        self._compiled: dict[str, tuple[Call[InstrumentT], ...]] = {}

    def compile(self, message: str) -> tuple[Call[InstrumentT], ...]:
        """The calls of a program message; the last hundreds of messages are remembered."""
        calls = self._compiled.get(message)
        if calls is None:
            if len(self._compiled) >= _REMEMBERED:
                self._compiled.clear()
            calls = self._compiled[message] = tuple(self._calls(message))
        return calls

    def _calls(self, message: str) -> Iterator[Call[InstrumentT]]:
        path = ""
        for unit in _split(message, ";"):
            text = unit.strip()
            if not text:
                continue
            header, _, rest = text.partition(" ")
            header = header.upper()
            if header.startswith("*"):
                yield self._call(header, rest)
                continue
            # Path memory: a header without leading colon continues where the last one was.
            absolute = header.removeprefix(":") if header.startswith(":") or not path else path + header
            path = absolute[: absolute.rfind(":") + 1]
            yield self._call(absolute, rest)

    def _call(self, header: str, rest: str) -> Call[InstrumentT]:
        action = self._actions.get(header)
        if action is None:
            return Call(None, refusal=-113)
        parameters = tuple(part.strip() for part in _split(rest, ",")) if rest.strip() else ()
        return Call(action, parameters)


def _split(text: str, separator: str) -> list[str]:
    """Split at a separator outside of quotes."""
    if '"' not in text and "'" not in text:
        return text.split(separator)
    # Quoted strings are matched as a whole, so that a separator within one does not count.
    pieces = re.findall(
        rf"""(?:"[^"]*"|'[^']*'|[^{separator}])+|(?<={separator})(?={separator}|$)""", text
    )
    return [str(piece) for piece in pieces]


def number(text: str, *, least: float, most: float, default: float | None = None) -> float:
    """A numeric parameter: a number or MIN, MAX, DEF; raises `ScpiError`."""
    word = text.upper()
    named = {"MIN": least, "MINIMUM": least, "MAX": most, "MAXIMUM": most}
    if default is not None:
        named |= {"DEF": default, "DEFAULT": default}
    if word in named:
        return named[word]
    if not _NUMBER.fullmatch(text):
        raise ScpiError(-104)
    value = float(text)
    if not least <= value <= most:
        raise ScpiError(-222)
    return value


def boolean(text: str) -> bool:
    """ON, OFF, 1 or 0; raises `ScpiError`."""
    try:
        return {"ON": True, "1": True, "OFF": False, "0": False}[text.upper()]
    except KeyError:
        raise ScpiError(-224) from None


def keyword(text: str, *choices: str) -> str:
    """One of some keywords (`IMMediate`) in short or long form, as its short form; raises `ScpiError`."""
    for choice in choices:
        forms = tuple(spellings(choice))
        if text.upper() in forms:
            return forms[0]
    raise ScpiError(-224)


def one(parameters: Sequence[str]) -> str:
    """The only parameter; raises `ScpiError` for none or several."""
    if not parameters:
        raise ScpiError(-109)
    if len(parameters) > 1:
        raise ScpiError(-108)
    return parameters[0]


def none(parameters: Sequence[str]) -> None:
    """Raise `ScpiError` if there are parameters."""
    if parameters:
        raise ScpiError(-108)


def block(data: bytes) -> bytes:
    """A definite-length block (IEEE 488.2): `#`, digits of the length, length, data."""
    length = str(len(data)).encode()
    return b"#" + str(len(length)).encode() + length + data
