"""The run record as JSON: canonical, readable, and read back without loss."""

import functools
import hashlib
import json
from typing import TYPE_CHECKING, Any

from gyrotest.errors import CertificateError
from gyrotest.records.run import SCHEMA_VERSION, RunRecord

if TYPE_CHECKING:
    from pydantic import TypeAdapter


def record_bytes(record: RunRecord) -> bytes:
    """Return the record as UTF-8 JSON; raises `CertificateError` for what JSON cannot hold."""
    from pydantic_core import PydanticSerializationError

    try:
        tree = _adapter().dump_python(record, mode="json")
        return (_json(tree, "") + "\n").encode()
    except (ValueError, PydanticSerializationError) as error:
        raise CertificateError(
            f"the record of {record.run_id} cannot be written as JSON: {error}"
        ) from error


def read_record(data: bytes) -> RunRecord:
    """Read a record's bytes; raises `CertificateError` for another schema or a broken record."""
    from pydantic import ValidationError

    try:
        found = json.loads(data, parse_constant=_refuse_constant)
    except ValueError as error:
        raise CertificateError(f"the run record is not JSON: {error}") from error
    version = found.get("schema_version") if isinstance(found, dict) else None
    if version != SCHEMA_VERSION:
        raise CertificateError(
            f"the run record has schema_version {version!r}, this gyrotest reads {SCHEMA_VERSION}"
        )
    try:
        return _adapter().validate_json(data)
    except ValidationError as error:
        first = error.errors()[0]
        place = ".".join(str(part) for part in first["loc"])
        raise CertificateError(
            f"the run record is broken in {error.error_count()} places: {place}: {first['msg']}"
        ) from error


def record_sha256(data: bytes) -> str:
    """The hash by which a certificate names its record, hexadecimal."""
    return hashlib.sha256(data).hexdigest()


@functools.cache
def _adapter() -> "TypeAdapter[RunRecord]":
    from pydantic import TypeAdapter

    return TypeAdapter(RunRecord)


def _refuse_constant(name: str) -> Any:
    raise ValueError(f"{name} is not a number that a record may hold")


def _json(tree: Any, indent: str) -> str:
    """Write mappings and lists of them over several lines, lists of numbers on one."""
    deeper = indent + " "
    if isinstance(tree, dict) and tree:
        lines = (f"{deeper}{_leaf(str(key))}: {_json(value, deeper)}" for key, value in tree.items())
        return "{\n" + ",\n".join(lines) + f"\n{indent}}}"
    if isinstance(tree, list) and any(isinstance(item, dict | list) for item in tree):
        return "[\n" + ",\n".join(deeper + _json(item, deeper) for item in tree) + f"\n{indent}]"
    return _leaf(tree)


def _leaf(value: Any) -> str:
    return json.dumps(value, allow_nan=False, ensure_ascii=False)
