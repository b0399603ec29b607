"""YAML text → a tree of dicts, lists and scalars; whatever is ambiguous or hostile becomes a fault.

Scalars are read by the core rules of YAML 1.2: `yes`, `on`, `1:30` and dates stay text. Anchors,
references, tags, duplicate keys and several documents are faults.
"""

import re
from collections.abc import Iterator
from typing import Any

import yaml

from gyrotest.errors import Fault

DEEPEST = 20

KeyPath = tuple[str | int, ...]

_INT = re.compile(r"[-+]?[0-9]{1,18}")
_FLOAT = re.compile(r"[-+]?(?:[0-9]+(?:\.[0-9]*)?|\.[0-9]+)(?:[eE][-+]?[0-9]{1,3})?")
_BOOL = {"true": True, "True": True, "TRUE": True, "false": False, "False": False, "FALSE": False}
_NULL = {"", "~", "null", "Null", "NULL"}


def dotted(key: KeyPath) -> str:
    """Return a key path as text: `cases.static.mounting[1]`."""
    text = "".join(f"[{part}]" if isinstance(part, int) else f".{part}" for part in key)
    return text.removeprefix(".")


def shown(value: Any) -> str:
    """Return a value from a document as it is shown in a message, cut to a sensible length."""
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, dict):
        return "a mapping"
    text = repr(value)
    return text if len(text) <= 60 else f"{text[:60]}…"


class TooDeepError(Exception):
    """The text is nested deeper than any sensible document."""

    def __init__(self, line: int) -> None:
        self.line = line
        super().__init__(line)


class TreeBuilder:
    """Builds the tree from the parser's events, which needs no recursion and expands nothing."""

    def __init__(self, path: str) -> None:
        self._path = path
        self._depth = 0
        self.lines: dict[KeyPath, int] = {}
        self.faults: list[tuple[KeyPath, Fault]] = []
        self.anchors: list[Fault] = []

    def plain_faults(self) -> list[Fault]:
        """Return the faults found so far."""
        return [fault for _, fault in self.faults]

    def build(self, text: str) -> Any:
        """Return the tree of the text's first document; raises `yaml.YAMLError`."""
        events = (event for event in yaml.parse(text, Loader=yaml.SafeLoader))
        tree, documents = None, 0
        for event in events:
            if isinstance(event, yaml.DocumentStartEvent):
                documents += 1
                if documents == 2:
                    self._fault((), event, "a second document begins here ('---'); one file holds one")
                    break
                tree = self._value(next(events), events, ())
        return tree

    def _value(self, event: yaml.Event, events: Iterator[yaml.Event], key: KeyPath) -> Any:
        self.lines.setdefault(key, _line(event))
        self._refuse_marks(event, key)
        if isinstance(event, yaml.ScalarEvent):
            if any(0xD800 <= ord(character) <= 0xDFFF for character in event.value):
                self._fault(key, event, "half of a surrogate pair is no character; write it out")
                return None
            return _scalar(event)
        if isinstance(event, yaml.AliasEvent):
            return None
        self._depth += 1
        if self._depth > DEEPEST:
            raise TooDeepError(_line(event))
        mapping = isinstance(event, yaml.MappingStartEvent)
        value = self._mapping(events, key) if mapping else self._list(events, key)
        self._depth -= 1
        return value

    def _mapping(self, events: Iterator[yaml.Event], key: KeyPath) -> dict[str, Any]:
        found: dict[str, Any] = {}
        for event in events:
            if isinstance(event, yaml.MappingEndEvent):
                break
            name = self._name(event, events, key)
            below = (*key, name)
            if name in found:
                first = self.lines[below]
                self._fault(
                    below, event, f"the key stands here twice (first in line {first}); remove one"
                )
                self._value(next(events), events, (*key, name, "(again)"))
                continue
            self.lines[below] = _line(event)
            found[name] = self._value(next(events), events, below)
        return found

    def _name(self, event: yaml.Event, events: Iterator[yaml.Event], key: KeyPath) -> str:
        self._refuse_marks(event, key)
        if isinstance(event, yaml.ScalarEvent):
            return str(event.value)
        self._fault(key, event, "a key must be plain text, not a list, a mapping or a reference")
        if not isinstance(event, yaml.AliasEvent):
            self._value(event, events, (*key, "(key)"))
        return "(key)"

    def _list(self, events: Iterator[yaml.Event], key: KeyPath) -> list[Any]:
        found: list[Any] = []
        for event in events:
            if isinstance(event, yaml.SequenceEndEvent):
                break
            found.append(self._value(event, events, (*key, len(found))))
        return found

    def _refuse_marks(self, event: Any, key: KeyPath) -> None:
        anchor = getattr(event, "anchor", None)
        if anchor:
            mark = (
                f"a reference ('*{anchor}')"
                if isinstance(event, yaml.AliasEvent)
                else f"an anchor ('&{anchor}')"
            )
            self._fault(key, event, f"{mark} is not allowed; write the value out")
            self.anchors.append(self.faults[-1][1])
        if getattr(event, "tag", None):
            self._fault(key, event, f"a tag ('{event.tag}') is not allowed; write plain values")

    def _fault(self, key: KeyPath, event: yaml.Event, message: str) -> None:
        fault = Fault(self._path, _line(event), dotted(key), message)
        self.faults.append((key, fault))


def _line(event: Any) -> int:
    return int(event.start_mark.line) + 1


def _scalar(event: yaml.ScalarEvent) -> Any:
    text: str = event.value
    if event.style is not None:
        return text
    if text in _NULL:
        return None
    if text in _BOOL:
        return _BOOL[text]
    if _INT.fullmatch(text):
        return int(text)
    if _FLOAT.fullmatch(text):
        return _finite_or_text(text)
    return text


def _finite_or_text(text: str) -> float | str:
    value = float(text)
    return value if abs(value) < float("inf") else text
