"""The reference page of all keys, made from the JSON Schema so that the two cannot disagree."""

import json
from collections.abc import Iterator, Mapping
from typing import Any

Schema = Mapping[str, Any]

_HEAD = """# Keys of specs and stations

This page is made from the schema (`gyrotest schema spec`, `gyrotest schema station`); do not edit it.
A quantity is a number and its unit, such as `10 min` or `50 mV/(deg/s)`. An unknown key is refused.
"""

_COLUMNS = "| Key | Accepts | Default | Meaning | Example |\n|---|---|---|---|---|"


def rendered_reference(spec: Schema, station: Schema) -> str:
    """Return the reference of all keys in Markdown, from the schemas of both documents."""
    parts = [_HEAD, "## Spec\n", *_document(spec), "## Station\n", *_document(station)]
    return "\n".join(parts).rstrip() + "\n"


def _document(schema: Schema) -> Iterator[str]:
    definitions: Schema = schema["$defs"]
    yield _section("Top level", schema, definitions)
    for name in _reachable(schema, definitions):
        yield _section(name, definitions[name], definitions)


def _reachable(schema: Schema, definitions: Schema) -> list[str]:
    """Return the records in the order in which a reader meets them; choices stand in the tables."""
    found: list[str] = []
    waiting = _references(schema.get("properties", {})) + _references(schema.get("allOf", []))
    while waiting:
        name = waiting.pop(0)
        if name not in found and "properties" in definitions[name]:
            found.append(name)
            below = definitions[name]
            waiting = _references(below["properties"]) + waiting + _references(below.get("allOf", []))
    return found


def _references(node: Any) -> list[str]:
    if isinstance(node, list):
        return [name for one in node for name in _references(one)]
    if not isinstance(node, Mapping):
        return []
    own = [node["$ref"].rpartition("/")[2]] if "$ref" in node else []
    return own + [name for one in node.values() for name in _references(one)]


def _section(name: str, schema: Schema, definitions: Schema) -> str:
    required = schema.get("required", ())
    rows = [
        _row(key, place, definitions, required=key in required)
        for key, place in schema["properties"].items()
    ]
    if not rows:
        return f"### {_heading(name)}\n\nNo keys.\n"
    text = schema.get("description", "")
    return "\n".join([f"### {_heading(name)}\n", *([f"{text}\n"] if text else []), _COLUMNS, *rows, ""])


def _heading(name: str) -> str:
    owner, dot, section = name.partition(".")
    return f"`{section}` of `{owner}`" if dot else name


def _row(key: str, place: Schema, definitions: Schema, *, required: bool) -> str:
    examples = place.get("examples", ())
    cells = (
        f"`{key}`",
        _accepts(place, definitions),
        "required" if required else _default(place),
        place.get("description", ""),
        f"`{_written(examples[0])}`" if examples else "",
    )
    return "| " + " | ".join(cell.replace("|", "\\|").replace("\n", " ") for cell in cells) + " |"


def _accepts(place: Schema, definitions: Schema) -> str:
    """Return in words what a place accepts, a record as a link to its section."""
    if "$ref" in place:
        name = place["$ref"].rpartition("/")[2]
        choices = definitions.get(name, {}).get("enum")
        return " or ".join(f"`{one}`" for one in choices) if choices else f"[{name}](#{name.lower()})"
    if "anyOf" in place:
        return " or ".join(_accepts(one, definitions) for one in place["anyOf"])
    return str(place["x-quantity"]) if "x-quantity" in place else _plain_type(place, definitions)


def _plain_type(place: Schema, definitions: Schema) -> str:
    kind, below, items = place.get("type"), place.get("additionalProperties"), place.get("items")
    if kind == "object":
        return (
            f"names with {_accepts(below, definitions) if isinstance(below, Mapping) else 'any value'}"
        )
    if kind == "array" and isinstance(items, Mapping):
        return f"list: {_accepts(items, definitions)} each"
    if place.get("format") == "date":
        return "date"
    names = {"string": "text", "integer": "whole number", "boolean": "true or false", "array": "list"}
    return names.get(str(kind), str(kind or "any value"))


def _default(place: Schema) -> str:
    default = place.get("default")
    return "" if default in (None, "", {}, []) else f"`{_written(default)}`"


def _written(value: Any) -> str:
    """Return a value as it is written in a document, a line end as its escape."""
    if isinstance(value, str):
        return value if value.isprintable() else json.dumps(value)
    if isinstance(value, Mapping):
        return "{" + ", ".join(f"{key}: {_written(one)}" for key, one in value.items()) + "}"
    if isinstance(value, list):
        return "[" + ", ".join(_written(one) for one in value) + "]"
    return json.dumps(value)
