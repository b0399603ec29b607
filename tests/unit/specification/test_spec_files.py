"""Specs: what is read, and every complaint, all at once and with its line."""

from collections.abc import Callable
from pathlib import Path

import pytest

from gyrotest.errors import SpecError
from gyrotest.records.spec import Between, Case, DecisionRule, Limit, Over, SpecDocument
from gyrotest.specification.spec import case_parameters, load_spec
from gyrotest.units import Quantity

from .conftest import Parameters, Stand

Read = Callable[[str], SpecDocument]
Faults = Callable[[str], list[str]]

GOOD = """\
model: MEMS50
serial_pattern: '[0-9]{4,8}'
output:
  kind: voltage
  scale_factor: 50 mV/(deg/s)
  zero_rate: 2.5 V
datasheet: {angle_random_walk: 0.5 deg/sqrt(h), bias_stability_10s: 20 deg/h}
cases:
  rest:
    procedure: static
    warm_up: 10 min
    duration: 1 h
    interval: 1 s
    repeats: 3
    mounting: [1, 0, 0]
    parameters: {smoothing: [1 s, 10 s]}
    limits:
      bias: {min: -2 deg/s, max: 2 deg/s}
      bias_stability_10s: {max: 40 deg/h, decision: guarded}
      bias_run_to_run: {max: 60 deg/h, over: repeats}
"""


def edited(*changes: tuple[str, str]) -> str:
    text = GOOD
    for old, new in changes:
        assert old in text
        text = text.replace(old, new, 1)
    return text


def test_a_good_spec_becomes_a_record(spec: Read) -> None:
    document = spec(GOOD)
    case = document.spec.cases["rest"]
    assert document.spec.model == "MEMS50"
    assert document.spec.output.scale_factor == Quantity(50.0, "mV/(deg/s)")
    assert case.duration.to("s") == 3600.0
    assert case.mounting == (1.0, 0.0, 0.0)
    assert case.between_repeats is Between.NOTHING
    assert case.limits["bias_stability_10s"].decision is DecisionRule.GUARDED
    assert case.limits["bias_run_to_run"] == Limit(max=Quantity(60.0, "deg/h"), over=Over.REPEATS)
    assert len(document.sha256) == 64


def test_parameters_become_the_procedures_own_record(spec: Read) -> None:
    case = spec(GOOD).spec.cases["rest"]
    assert case_parameters(case, Stand()) == Parameters(
        smoothing=(Quantity(1.0, "s"), Quantity(10.0, "s"))
    )


def test_parameters_that_do_not_fit_are_refused() -> None:
    time = Quantity(1.0, "s")
    case = Case(procedure="static", duration=time, interval=time, parameters={"smooth": 1})
    with pytest.raises(SpecError, match=r"parameters\.smooth: unknown key; did you mean 'smoothing'\?"):
        case_parameters(case, Stand())


@pytest.mark.parametrize(
    ("old", "new", "expected"),
    [
        ("model: MEMS50", "model: 1234", "1: model: 1234 is not text; put it in quotes: '1234'"),
        ("model: MEMS50", "model: ' '", "1: model: ' ' is not a name of 1 to 64 printable characters"),
        ("model: MEMS50", f"model: {'x' * 65}", "is not a name of 1 to 64"),
        ("model: MEMS50", 'model: "a\\tb"', "is not a name of 1 to 64"),
        (
            "model: MEMS50\n",
            "",
            "1: model: is missing (The model's name, as it is printed); write e.g. 'model: M",
        ),
        ("model: MEMS50", "model:", "1: model: has no value"),
        ("model:", "modle: x\nmodel:", "1: modle: unknown key; did you mean 'model'?"),
        (
            "kind: voltage",
            "kind: volts",
            "'volts' is not one of voltage, rate, count; did you mean 'voltage'?",
        ),
        (
            "kind: voltage",
            "kind: rate",
            "output.scale_factor: '50 mV/(deg/s)' is not a ratio, as 'kind: rate' needs",
        ),
        (
            "kind: voltage",
            "kind: rate",
            "output.zero_rate: '2.5 V' is not an angular rate, as 'kind: rate' needs",
        ),
        (
            "  scale_factor: 50 mV/(deg/s)\n",
            "",
            "3: output.scale_factor: is missing; a gyro with a voltage",
        ),
        ("50 mV/(deg/s)", "50 mV/deg/s", "is not a scale factor in volts per angular rate"),
        (
            "50 mV/(deg/s)",
            "50",
            "50 is not a quantity (a number and its unit); write e.g. '50 mV/(deg/s)'",
        ),
        ("50 mV/(deg/s)", "0 mV/(deg/s)", "output.scale_factor: is zero"),
        ("zero_rate: 2.5 V", "scale_factor_uncertainty: -1 %", "'-1 %' is not from 0 % to below 100 %"),
        ("zero_rate: 2.5 V", "full_scale: 0 deg/s", "'0 deg/s' is not more than zero"),
        ("zero_rate: 2.5 V", "bandwidth: 50 s", "'50 s' is not a frequency; write e.g. '50 Hz'"),
        ("'[0-9]{4,8}'", "'[0-9'", "2: serial_pattern: '[0-9' is no regular expression"),
        ("'[0-9]{4,8}'", "'[[a-z]'", "is no regular expression"),
        ("angle_random_walk: 0.5", "arw: 0.5", "7: datasheet.arw: is not measured by this case"),
        (
            "0.5 deg/sqrt(h)",
            "0.5 deg/h",
            "'0.5 deg/h' is not an angle random walk; write e.g. '0.5 deg/sqrt(h)'",
        ),
        ("angle_random_walk: 0.5 deg/sqrt(h)", "bias_instability: 3 deg/h", "names two quantities"),
        ("  rest:", "  Rest 1:", "9: cases.Rest 1: a case is named by small letters"),
        ("procedure: static", "procedure: statik", "cannot be used: 'statik' is not installed (static)"),
        ("duration: 1 h", "duration: 0 h", "'0 h' is not more than zero"),
        ("interval: 1 s", "interval: -1 s", "'-1 s' is not more than zero"),
        (
            "duration: 1 h",
            "duration: 1.5 s",
            "'1.5 s' is no whole number of intervals of '1 s'; write e.g. '1 s'",
        ),
        ("duration: 1 h", "duration: 1 s", "'1 s' is less than two intervals of '1 s'"),
        ("duration: 1 h", "duration: 1e300 h", "is more than 1,000,000,000 samples"),
        ("interval: 1 s", "interval: 1e-300 s", "is more than 1,000,000,000 samples"),
        ("    duration: 1 h\n", "", "9: cases.rest.duration: is missing (Length of each record"),
        ("warm_up: 10 min", "warm_up: -1 s", "'-1 s' is less than zero"),
        ("warm_up: 10 min", "warm_up: 10", "10 is not a quantity"),
        ("warm_up: 10 min", "warmup: 10 min", "cases.rest.warmup: unknown key; did you mean 'warm_up'?"),
        ("repeats: 3", "repeats: 0", "0 is not between 1 and 1000"),
        (
            "repeats: 3",
            "repeats: 3.0",
            "14: cases.rest.repeats: 3.0 is not a whole number; write e.g. 3",
        ),
        ("repeats: 3", "repeats: yes", "'yes' is not a whole number"),
        ("repeats: 3", "repeats: true", "true is not a whole number"),
        ("repeats: 3", "repeats: '3'", "'3' is not a whole number"),
        ("repeats: 3", "repeats: 3\n    retests: -1", "-1 is not between 0 and 100"),
        ("repeats: 3", "repeats: 1", "bias_run_to_run: is computed over the repeats, and 1 is too few"),
        ("[1, 0, 0]", "[0, 0, 0]", "is no direction"),
        ("[1, 0, 0]", "[1, 0]", "[1, 0] is not a list of 3, such as [1, 0, 0]"),
        ("[1, 0, 0]", "[1, 0, 0, 0]", "is not a list of 3"),
        ("[1, 0, 0]", "[1, 0, up]", "15: cases.rest.mounting[2]: 'up' is not a number"),
        ("[1, 0, 0]", "[1, 0, .nan]", "'.nan' is not a number"),
        ("[1, 0, 0]", "up", "'up' is not a list of 3"),
        (
            "smoothing: [1 s",
            "smoothing: [1 V",
            "16: cases.rest.parameters.smoothing[0]: '1 V' is not a time",
        ),
        (
            "smoothing: [1 s",
            "smoothing: [1.5 s",
            "smoothing[0]: '1.5 s' is no whole number of intervals",
        ),
        (
            "smoothing: [1 s",
            "smooth: 1, smoothing: [1 s",
            "smooth: unknown key; did you mean 'smoothing'?",
        ),
        ("{smoothing: [1 s, 10 s]}", "5", "5 is not a mapping"),
        (
            "min: -2 deg/s",
            "min: 3 deg/s",
            "min '3 deg/s' is greater than max '2 deg/s'; no value can pass",
        ),
        ("min: -2 deg/s", "min: -2 V", "min '-2 V' and max '2 deg/s' are of different kinds"),
        ("min: -2 deg/s, max: 2 deg/s", "max: 2 V", "limits.bias.max: '2 V' is not an angular rate"),
        ("min: -2 deg/s, max: 2 deg/s", "", "has neither 'min' nor 'max'"),
        ("min: -2 deg/s", "min: -2", "-2 is not a quantity"),
        (
            "bias: {",
            "biass: {",
            "18: cases.rest.limits.biass: is not measured by this case; did you mean 'bias'?",
        ),
        (
            "bias: {",
            "bias_instability: {",
            "'allan_minimum' (the curve's lowest point, as in most datasheets) or 'bias_",
        ),
        ("bias_stability_10s: {", "bias_stability: {", "needs its averaging time"),
        (
            "bias_stability_10s: {",
            "bias_stability_9s: {",
            "measures bias_stability_1s, bias_stability_10s; add what you want to its parameters",
        ),
        ("bias_run_to_run: {", "bias_repeatability: {", "write 'between_repeats: power_cycle'"),
        (
            "repeats: 3",
            "repeats: 3\n    between_repeats: power_cycle",
            "the name is 'bias_repeatability'",
        ),
        (", over: repeats", "", "is computed over the repeats; add 'over: repeats' to the limit"),
        (
            "max: 2 deg/s}",
            "max: 2 deg/s, over: repeats}",
            "limits.bias.over: is measured in each repeat; remove",
        ),
        ("over: repeats", "over: all", "'all' is not one of repeats"),
        ("decision: guarded", "decision: guard", "did you mean 'guarded'?"),
        ("limits:", "limits: 5\n    limit:", "5 is not a mapping"),
    ],
)
def test_what_is_wrong_is_told_in_the_users_words(
    spec_faults: Faults, old: str, new: str, expected: str
) -> None:
    faults = spec_faults(edited((old, new)))
    assert any(expected in fault for fault in faults), faults
    assert not any("input" in fault.lower() and "valid" in fault for fault in faults), faults


def test_all_faults_are_told_at_once_in_the_order_of_lines(spec_faults: Faults) -> None:
    faults = spec_faults(
        edited(
            ("model: MEMS50", "model: 5"),
            ("kind: voltage", "kind: volts"),
            ("warm_up: 10 min", "warmup: 10 min"),
            ("repeats: 3", "repeats: 2.5"),
            ("max: 2 deg/s", "max: -3 deg/s"),
        )
    )
    assert [fault.split(":")[0] for fault in faults] == ["1", "4", "11", "14", "18"]


def test_nothing_is_concluded_from_what_is_already_wrong(spec_faults: Faults) -> None:
    assert len(spec_faults(edited(("repeats: 3", "repeats: three")))) == 1
    assert len(spec_faults(edited(("kind: voltage", "kind: volts")))) == 1
    assert len(spec_faults(edited(("duration: 1 h", "duration: 1 V")))) == 1
    assert len(spec_faults(edited(("procedure: static", "procedure: statik")))) == 1
    assert len(spec_faults(edited(("max: 40 deg/h, decision", "max: 40, decision")))) == 1


def test_faults_of_the_document_and_of_its_content_are_told_together(spec_faults: Faults) -> None:
    faults = spec_faults(
        edited(("repeats: 3", "repeats: 3\n    repeats: 4"), ("max: 2 deg/s", "max: 2"))
    )
    assert len(faults) == 2
    assert "15: cases.rest.repeats: the key stands here twice (first in line 14)" in faults[0]


def test_a_spec_without_cases_tests_nothing(spec_faults: Faults) -> None:
    head = GOOD[: GOOD.index("cases:")]
    assert any("cases: is missing" in fault for fault in spec_faults(head))
    assert any("cases: is empty" in fault for fault in spec_faults(head + "cases: {}\n"))


def test_thousands_of_faults_are_cut_short(spec_faults: Faults) -> None:
    faults = spec_faults(GOOD + "".join(f"key{n}: 1\n" for n in range(3000)))
    assert len(faults) == 51
    assert "more faults" in faults[-1]


def test_the_message_names_file_line_and_key(spec: Read, tmp_path: Path) -> None:
    with pytest.raises(SpecError) as refused:
        spec(edited(("max: 2 deg/s", "max: 2 V"), ("min: -2 deg/s, ", "")))
    expected = f"{tmp_path / 'spec.yaml'}:18: cases.rest.limits.bias.max: '2 V' is not an angular rate"
    assert str(refused.value).startswith(expected)


def test_an_unknown_procedure_names_the_installed_ones(tmp_path: Path) -> None:
    path = tmp_path / "a.yaml"
    path.write_text(edited(("procedure: static", "procedure: statik")), encoding="utf-8")
    with pytest.raises(SpecError, match=r"'statik' is not among the .* that are installed \(.*static"):
        load_spec(path)


COUNTS = (("kind: voltage", "kind: count"), ("zero_rate: 2.5 V", "zero_rate: 12 count"))


def test_counts_have_a_scale_factor_and_a_zero_in_counts(spec: Read, spec_faults: Faults) -> None:
    good = edited(*COUNTS, ("50 mV/(deg/s)", "131 count/(deg/s)"))
    assert spec(good).spec.output.zero_rate == Quantity(12.0, "count")
    (volts,) = spec_faults(edited(*COUNTS))
    assert "'50 mV/(deg/s)' is not a scale factor in counts per angular rate, as 'kind: count'" in volts
    (zero,) = spec_faults(edited(COUNTS[0], ("50 mV/(deg/s)", "131 count/(deg/s)")))
    assert "output.zero_rate: '2.5 V' is not a number of counts, as 'kind: count' needs" in zero


def test_counts_may_come_without_a_scale_factor_where_no_case_needs_it(spec: Read) -> None:
    without = edited(*COUNTS, ("  scale_factor: 50 mV/(deg/s)\n", ""))
    assert spec(without).spec.output.scale_factor is None


def test_a_static_case_needs_the_scale_factor_of_counts(tmp_path: Path) -> None:
    path = tmp_path / "s.yaml"
    path.write_text(edited(*COUNTS, ("  scale_factor: 50 mV/(deg/s)\n", "")), encoding="utf-8")
    with pytest.raises(SpecError, match=r"cases.rest.procedure: turns counts into rates and needs"):
        load_spec(path)
