"""Free sections of documents, checked into the records of those who own them.

A case's `parameters` belong to its procedure, an instrument's `settings` to its driver.
"""

from collections.abc import Mapping
from typing import Any

from gyrotest.errors import DocumentError, Fault, SpecError, StationError
from gyrotest.ports import Procedure
from gyrotest.records.spec import Case
from gyrotest.records.station import Instrument
from gyrotest.specification.checked import Checked, Complaint, checked
from gyrotest.specification.yaml_tree import KeyPath, dotted


def case_parameters(case: Case, procedure: Procedure) -> Any:
    """Return a case's parameters as its procedure's record; raises `SpecError`."""
    return _record_or_raise(case.parameters, procedure.parameters, "parameters", SpecError)


def instrument_settings(instrument: Instrument, driver: Any) -> Any:
    """Return an instrument's settings as its driver's record; raises `StationError`."""
    return _record_or_raise(instrument.settings, driver.settings, "settings", StationError)


def _record_or_raise(tree: Mapping[str, Any], record: Any, name: str, error: type[DocumentError]) -> Any:
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
