"""Results as properties of a report: strings, and of several axes each by its name."""

from gyrotest.plugin.properties import _pairs
from gyrotest.records.result import JudgedLimit, JudgedResult, Verdict
from gyrotest.records.spec import DecisionRule


def judged(axis: str) -> JudgedResult:
    return JudgedResult(
        case="noise",
        repeat=1,
        axis=axis,
        name="bias",
        label="Bias",
        value=1.5,
        unit="deg/h",
        limit=JudgedLimit(min=None, max=2.0, unit="deg/h", decision=DecisionRule.SIMPLE),
        verdict=Verdict.PASS,
    )


def test_a_result_of_one_axis_alone_bears_its_bare_name() -> None:
    assert dict(_pairs(judged(""))) == {
        "gyro.bias": "1.5 deg/h",
        "gyro.bias.limit": "max 2.0 deg/h",
        "gyro.bias.verdict": "PASS",
    }


def test_results_of_several_axes_have_names_of_their_own() -> None:
    assert list(dict(_pairs(judged("x")))) == ["gyro.x.bias", "gyro.x.bias.limit", "gyro.x.bias.verdict"]
