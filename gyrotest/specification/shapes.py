"""The shape that a record gives a document: which keys stand where, and what each accepts."""

import dataclasses
import difflib
import types
import typing
from collections.abc import Iterator, Mapping, Sequence
from datetime import date
from enum import Enum
from typing import Any

from gyrotest.records.described import Described
from gyrotest.specification.yaml_tree import KeyPath
from gyrotest.units import OfDimension, Quantity


@dataclasses.dataclass(frozen=True, slots=True)
class Shape:
    """What one place of a document accepts: a plain type, its annotations, whether it may be absent."""

    kind: Any
    annotations: tuple[Any, ...] = ()
    required: bool = True

    @property
    def described(self) -> Described:
        """What the place means."""
        found = [note for note in self.annotations if isinstance(note, Described)]
        return found[0] if found else Described("")

    @property
    def quantity(self) -> OfDimension | None:
        """The dimensions accepted, where the place holds a quantity."""
        found = [note for note in self.annotations if isinstance(note, OfDimension)]
        return found[0] if found else None

    @property
    def is_record(self) -> bool:
        """Whether the place holds a mapping with known keys."""
        return dataclasses.is_dataclass(self.kind) and self.kind is not Quantity

    @property
    def is_choice(self) -> bool:
        """Whether the place holds one of a few words."""
        return isinstance(self.kind, type) and issubclass(self.kind, Enum)

    @property
    def origin(self) -> Any:
        """The container that the place holds, or None."""
        return typing.get_origin(self.kind)

    def choices(self) -> tuple[str, ...]:
        """Return the words accepted."""
        return tuple(str(member.value) for member in self.kind)

    def child(self, part: str | int) -> "Shape | None":
        """Return the shape below a key or an index; None where nothing is known of it."""
        if self.is_record:
            return fields_of(self.kind).get(str(part))
        arguments = typing.get_args(self.kind)
        if self.origin in {Mapping, dict} and len(arguments) == 2:
            return shape_of(arguments[1])
        if self.origin in {tuple, list, Sequence} and arguments and isinstance(part, int):
            return shape_of(
                arguments[part] if part < len(arguments) and ... not in arguments else arguments[0]
            )
        return None

    def at(self, key: KeyPath) -> "Shape | None":
        """Return the shape at a path below this one."""
        shape: Shape | None = self
        for part in key:
            shape = shape.child(part) if shape else None
        return shape


def shape_of(hint: Any, *, required: bool = True) -> Shape:
    """Return the shape of a type hint: annotations and `| None` taken apart."""
    annotations: list[Any] = []
    while True:
        origin, arguments = typing.get_origin(hint), typing.get_args(hint)
        if origin is typing.Annotated:
            annotations.extend(arguments[1:])
            hint = arguments[0]
        elif (
            origin in {typing.Union, types.UnionType} and type(None) in arguments and len(arguments) == 2
        ):
            hint = next(one for one in arguments if one is not type(None))
        else:
            return Shape(hint, tuple(annotations), required)


def fields_of(record: type[Any]) -> dict[str, Shape]:
    """Return the keys of a record, in its order, with their shapes."""
    hints = typing.get_type_hints(record, include_extras=True)
    absent = dataclasses.MISSING
    return {
        field.name: shape_of(
            hints[field.name],
            required=field.default is absent and field.default_factory is absent,
        )
        for field in dataclasses.fields(record)
        if field.init
    }


def unknown_keys(tree: Any, shape: Shape | None, key: KeyPath = ()) -> Iterator[tuple[KeyPath, str]]:
    """Give every key that no record has, with a message that names the nearest one."""
    if shape is None or not isinstance(tree, dict | list):
        return
    for part, value in tree.items() if isinstance(tree, dict) else enumerate(tree):
        if shape.is_record and isinstance(tree, dict) and shape.child(part) is None:
            yield (*key, part), f"unknown key; {nearest(str(part), fields_of(shape.kind))}"
        else:
            yield from unknown_keys(value, shape.child(part), (*key, part))


def nearest(word: str, known: typing.Iterable[str]) -> str:
    """Return 'did you mean …?' for a word that is not known, or the list of what is."""
    words = list(known)
    near = difflib.get_close_matches(word.lower(), words, n=1, cutoff=0.6)
    listed = ", ".join(words) if words else "none"
    return f"did you mean '{near[0]}'?" if near else f"known here: {listed}"


def stand_in(shape: Shape) -> Any:
    """Return a value that the shape accepts, so that the rest of a faulty document can be checked."""
    if shape.is_record:
        return {name: stand_in(below) for name, below in fields_of(shape.kind).items() if below.required}
    if shape.is_choice:
        return shape.choices()[0]
    if shape.quantity is not None:
        return shape.quantity.example()
    if shape.origin is not None:
        return _stand_in_of_parts(shape)
    simple = {int: 1, float: 1.0, bool: False, date: "2000-01-01"}
    return simple.get(shape.kind, "x")


def _stand_in_of_parts(shape: Shape) -> Any:
    parts = typing.get_args(shape.kind)
    if shape.origin in {typing.Union, types.UnionType}:
        # A record may take few of all texts; its own example is one of them.
        return shape.described.example or stand_in(shape_of(parts[0]))
    if shape.origin is tuple and ... not in parts:
        return [stand_in(shape_of(one)) for one in parts]
    return {} if shape.origin in {Mapping, dict} else []
