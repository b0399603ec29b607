"""A tree from a document → a record, with every complaint about keys and types at once.

Where something is wrong, a stand-in takes its place, so that the rest can still be checked; a
complaint about what depends on a stand-in is held back.
"""

import copy
import functools
import json
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from typing import Any, Generic, TypeVar, cast

from pydantic import TypeAdapter, ValidationError

from gyrotest.specification.shapes import Shape, shape_of, stand_in, unknown_keys
from gyrotest.specification.words import in_words
from gyrotest.specification.yaml_tree import KeyPath

Record = TypeVar("Record")
_PASSES = 10


@dataclass(frozen=True, slots=True)
class Complaint:
    """What is wrong at a key; `because` names other keys that it was concluded from."""

    key: KeyPath
    message: str
    because: tuple[KeyPath, ...] = ()


@dataclass(frozen=True, slots=True)
class Checked(Generic[Record]):
    """A record and the complaints about the tree that it was made from.

    Where the record refuses even a tree of stand-ins, it is None, and there are complaints.
    """

    record: Record
    complaints: tuple[Complaint, ...]


def checked(tree: Any, record: type[Record], found: Iterable[Complaint] = ()) -> Checked[Record]:
    """Make a record of a tree; what is wrong in it is told in the complaints, after those `found`."""
    shape, tree = shape_of(record), copy.deepcopy(tree)
    complaints = [*found, *_empty_values(tree, ())]
    complaints += [Complaint(key, message) for key, message in unknown_keys(tree, shape)]
    for complaint in complaints:
        _replace(tree, shape, complaint.key)
    for _ in range(_PASSES):
        value, wrong = _validated(tree, record, shape)
        if not wrong:
            return Checked(value, tuple(complaints))
        complaints += [one for one in wrong if not related(one.key, complaints)]
        for one in wrong:
            tree = _replace(tree, shape, one.key)
    if any(not one.key for one in wrong):
        return Checked(cast("Record", None), tuple(complaints))
    raise RuntimeError(f"no stand-in is accepted for {[one.key for one in wrong]}")


def related(key: KeyPath, complaints: Iterable[Complaint]) -> bool:
    """Whether a complaint is about this key, or about something above or below it."""
    return any(_is_above(one.key, key) or _is_above(key, one.key) for one in complaints)


def unrelated(later: Iterable[Complaint], earlier: Iterable[Complaint]) -> list[Complaint]:
    """Return the complaints that rest on nothing already complained about."""
    before = tuple(earlier)
    return [one for one in later if not any(related(key, before) for key in (one.key, *one.because))]


def _is_above(key: KeyPath, other: KeyPath) -> bool:
    return other[: len(key)] == key


def _empty_values(tree: Any, key: KeyPath) -> Iterator[Complaint]:
    if tree is None:
        yield Complaint(key, "has no value; give it one, or remove the line")
    elif isinstance(tree, dict | list):
        for part, value in tree.items() if isinstance(tree, dict) else enumerate(tree):
            yield from _empty_values(value, (*key, part))


@functools.lru_cache(maxsize=64)
def _adapter(record: Any) -> Any:
    return TypeAdapter(record)


def _validated(tree: Any, record: Any, shape: Shape) -> tuple[Any, list[Complaint]]:
    try:
        return _adapter(record).validate_json(json.dumps(tree, default=str), strict=True), []
    except ValidationError as error:
        wrong = error.errors(include_url=False, include_context=False)
    return None, [_complaint(one, tree, shape) for one in wrong]


def _complaint(error: Any, tree: Any, shape: Shape) -> Complaint:
    key = tuple(error["loc"])
    while key and (shape.at(key) is None or _is_list_end(tree, key)):
        key = key[:-1]
    name = str(key[-1]) if key else ""
    kind = error["type"] if key == tuple(error["loc"]) else "shape"
    return Complaint(key, in_words(kind, error["msg"], _value(tree, key), shape.at(key), name))


def _is_list_end(tree: Any, key: KeyPath) -> bool:
    """Whether the key stands for an item that a list is too short to have."""
    above, part = _value(tree, key[:-1]), key[-1]
    return isinstance(above, list) and isinstance(part, int) and part >= len(above)


def _value(tree: Any, key: KeyPath) -> Any:
    for part in key:
        try:
            tree = tree[part]
        except (KeyError, IndexError, TypeError):
            return None
    return tree


def _replace(tree: Any, shape: Shape, key: KeyPath) -> Any:
    """Put a stand-in where something required is wrong, and drop what is optional or unknown."""
    if not key:
        return stand_in(shape)
    parent, place = _value(tree, key[:-1]), shape.at(key)
    part: Any = key[-1]
    if isinstance(parent, list) and isinstance(part, int):
        if part < len(parent):
            parent[part] = stand_in(place) if place else "x"
    elif isinstance(parent, dict):
        above = shape.at(key[:-1])
        if place is not None and place.required and above is not None and above.is_record:
            parent[part] = stand_in(place)
        else:
            parent.pop(part, None)
    return tree
