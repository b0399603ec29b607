"""The procedure that the documentation shows works as it is printed."""

import re
import sys
import types
from collections.abc import Iterator
from typing import Any

import pytest

from gyrotest.specification.spec import case_parameters
from tests.unit.procedures.bench import rates, static_case, static_context, voltages


@pytest.fixture
def peak_to_peak(pytestconfig: pytest.Config) -> Iterator[Any]:
    text = (pytestconfig.rootpath / "docs" / "procedures.md").read_text(encoding="utf-8")
    source = re.search(r"```python\n(.*?)```", text, re.DOTALL)
    assert source is not None
    module = types.ModuleType("documented_example")
    sys.modules[module.__name__] = module
    exec(compile(source.group(1), "docs/procedures.md", "exec"), module.__dict__)
    yield module.__dict__["PeakToPeak"]()
    del sys.modules[module.__name__]


def test_the_documented_procedure_plans_and_reduces(peak_to_peak: Any) -> None:
    case = static_case(parameters={"fewest_samples": 20})
    parameters = case_parameters(case, peak_to_peak)
    assert list(peak_to_peak.complaints(case, parameters, static_context().output)) == []
    assert peak_to_peak.plan(case, parameters).samples == 3600
    rate = rates()
    (result,) = peak_to_peak.reduce(voltages(rate), static_context()).results
    assert result.value == pytest.approx(rate.max() - rate.min())
    assert peak_to_peak.measurands(case, parameters, static_context().output)[0].name == result.name
