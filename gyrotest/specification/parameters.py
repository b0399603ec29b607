"""Free sections of documents, checked into the records of those who own them.

A case's `parameters` belong to its procedure, an instrument's `settings` to its driver.
"""

from collections.abc import Mapping
from typing import Any

from gyrotest.errors import DocumentError, Fault
from gyrotest.specification.checked import Checked, Complaint, checked
from gyrotest.specification.yaml_tree import KeyPath, dotted


def section_or_raise(tree: Mapping[str, Any], record: Any, name: str, error: type[DocumentError]) -> Any:
    """Return a free section as a record; raises `error` with every complaint."""
    found = section(tree, record, (name,))
    if found.complaints:
        raise error([Fault("", None, dotted(one.key), one.message) for one in found.complaints])
    return found.record


def section(tree: Mapping[str, Any], record: Any, key: KeyPath) -> Checked[Any]:
    """Check a free section that stands at `key` into a record."""
    found = checked(dict(tree), record)
    return Checked(
        found.record, tuple(Complaint((*key, *one.key), one.message) for one in found.complaints)
    )
