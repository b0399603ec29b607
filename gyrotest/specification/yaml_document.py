"""YAML files → plain Python with the line of every key; what cannot be read is refused with its line."""

import hashlib
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import yaml

from gyrotest.errors import DocumentError, Fault
from gyrotest.specification.yaml_tree import DEEPEST, KeyPath, TooDeepError, TreeBuilder, dotted, shown

LARGEST_BYTES = 256 * 1024
# More anchors and references than this are told as one fault: nobody reads a thousand laughs.
_MOST_ANCHORS = 10


@dataclass(frozen=True, slots=True)
class YamlDocument:
    """A file's content: `tree` of dicts, lists and scalars; `lines` of every key path; its faults."""

    path: str
    sha256: str
    tree: dict[str, Any]
    lines: dict[KeyPath, int] = field(default_factory=dict)
    faults: tuple[tuple[KeyPath, Fault], ...] = ()

    def fault(self, key: KeyPath, message: str) -> Fault:
        """Return a complaint about a key, with the line of the key or of what it would stand in."""
        known = next((key[:end] for end in range(len(key), -1, -1) if key[:end] in self.lines), ())
        return Fault(self.path, self.lines.get(known, 1), dotted(key), message)


def read_yaml(path: Path, error: type[DocumentError]) -> YamlDocument:
    """Read a YAML mapping from a file; raises `error` where the file cannot be understood at all."""
    raw = _read(path, error)
    try:
        text = raw.decode("utf-8-sig")
    except UnicodeDecodeError as fault:
        line = raw.count(b"\n", 0, fault.start) + 1
        message = f"byte 0x{raw[fault.start]:02x} is not UTF-8; save the file as UTF-8"
        raise error([Fault(str(path), line, "", message)]) from None
    builder = TreeBuilder(str(path))
    try:
        tree = builder.build(text)
    except yaml.YAMLError as fault:
        raise error([*builder.plain_faults(), _syntax_fault(str(path), text, fault)]) from None
    except TooDeepError as fault:
        message = f"nested deeper than {DEEPEST} levels; is a bracket not closed?"
        raise error([Fault(str(path), fault.line, "", message)]) from None
    if len(builder.anchors) > _MOST_ANCHORS:
        raise error([_of_many(builder.anchors)])
    if not isinstance(tree, dict):
        raise error([*builder.plain_faults(), _no_mapping(str(path), tree)])
    digest = hashlib.sha256(raw).hexdigest()
    return YamlDocument(str(path), digest, tree, builder.lines, tuple(builder.faults))


def _of_many(faults: list[Fault]) -> Fault:
    """The first of many of a kind, which says how many more there are."""
    return replace(
        faults[0], message=f"{faults[0].message}; the same is true of {len(faults) - 1} more below"
    )


def _read(path: Path, error: type[DocumentError]) -> bytes:
    try:
        with path.open("rb") as file:
            raw = file.read(LARGEST_BYTES + 1)
    except FileNotFoundError:
        message = "no such file"
    except IsADirectoryError:
        message = "is a folder; name a YAML file"
    except (OSError, ValueError) as fault:
        reason = fault.strerror if isinstance(fault, OSError) else str(fault)
        message = f"cannot be read: {reason}"
    else:
        if len(raw) <= LARGEST_BYTES:
            return raw
        message = f"larger than {LARGEST_BYTES // 1024} kB; is it a spec or a station at all?"
    raise error([Fault(str(path), None, "", message)])


def _no_mapping(path: str, tree: Any) -> Fault:
    if tree is None:
        return Fault(path, 1, "", "is empty; see the shipped examples for what belongs in it")
    kind = "a list" if isinstance(tree, list) else f"the single value {shown(tree)}"
    return Fault(path, 1, "", f"holds {kind}; a mapping is expected: lines of the form 'key: value'")


def _syntax_fault(path: str, text: str, fault: yaml.YAMLError) -> Fault:
    if isinstance(fault, yaml.reader.ReaderError):
        line = text.count("\n", 0, fault.position) + 1
        return Fault(
            path, line, "", f"the character U+{ord(text[fault.position]):04X} is not allowed in YAML"
        )
    mark = getattr(fault, "problem_mark", None) or getattr(fault, "context_mark", None)
    problem = str(getattr(fault, "problem", None) or "is not YAML")
    return Fault(path, mark.line + 1 if mark else None, "", _in_words(problem))


def _in_words(problem: str) -> str:
    if r"'\t'" in problem:
        return "a tab stands where YAML allows only spaces; indent with spaces"
    if "mapping values are not allowed" in problem:
        return "a second ': ' in one line; put the value in quotes, or check the indentation above"
    if "could not find expected ':'" in problem:
        return "a line without ': '; write 'key: value', or check the indentation"
    return f"is not YAML: {problem}; check indentation, brackets and quotes at and above this line"
