"""Pydantic's complaints in the words of the person who wrote the file: found, expected, an example."""

import types
import typing
from collections.abc import Mapping
from datetime import date
from typing import Any

from gyrotest.specification.shapes import Shape, nearest
from gyrotest.specification.yaml_tree import shown

_PLAIN = {
    str: "text",
    int: "a whole number",
    float: "a number",
    bool: "true or false",
    date: "a date such as 2026-03-31",
}


def in_words(kind: str, original: str, found: Any, shape: Shape | None, name: str) -> str:
    """Return the message for one pydantic error of type `kind` and text `original`.

    `found` is the value in the document, `shape` what its place accepts and `name` its key.
    """
    if kind == "quantity" or shape is None:
        return original
    if kind in {"value_error", "assertion_error"}:
        return original.partition(", ")[2]
    if kind == "missing":
        return _missing(shape, name)
    if shape.is_choice and isinstance(found, str):
        listed = ", ".join(shape.choices())
        near = nearest(found, shape.choices())
        return f"{shown(found)} is not one of {listed}" + (f"; {near}" if near.startswith("did") else "")
    advice = _advice(found, shape)
    return f"{shown(found)} is not {expected(shape)}" + (f"; {advice}" if advice else "")


def expected(shape: Shape) -> str:
    """Return what a place accepts, in words."""
    if shape.quantity is not None:
        kinds = " or ".join(one.spoken() for one in shape.quantity.dimensions)
        return kinds or "a quantity (a number and its unit)"
    if shape.is_choice:
        return f"one of {', '.join(shape.choices())}"
    if shape.is_record or shape.origin in {Mapping, dict}:
        return "a mapping (lines of the form 'key: value')"
    if shape.origin is types.UnionType:
        return " or ".join(_PLAIN.get(one, str(one)) for one in typing.get_args(shape.kind))
    if shape.origin is not None:
        arguments = typing.get_args(shape.kind)
        count = "" if not arguments or ... in arguments else f" of {len(arguments)}"
        return f"a list{count}" + (
            f", such as {shape.described.example}" if shape.described.example else ""
        )
    return _PLAIN.get(shape.kind, "what is accepted here")


def _missing(shape: Shape, name: str) -> str:
    described = shape.described
    example = described.example or (shape.quantity.example() if shape.quantity else "")
    meaning = f" ({described.text.rstrip('.')})" if described.text else ""
    return f"is missing{meaning}" + (f"; write e.g. '{name}: {example}'" if example else "")


def _advice(found: Any, shape: Shape) -> str:
    if shape.kind is str and isinstance(found, bool | int | float):
        return f"put it in quotes: '{shown(found)}'"
    if shape.described.example and shape.origin is None:
        return f"write e.g. {shape.described.example}"
    return ""
