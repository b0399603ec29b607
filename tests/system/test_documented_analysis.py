"""The example of the page on `gyrotest analyse` works as it is printed."""

import re
import shlex
from pathlib import Path

import pytest

from gyrotest.cli import main

_LABEL = re.compile(r"^ ([A-Z][A-Za-z ,]+?)  ", re.MULTILINE)


def test_the_documented_commands_say_what_is_printed(
    pytestconfig: pytest.Config,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    text = (pytestconfig.rootpath / "docs" / "analyse.md").read_text(encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    (source,) = re.findall(r"```python\n(.*?)```", text, re.DOTALL)
    exec(compile(source, "docs/analyse.md", "exec"), {})
    examples = re.findall(r"```console\n\$ gyrotest (analyse [^\n]*)\n(.*?)```", text, re.DOTALL)
    assert len(examples) == 3
    for command, printed in examples:
        assert main(shlex.split(command)) == 0
        said = capsys.readouterr().out
        if printed:
            assert _LABEL.findall(said) == _LABEL.findall(printed)
            assert said.splitlines()[:2] == printed.splitlines()[:2]
            assert _values(said) == pytest.approx(_values(printed), rel=0.5)
    assert {"allan.png", "rest.csv", "rest.json", "rest.npy"} == {one.name for one in tmp_path.iterdir()}


def _values(said: str) -> list[float]:
    """The angle random walk and the Allan minimum: what every identification finds in this record."""
    return [
        float(value)
        for value in re.findall(
            r"^ (?:Angle random walk N|Allan deviation, minimum) +([\d.]+)", said, re.MULTILINE
        )
    ]
