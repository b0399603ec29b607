"""What the static procedure refuses: bad samples, gaps, dead outputs, cases that cannot be."""

import dataclasses

import numpy as np
import pytest

from gyrotest.errors import InsufficientDataError
from gyrotest.procedures.static import Static, StaticParameters
from gyrotest.records.recording import Gap, SampleFlag, Samples
from gyrotest.records.spec import Case, Gaps, OutputKind
from gyrotest.units import Quantity
from tests.unit.procedures.bench import (
    by_name,
    meter_sampling,
    rates,
    samples_of,
    static_case,
    static_context,
    voltage_output,
    voltages,
)


def refusal(samples: Samples, **changes: object) -> str:
    with pytest.raises(InsufficientDataError) as caught:
        Static().reduce(samples, static_context(**changes))
    return str(caught.value)


def test_a_flagged_sample_is_named() -> None:
    samples = voltages(rates())
    samples.flags[[17, 20]] = SampleFlag.OVERLOAD
    assert "sample 17 is flagged overload (2 of 3600" in refusal(samples)


@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf])
def test_a_sample_that_is_no_number_is_named(bad: float) -> None:
    samples = voltages(rates())
    samples.values[42, 0] = bad
    assert "sample 42 is" in refusal(samples)


def test_a_constant_a_stuck_and_a_dead_output_are_no_gyro() -> None:
    assert "all 3600 samples read 2.5 V" in refusal(samples_of(np.full(3600, 2.5)))
    stuck = voltages(rates())
    stuck.values[1000:1100] = stuck.values[1000]
    assert "samples 1000 … 1099 all read" in refusal(stuck)
    noise = 3e-6 * np.random.default_rng(1).standard_normal(3600)
    assert "not distinguishable from the meter" in refusal(samples_of(2.5 + noise))


def test_an_output_that_only_flickers_between_two_codes_has_a_bias_and_no_noise() -> None:
    """What may be a dead output whose meter's noise is not known passes no maximum."""
    values = np.full(3600, 0.35)
    values[::37] += 0.05
    output = voltage_output(kind=OutputKind.RATE, scale_factor=None, zero_rate=None)
    samples = samples_of(values, sampling=meter_sampling(unit="deg/s", noise=None))
    reduction = Static().reduce(samples, static_context(output=output, accuracy=None))
    bias, *spreads = reduction.results
    assert bias.value is not None
    assert (bias.expanded_uncertainty or 0.0) > 0.025
    assert [one.value for one in spreads] == [None] * 10
    assert "not distinguishable from rounding" in spreads[0].condition
    assert "steps of 0.05 °/s" in spreads[0].condition
    assert all(not panel.marks for figure in reduction.figures for panel in figure.panels)


def test_a_gap_is_refused_and_named() -> None:
    index = np.arange(3600)
    index[1500:] += 7
    samples = samples_of(voltages(rates()).values[:, 0], index=index)
    text = refusal(samples, gaps=(Gap(after=1499, missing=7, reason="no reply to READ?"),))
    assert "1 gap in the record, after sample 1499 (no reply to READ?)" in text
    assert "longest_stretch" in text


def gapped() -> dict[str, Samples]:
    plain = voltages(rates()).values[:, 0]
    index, time_s = np.arange(3600), np.arange(3600.0)
    index[1500:] += 7
    time_s[1500:] += 7.0
    return {
        "index": samples_of(plain, index=index),
        "time": samples_of(plain, time_s=time_s),
        "gaps": samples_of(plain),
    }


@pytest.mark.parametrize("kind", ["index", "time", "gaps"])
def test_the_longest_stretch_is_used_where_the_case_says_so(kind: str) -> None:
    samples = gapped()[kind]
    found = Static().reduce(
        samples,
        static_context(
            case=static_case(gaps=Gaps.LONGEST_STRETCH, mounting=None),
            gaps=(Gap(after=1499, missing=7, reason="time-out"),),
        ),
    )
    bias = by_name(found.results)["bias"]
    assert bias.value == pytest.approx(rates()[1500:].mean())
    assert "longest gap-free stretch, 2100 of 3600 samples" in bias.condition
    assert found.remarks == ("The record has gaps; used: samples 1507 … 3606.",)


def test_too_short_a_stretch_is_refused() -> None:
    samples = samples_of(voltages(rates(samples=60)).values[:, 0], index=np.arange(60) * 2)
    case = static_case(gaps=Gaps.LONGEST_STRETCH)
    assert "1 samples are left" in refusal(samples, case=case)


def test_a_window_beyond_the_record_is_refused() -> None:
    parameters = StaticParameters(window=(Quantity(0.0, "s"), Quantity(2.0, "h")))
    assert "ends beyond the record of 3600 s" in refusal(voltages(rates()), parameters=parameters)


def test_a_window_counts_time_not_samples() -> None:
    """Of a record with seven missing, 100 s from 25 min on are those after the gap."""
    window = StaticParameters(
        window=(Quantity(1507.0, "s"), Quantity(1607.0, "s")), smoothing=seconds(1.0)
    )
    for kind in ("index", "time"):
        found = Static().reduce(
            gapped()[kind], static_context(parameters=window, case=static_case(mounting=None))
        )
        assert by_name(found.results)["bias"].value == pytest.approx(rates()[1500:1600].mean())
    late = StaticParameters(window=(Quantity(0.0, "s"), Quantity(3608.0, "s")))
    assert "ends beyond the record of 3607 s" in refusal(gapped()["index"], parameters=late)


@pytest.mark.parametrize(("unit", "kind"), [("V", OutputKind.RATE), ("deg/s", OutputKind.VOLTAGE)])
def test_a_source_of_another_kind_than_the_output_is_refused(unit: str, kind: OutputKind) -> None:
    samples = samples_of(rates(), sampling=meter_sampling(unit=unit, noise=None))
    output = voltage_output(
        kind=kind,
        scale_factor=None if kind is OutputKind.RATE else Quantity(1.0, "V/(deg/s)"),
        zero_rate=None,
    )
    assert f"the spec's output is a {kind.value}: correct 'output.kind'" in refusal(
        samples, output=output
    )


def test_a_voltage_without_a_scale_factor_is_refused() -> None:
    output = voltage_output(scale_factor=None)
    assert "scale_factor is not given" in refusal(voltages(rates()), output=output)


def complaints(case: Case, **parameters: object) -> dict[str, str]:
    return dict(Static().complaints(case, StaticParameters(**parameters), voltage_output()))  # type: ignore[arg-type]


def seconds(*values: float) -> tuple[Quantity, ...]:
    return tuple(Quantity(one, "s") for one in values)


def test_a_good_case_has_no_complaint() -> None:
    assert complaints(static_case()) == {}
    assert complaints(static_case(), start=Quantity(1.0, "min"), window=seconds(0.0, 1800.0)) == {}


@pytest.mark.parametrize(
    ("changes", "parameters", "key", "message"),
    [
        (
            {},
            {"smoothing": seconds(1.0, 2.5)},
            "parameters.smoothing[1]",
            "no whole number of intervals",
        ),
        ({}, {"smoothing": seconds(0.5)}, "parameters.smoothing[0]", "e.g. '1 s'"),
        ({}, {"smoothing": seconds(-1.0)}, "parameters.smoothing[0]", "no whole number"),
        ({}, {"smoothing": seconds(2000.0)}, "parameters.smoothing[0]", "fewer than two averages"),
        ({}, {"smoothing": seconds(1.0, 1.0)}, "parameters.smoothing[1]", "twice"),
        ({}, {"smoothing": ()}, "parameters.smoothing", "gives no time"),
        ({}, {"window": seconds(0.0, 3601.0)}, "parameters.window", "no part of the record"),
        ({}, {"window": seconds(10.0, 10.0)}, "parameters.window", "no part of the record"),
        ({}, {"window": seconds(0.0, 20.0)}, "parameters.window", "too few"),
        ({"duration": Quantity(30.0, "s")}, {}, "duration", "30 samples are too few"),
        ({}, {"start": Quantity(2.0, "h")}, "parameters.start", "not within the record"),
    ],
)
def test_a_case_that_cannot_be_is_complained_of(
    changes: dict[str, object], parameters: dict[str, object], key: str, message: str
) -> None:
    found = complaints(static_case(**changes), **parameters)
    assert list(found) == [key]
    assert message in found[key]


def test_the_plan_counts_the_samples() -> None:
    plan = Static().plan(static_case(interval=Quantity(100.0, "ms")), StaticParameters())
    assert (plan.samples, plan.interval_s, plan.warm_up_s) == (36_000, 0.1, 600.0)


def test_names_follow_the_smoothing_as_written_and_the_repeats() -> None:
    parameters = StaticParameters(smoothing=(Quantity(10.0, "s"), Quantity(500.0, "ms")))
    names = [one.name for one in Static().measurands(static_case(), parameters, voltage_output())]
    assert {"bias_stability_10s", "bias_stability_500ms", "bias_run_to_run"} <= set(names)
    once = [
        one.name for one in Static().measurands(static_case(repeats=1), parameters, voltage_output())
    ]
    assert "bias_run_to_run" not in once


def test_the_meters_noise_is_held_against_the_record_in_its_own_unit() -> None:
    quiet = samples_of(2.5 + 1e-5 * np.random.default_rng(1).standard_normal(3600))
    assert Static().reduce(quiet, static_context()).results
    loud = dataclasses.replace(quiet, sampling=meter_sampling(noise=5e-6))
    assert "expected" in refusal(loud)
