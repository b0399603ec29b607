"""The examples of the page on g-sensitivity run, and give what the page says."""

import contextlib
import io
import re
from pathlib import Path

import pytest
import yaml

from gyrotest.specification.spec import load_spec

pytestmark = [pytest.mark.slow]

PAGE = Path(__file__).parents[2] / "docs" / "g-sensitivity.md"


def test_the_example_prints_what_is_documented() -> None:
    blocks = re.findall(r"```python\n(.*?)```\n\n```text\n(.*?)```", PAGE.read_text("utf-8"), re.DOTALL)
    assert len(blocks) == 1
    printed = io.StringIO()
    with contextlib.redirect_stdout(printed):
        exec(compile(blocks[0][0], PAGE.name, "exec"), {})
    assert printed.getvalue() == blocks[0][1]


def test_the_documented_case_is_one(tmp_path: Path) -> None:
    (block,) = re.findall(r"```yaml\n(.*?)```", PAGE.read_text("utf-8"), re.DOTALL)
    document = yaml.safe_load(block)
    document |= {"model": "M", "output": {"kind": "rate"}}
    static = {
        **document["cases"]["turning"],
        "parameters": {"positions": ["0 deg", "90 deg", "180 deg"]},
    }
    document["cases"] = {"positions": {**static, "limits": {}}, **document["cases"]}
    (tmp_path / "spec.yaml").write_text(yaml.safe_dump(document, sort_keys=False), encoding="utf-8")
    spec = load_spec(tmp_path / "spec.yaml").spec
    assert list(spec.cases) == ["positions", "turning"]


def test_the_documented_scores_are_honest_ones() -> None:
    rows = re.findall(r"^\| .* \| \d\.\d \| (.*) \|$", PAGE.read_text("utf-8"), re.MULTILINE)
    assert len(rows) == 7
    for row in rows:
        mean, deviation = row.split(" | ")[0].split(", ")
        assert abs(float(mean.replace("−", "-"))) <= 0.3
        assert 0.8 <= float(deviation) <= 1.25
