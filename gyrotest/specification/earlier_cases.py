"""What must hold of a parameter that names another case: one before its own, of a fitting procedure."""

from collections.abc import Iterator, Mapping
from typing import Any

from gyrotest.errors import GyrotestError
from gyrotest.ports import Procedure
from gyrotest.records.described import EarlierCase
from gyrotest.records.spec import Case
from gyrotest.specification.cases import Catalogue
from gyrotest.specification.checked import Complaint
from gyrotest.specification.shapes import fields_of, nearest


def earlier_case_complaints(cases: Mapping[str, Case], procedures: Catalogue) -> Iterator[Complaint]:
    """Give what is wrong with the parameters by which cases of a spec name others."""
    for name, case in cases.items():
        for parameter, wanted in _references(_parameters_of(case, procedures)):
            named = case.parameters.get(parameter)
            if isinstance(named, str) and named.strip():
                key = ("cases", name, "parameters", parameter)
                other = cases.get(named)
                if other is None or _parameters_of(other, procedures):
                    yield from (Complaint(key, one) for one in _faults(named, name, wanted, cases))


def _parameters_of(case: Case, procedures: Catalogue) -> type[Any] | None:
    """Return the record of a case's parameters; None where its procedure is not installed."""
    try:
        procedure: Procedure = procedures(case.procedure)
    except (GyrotestError, ImportError):
        return None
    return procedure.parameters


def _references(parameters: type[Any] | None) -> Iterator[tuple[str, EarlierCase]]:
    """Give the parameters that name a case."""
    for name, shape in fields_of(parameters).items() if parameters else ():
        yield from ((name, one) for one in shape.annotations if isinstance(one, EarlierCase))


def _faults(named: str, own: str, wanted: EarlierCase, cases: Mapping[str, Case]) -> Iterator[str]:
    before = list(cases)[: list(cases).index(own)]
    if named == own:
        yield f"'{named}' is this case itself; name one before it"
    elif named not in cases:
        fits = [one for one in before if wanted.accepts(cases[one].procedure)]
        yield f"'{named}' is no case of this spec; {nearest(named, fits) if fits else _add(wanted)}"
    elif named not in before:
        yield f"'{named}' stands behind this case, and is measured too late; put it before '{own}'"
    elif not wanted.accepts(cases[named].procedure):
        yield f"'{named}' is a case of procedure '{cases[named].procedure}'; {_add(wanted)}"


def _add(wanted: EarlierCase) -> str:
    of = f" of procedure '{wanted.procedure}'" if wanted.procedure else " that measures it"
    return f"put a case{of} before this one, and name it here"
