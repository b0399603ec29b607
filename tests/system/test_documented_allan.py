"""The examples of the page on the Python interface print what is printed there."""

import re

import pytest

_EXAMPLE = re.compile(r"```python\n(.*?)```(?:\n\n```text\n(.*?)```)?", re.DOTALL)
_NUMBER = re.compile(r"\d+(?:\.\d+)?(?:e[+-]?\d+)?")


def test_the_documented_examples_print_what_is_printed(
    pytestconfig: pytest.Config, capsys: pytest.CaptureFixture[str]
) -> None:
    text = (pytestconfig.rootpath / "docs" / "allan.md").read_text(encoding="utf-8")
    examples = _EXAMPLE.findall(text)
    assert len(examples) == 8
    names: dict[str, object] = {}
    for source, printed in examples:
        exec(compile(source, "docs/allan.md", "exec"), names)
        said = capsys.readouterr().out
        assert _NUMBER.sub("#", said) == _NUMBER.sub("#", printed)
        # Another machine may round the last digit otherwise.
        assert _numbers(said) == pytest.approx(_numbers(printed), rel=0.02)


def _numbers(text: str) -> list[float]:
    return [float(one) for one in _NUMBER.findall(text)]
