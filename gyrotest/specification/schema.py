"""The JSON Schema of specs and stations, by which editors complete and check them."""

from collections.abc import Mapping
from typing import Any, Literal

from pydantic import TypeAdapter

from gyrotest.records.spec import Spec
from gyrotest.records.station import Station
from gyrotest.registry import INSTRUMENTS, PROCEDURES, load, names
from gyrotest.specification.reference import rendered_reference
from gyrotest.specification.yaml_tree import TreeBuilder
from gyrotest.units import Quantity

Document = Literal["spec", "station"]
Sections = Mapping[str, type[Any]]

DIALECT = "https://json-schema.org/draft/2020-12/schema"


def installed_sections(document: Document) -> Sections:
    """Return the installed procedures' parameters, or drivers' settings, by name."""
    group, attribute = (PROCEDURES, "parameters") if document == "spec" else (INSTRUMENTS, "settings")
    return {name: getattr(load(group, name), attribute) for name in names(group)}


def json_schema(document: Document, sections: Sections | None = None) -> dict[str, Any]:
    """Return the schema of a document; `sections` are the parameters or settings, by name."""
    found = installed_sections(document) if sections is None else sections
    record: type[Any] = Spec if document == "spec" else Station
    schema = _without_nulls(TypeAdapter(record).json_schema())
    if document == "spec":
        _choose(schema, "Case", "procedure", "parameters", found)
    else:
        _choose(schema, "Instrument", "driver", "settings", found)
    title = "gyrotest spec" if document == "spec" else "gyrotest station"
    return {"$schema": DIALECT, "title": title} | {k: v for k, v in schema.items() if k != "title"}


def reference_markdown() -> str:
    """Return the page of all keys, those of the installed procedures and drivers among them."""
    return rendered_reference(json_schema("spec"), json_schema("station"))


def _choose(schema: dict[str, Any], record: str, chooser: str, section: str, sections: Sections) -> None:
    """Let the value of one key decide what a free section below its neighbour may hold."""
    definitions: dict[str, Any] = schema["$defs"]
    place = definitions[record]
    place["properties"][chooser]["enum"] = sorted(sections)
    choices = []
    for name, fields in sorted(sections.items()):
        own = _without_nulls(TypeAdapter(fields).json_schema())
        definitions.update(own.pop("$defs", {}))
        definitions[f"{name}.{section}"] = own | {"additionalProperties": False}
        then = {"properties": {section: {"$ref": f"#/$defs/{name}.{section}"}}}
        choices.append({"if": {"properties": {chooser: {"const": name}}}, "then": then})
    if choices:
        place["allOf"] = choices


def _without_nulls(node: Any) -> Any:
    """Drop `null`: in a document a key without a value is a fault, and an absent one has its default."""
    if isinstance(node, list):
        return [_without_nulls(one) for one in node]
    if not isinstance(node, dict):
        return node
    if node.keys() == {"value", "unit"} and isinstance(node["value"], float):
        return str(Quantity(node["value"], node["unit"]))  # a default
    kept = {key: _without_nulls(value) for key, value in node.items() if not _is_noise(key, value)}
    if isinstance(examples := kept.get("examples"), list):
        kept["examples"] = [_plain(one) for one in examples]
    options = [one for one in kept.get("anyOf", ()) if one != {"type": "null"}]
    if len(options) == 1:
        kept = {key: value for key, value in kept.items() if key != "anyOf"}
        kept = options[0] | kept
    elif options:
        kept["anyOf"] = options
    return kept


def _plain(example: Any) -> Any:
    """Return an example, which is written as in a document, as the value that it stands for."""
    return TreeBuilder("").build(example) if isinstance(example, str) else example


def _is_noise(key: str, value: Any) -> bool:
    return (key == "default" and value is None) or (key == "title" and isinstance(value, str))
