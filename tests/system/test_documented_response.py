"""What the page on the frequency response says is what is found."""

import contextlib
import io
import re
from collections.abc import Iterable

import pytest

from tests.benchmarks.response_estimators import Case, cases, honesty, picture, table

_NUMBER = re.compile(r"[−-]?\d+(?:\.\d+)?")


@pytest.fixture(scope="module")
def page(pytestconfig: pytest.Config) -> str:
    return (pytestconfig.rootpath / "docs" / "frequency-response.md").read_text(encoding="utf-8")


@pytest.fixture(scope="module")
def found() -> list[Case]:
    return list(cases())


def test_the_example_prints_what_is_documented(page: str) -> None:
    blocks = re.findall(r"```python\n(.*?)```\n\n```text\n(.*?)```", page, re.DOTALL)
    assert len(blocks) == 1
    printed = io.StringIO()
    with contextlib.redirect_stdout(printed):
        exec(compile(blocks[0][0], "frequency-response.md", "exec"), {})
    assert printed.getvalue() == blocks[0][1]


def test_the_documented_errors_of_the_estimators_are_what_is_found(page: str, found: list[Case]) -> None:
    same(_between(page, "estimators"), table(found), absolute=0.02)


def test_the_documented_scores_of_many_units_are_what_is_found(page: str) -> None:
    documented = _between(page, "honesty")
    for mean, deviation in re.findall(r"\| ([+−]\d\.\d\d) \| (\d\.\d\d) \|", documented):
        assert abs(float(mean.replace("−", "-"))) <= 0.3
        assert 0.8 <= float(deviation) <= 1.25
    same(re.sub(r"\| [+−]?\d\.\d\d ", "| # ", documented), honesty(3), only_words=True)


def test_the_picture_has_three_estimators_and_the_truth_for_each_ratio(found: list[Case]) -> None:
    panels = picture(found).panels
    assert [one.note for one in panels] == ["κ = 0.1", "κ = 1", "κ = 10"]
    assert {tuple(curve.label for curve in one.curves) for one in panels} == {
        ("H1", "H2", "Hv", "truth")
    }


def _between(page: str, name: str) -> str:
    documented: list[str] = re.findall(rf"<!-- {name}: begin.*?-->\n(.*?)\n<!--", page, re.DOTALL)
    assert len(documented) == 1
    return documented[0]


def same(
    documented: str, lines: Iterable[str], *, absolute: float = 0.0, only_words: bool = False
) -> None:
    said = "\n".join(lines)
    if only_words:
        said = re.sub(r"\| [+−]?\d\.\d\d ", "| # ", said)
    assert _NUMBER.sub("#", said) == _NUMBER.sub("#", documented)
    values = [
        [float(one.replace("−", "-")) for one in _NUMBER.findall(text)] for text in (said, documented)
    ]
    assert values[0] == pytest.approx(values[1], abs=absolute)
