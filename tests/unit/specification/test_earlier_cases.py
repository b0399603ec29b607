"""Parameters that name an earlier case: what is told before anything is acquired."""

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import pytest

from gyrotest.errors import SpecError
from gyrotest.records.described import EarlierCase
from gyrotest.records.result import Measurand
from gyrotest.records.spec import Case, Output
from gyrotest.specification.spec import load_spec

from .conftest import Stand, catalogue

TIMES = "duration: 1 h, interval: 1 s"


@dataclass(frozen=True, slots=True, kw_only=True)
class NamesCases:
    """Parameters that name a case of any procedure, and one of procedure `static`."""

    any_case: Annotated[str | None, EarlierCase()] = None
    static_case: Annotated[str | None, EarlierCase("static")] = None


class Comparing:
    """A procedure that compares with another case."""

    parameters = NamesCases

    def measurands(self, case: Case, parameters: NamesCases, output: Output) -> tuple[Measurand, ...]:
        return ()

    def complaints(
        self, case: Case, parameters: NamesCases, output: Output
    ) -> Iterable[tuple[str, str]]:
        return ()


@pytest.fixture
def faults(tmp_path: Path) -> Callable[[str], list[str]]:
    """Return the faults of a spec with these cases, each as `key: message`."""

    def read(cases: str) -> list[str]:
        path = tmp_path / "spec.yaml"
        head = "model: X\noutput: {kind: rate}\ncases:\n"
        path.write_text(head + cases, encoding="utf-8")
        try:
            load_spec(path, catalogue(static=Stand(), comparing=Comparing()))
        except SpecError as refused:
            return [f"{fault.key}: {fault.message}" for fault in refused.faults]
        return []

    return read


def case(name: str, procedure: str, parameters: str = "") -> str:
    return f"  {name}: {{procedure: {procedure}, {TIMES}, parameters: {{{parameters}}}}}\n"


def test_a_case_before_its_own_may_be_named(faults: Callable[[str], list[str]]) -> None:
    text = case("rest", "static") + case("one", "comparing", "any_case: rest, static_case: rest")
    assert faults(text) == []
    assert faults(text + case("two", "comparing", "any_case: one")) == []


@pytest.mark.parametrize(
    ("parameters", "expected"),
    [
        ("any_case: rset", "any_case: 'rset' is no case of this spec; did you mean 'rest'?"),
        ("static_case: other", "is no case of this spec; known here: rest"),
        ("any_case: one", "any_case: 'one' is this case itself; name one before it"),
        (
            "any_case: last",
            "'last' stands behind this case, and is measured too late; put it before 'one'",
        ),
        (
            "static_case: zero",
            "'zero' is a case of procedure 'comparing'; put a case of procedure 'static' before this one",
        ),
    ],
)
def test_what_is_wrong_with_a_named_case_is_told(
    faults: Callable[[str], list[str]], parameters: str, expected: str
) -> None:
    text = case("rest", "static") + case("zero", "comparing") + case("one", "comparing", parameters)
    (found,) = faults(text + case("last", "static"))
    assert found.startswith("cases.one.parameters.")
    assert expected in found


def test_where_no_case_would_do_one_is_asked_for(faults: Callable[[str], list[str]]) -> None:
    (found,) = faults(case("one", "comparing", "static_case: rest"))
    assert found.endswith("put a case of procedure 'static' before this one, and name it here")


def test_a_fault_of_the_named_case_is_not_told_twice(faults: Callable[[str], list[str]]) -> None:
    text = case("rest", "nothing") + case("one", "comparing", "static_case: rest")
    (found,) = faults(text)
    assert found.startswith("cases.rest.procedure: ")
