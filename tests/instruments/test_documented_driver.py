"""The driver in the documentation works as it stands there."""

import re
from pathlib import Path
from typing import Any

import pytest


def test_the_worked_example_runs(pytestconfig: pytest.Config) -> None:
    page = Path(pytestconfig.rootpath, "docs", "instruments.md").read_text(encoding="utf-8")
    driver, dialogue = re.findall(r"^```python\n(.*?)^```$", page, re.DOTALL | re.MULTILINE)
    names: dict[str, Any] = {"__name__": "documented"}
    exec(driver, names)
    exec(dialogue, names)
    assert names["meter"].close() is None
