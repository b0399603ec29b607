"""Results held against limits: the three rules, what never passes, and how it reads."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from gyrotest.conformity import judge, line, worst
from gyrotest.records.result import Contribution, JudgedResult, Measurand, Result, Verdict
from gyrotest.records.spec import DecisionRule, Limit
from gyrotest.units import Dimension, Quantity

MEASURAND = Measurand(name="noise", label="Noise", dimension=Dimension.RATE, unit="deg/h")
SIMPLE, GUARDED, NONBINARY = DecisionRule.SIMPLE, DecisionRule.GUARDED, DecisionRule.GUARDED_NONBINARY
finite = st.floats(-1e6, 1e6)


def limit(
    low: float | None = None, high: float | None = None, rule: DecisionRule = SIMPLE, unit: str = "deg/h"
) -> Limit:
    ends = (None if one is None else Quantity(one, unit) for one in (low, high))
    return Limit(min=next(ends), max=next(ends), decision=rule)


def judged(value: float | None, wanted: Limit | None, **more: object) -> JudgedResult:
    result = Result(name="noise", label="Noise", value=value, unit="deg/h", **more)  # type: ignore[arg-type]
    return judge(MEASURAND, result, wanted, case="static", repeat=1)


@pytest.mark.parametrize(
    ("value", "verdict"),
    [(9.9, Verdict.PASS), (10.0, Verdict.PASS), (10.1, Verdict.FAIL), (-1.0, Verdict.FAIL)],
)
def test_the_simple_rule_looks_at_the_value_alone(value: float, verdict: Verdict) -> None:
    assert judged(value, limit(0.0, 10.0), expanded_uncertainty=5.0).verdict is verdict


@pytest.mark.parametrize(
    ("value", "guarded", "nonbinary"),
    [
        (8.0, Verdict.PASS, Verdict.PASS),
        (9.5, Verdict.FAIL, Verdict.CONDITIONAL_PASS),
        (10.5, Verdict.FAIL, Verdict.CONDITIONAL_FAIL),
        (11.5, Verdict.FAIL, Verdict.FAIL),
    ],
)
def test_the_guarded_rules_look_at_the_whole_interval(
    value: float, guarded: Verdict, nonbinary: Verdict
) -> None:
    for rule, verdict in ((GUARDED, guarded), (NONBINARY, nonbinary)):
        by_uncertainty = judged(value, limit(high=10.0, rule=rule), expanded_uncertainty=1.0)
        by_interval = judged(value, limit(high=10.0, rule=rule), lower_95=value - 1, upper_95=value + 1)
        assert (by_uncertainty.verdict, by_interval.verdict) == (verdict, verdict)


@pytest.mark.parametrize("rule", list(DecisionRule))
@pytest.mark.parametrize("value", [math.nan, math.inf, -math.inf, None])
def test_what_is_no_number_never_passes(rule: DecisionRule, value: float | None) -> None:
    found = judged(value, limit(-1e9, 1e9, rule), expanded_uncertainty=1.0)
    assert (found.verdict, found.value) == (Verdict.INCOMPLETE, None)
    assert found.reason


def test_an_uncertainty_that_is_no_number_never_passes() -> None:
    found = judged(1.0, limit(high=10.0, rule=GUARDED), lower_95=0.0, upper_95=math.nan)
    assert found.verdict is Verdict.INCOMPLETE
    assert "upper 95 is not finite" in found.reason


def test_what_was_not_measured_is_incomplete() -> None:
    found = judge(MEASURAND, None, limit(high=10.0), case="static", repeat=None)
    assert (found.verdict, found.reason, found.unit) == (Verdict.INCOMPLETE, "not measured", "deg/h")
    assert line(found) == "noise: not measured, limit ≤ 10 °/h"


def test_why_a_value_could_not_be_had_is_the_reason() -> None:
    found = judged(None, limit(high=10.0), condition="dead time cannot be corrected")
    assert found.reason == "dead time cannot be corrected"


@pytest.mark.parametrize("rule", [GUARDED, NONBINARY])
def test_guarded_rules_refuse_an_uncertainty_that_is_not_whole_or_not_there(rule: DecisionRule) -> None:
    partial = judged(1.0, limit(high=10.0, rule=rule), expanded_uncertainty=1.0, not_included=("meter",))
    assert partial.verdict is Verdict.INCOMPLETE
    assert "not included: meter" in partial.reason
    assert judged(1.0, limit(high=10.0, rule=rule)).verdict is Verdict.INCOMPLETE
    assert judged(1.0, limit(high=10.0), not_included=("meter",)).verdict is Verdict.PASS


@pytest.mark.parametrize("rule", [GUARDED, NONBINARY])
def test_one_end_of_an_interval_decides_what_it_can(rule: DecisionRule) -> None:
    """As of a range that was only tested so far, or of a threshold beyond the largest change tried."""
    at_least = {"lower_95": 118.0}
    assert judged(120.0, limit(low=100.0, rule=rule), **at_least).verdict is Verdict.PASS
    assert judged(120.0, limit(high=110.0, rule=rule), **at_least).verdict is Verdict.FAIL
    open_end = judged(120.0, limit(high=130.0, rule=rule), **at_least)
    assert (open_end.verdict, open_end.reason) == (
        Verdict.INCOMPLETE,
        "a guarded decision needs an uncertainty",
    )
    at_most = {"upper_95": 3.0}
    assert judged(2.0, limit(low=5.0, rule=rule), **at_most).verdict is Verdict.FAIL
    assert judged(2.0, limit(low=1.0, high=4.0, rule=rule), **at_most).verdict is Verdict.INCOMPLETE


@pytest.mark.parametrize("rule", list(DecisionRule))
def test_an_upper_bound_can_pass_a_maximum_but_no_minimum(rule: DecisionRule) -> None:
    bound = {"at_most": True, "lower_95": 0.0, "upper_95": 8.0}
    assert judged(7.0, limit(high=10.0, rule=rule), **bound).verdict is Verdict.PASS
    assert judged(7.0, limit(low=1.0, rule=rule), **bound).verdict is Verdict.INCOMPLETE
    assert judged(17.0, limit(high=5.0, rule=rule), **bound).verdict not in {
        Verdict.PASS,
        Verdict.CONDITIONAL_PASS,
    }


def test_a_failed_upper_bound_says_what_it_is() -> None:
    found = judged(7.0, limit(high=5.0), at_most=True, lower_95=0.0, upper_95=8.0)
    assert (found.verdict, found.reason) == (
        Verdict.FAIL,
        "an upper bound; the record shows no lower one",
    )


@pytest.mark.parametrize("rule", list(DecisionRule))
def test_a_lower_bound_can_pass_a_minimum_but_no_maximum(rule: DecisionRule) -> None:
    bound = {"at_least": True, "lower_95": 98.0}
    assert judged(100.0, limit(low=80.0, rule=rule), **bound).verdict is Verdict.PASS
    assert judged(100.0, limit(high=120.0, rule=rule), **bound).verdict is Verdict.INCOMPLETE
    assert judged(100.0, limit(80.0, 120.0, rule=rule), **bound).verdict is Verdict.INCOMPLETE
    assert judged(100.0, limit(high=90.0, rule=rule), **bound).verdict is Verdict.FAIL
    assert judged(100.0, limit(low=101.0, rule=rule), **bound).verdict not in {
        Verdict.PASS,
        Verdict.CONDITIONAL_PASS,
    }


def test_a_failed_lower_bound_says_what_it_is() -> None:
    found = judged(100.0, limit(low=110.0), at_least=True)
    assert (found.verdict, found.reason) == (
        Verdict.FAIL,
        "a lower bound; the record shows no upper one",
    )
    beyond = judged(100.0, limit(high=90.0), at_least=True)
    assert (beyond.verdict, beyond.reason) == (Verdict.FAIL, "")


@pytest.mark.parametrize("rule", list(DecisionRule))
def test_a_limit_without_ends_passes_nothing(rule: DecisionRule) -> None:
    found = judged(1.0, limit(rule=rule), expanded_uncertainty=0.1)
    assert found.verdict is Verdict.INCOMPLETE


@pytest.mark.parametrize("rule", list(DecisionRule))
def test_a_minimum_alone_is_a_limit(rule: DecisionRule) -> None:
    assert judged(5.0, limit(low=1.0, rule=rule), expanded_uncertainty=1.0).verdict is Verdict.PASS
    assert judged(-5.0, limit(low=1.0, rule=rule), expanded_uncertainty=1.0).verdict is Verdict.FAIL


def test_the_result_is_judged_in_the_limits_unit_with_its_budget() -> None:
    result = Result(
        name="noise",
        label="Noise",
        value=0.001,
        unit="deg/s",
        expanded_uncertainty=0.0002,
        coverage_factor=2.0,
        budget=(
            Contribution(
                source="a",
                kind="A",
                distribution="normal",
                half_width="",
                sensitivity="1",
                standard_uncertainty=0.0001,
            ),
        ),
    )
    found = judge(MEASURAND, result, limit(high=4.0), case="static", repeat=1)
    assert (found.unit, found.verdict) == ("deg/h", Verdict.PASS)
    assert found.value == pytest.approx(3.6)
    assert found.expanded_uncertainty == pytest.approx(0.72)
    assert found.budget[0].standard_uncertainty == pytest.approx(0.36)


def test_without_a_limit_a_result_is_for_information_in_its_own_unit() -> None:
    found = judged(3.0, None)
    assert (found.verdict, found.limit, found.unit) == (None, None, "deg/h")


def test_ends_in_different_units_are_both_converted() -> None:
    wanted = Limit(min=Quantity(-0.001, "deg/s"), max=Quantity(3.6, "deg/h"))
    found = judged(-3.5, wanted)
    assert found.limit is not None
    assert found.limit.min == pytest.approx(-3.6)
    assert found.verdict is Verdict.PASS


@given(value=finite, uncertainty=st.floats(0, 1e6), low=finite, width=st.floats(0, 1e6))
def test_guarded_is_never_kinder_than_simple(
    value: float, uncertainty: float, low: float, width: float
) -> None:
    verdicts = [
        judged(value, limit(low, low + width, rule), expanded_uncertainty=uncertainty).verdict
        for rule in (SIMPLE, GUARDED, NONBINARY)
    ]
    simple, guarded, nonbinary = verdicts
    assert (guarded is Verdict.PASS) == (nonbinary is Verdict.PASS)
    if guarded is Verdict.PASS:
        assert simple is Verdict.PASS
    if simple is Verdict.PASS:
        assert nonbinary in {Verdict.PASS, Verdict.CONDITIONAL_PASS}
    else:
        assert nonbinary in {Verdict.FAIL, Verdict.CONDITIONAL_FAIL}


@given(st.lists(st.sampled_from(list(Verdict)), min_size=1))
def test_the_worst_verdict_is_pass_only_if_all_are(verdicts: list[Verdict]) -> None:
    assert (worst(verdicts) is Verdict.PASS) == (set(verdicts) == {Verdict.PASS})
    assert worst([*verdicts, Verdict.INCOMPLETE]) is Verdict.INCOMPLETE


def test_of_no_verdict_at_all_the_worst_is_incomplete() -> None:
    assert worst([]) is Verdict.INCOMPLETE


@pytest.mark.parametrize(
    ("found", "text"),
    [
        (
            judged(12.49, limit(high=10.0), lower_95=11.71, upper_95=13.62),
            "noise = 12.5 °/h [11.7, 13.6], limit ≤ 10 °/h",
        ),
        (judged(10.0001, limit(high=10.0)), "noise = 10.0001 °/h, limit ≤ 10 °/h"),
        (
            judged(-0.123, limit(-2.0, 2.0, GUARDED), expanded_uncertainty=0.0321),
            "noise = −0.123 ± 0.032 °/h, limit −2 … 2 °/h (guarded)",
        ),
        (
            judged(0.151234, limit(-2.0, 2.0), expanded_uncertainty=0.00212),
            "noise = 0.1512 ± 0.0021 °/h, limit −2 … 2 °/h",
        ),
        (judged(1234.5, None, expanded_uncertainty=560.0), "noise = 1230 ± 560 °/h"),
        (judged(5.0, limit(high=10.0), at_most=True), "noise ≤ 5 °/h, limit ≤ 10 °/h"),
        (judged(5.0, limit(low=4.0), at_least=True), "noise ≥ 5 °/h, limit ≥ 4 °/h"),
        (judged(12345.0, limit(low=20000.0)), "noise = 12300 °/h, limit ≥ 20000 °/h"),
        (judged(5.0, None), "noise = 5 °/h"),
    ],
)
def test_a_result_reads_in_one_line(found: JudgedResult, text: str) -> None:
    assert line(found) == text


def test_a_result_of_several_axes_names_its_own() -> None:
    result = Result(name="noise", label="Noise", value=12.5, unit="deg/h")
    found = judge(MEASURAND, result, limit(high=10.0), case="static", repeat=1, axis="x")
    assert found.axis == "x"
    assert line(found) == "noise (axis x) = 12.5 °/h, limit ≤ 10 °/h"
    missing = judge(MEASURAND, None, limit(high=10.0), case="static", repeat=1, axis="z")
    assert missing.axis == "z"
    assert line(missing) == "noise (axis z): not measured, limit ≤ 10 °/h"
