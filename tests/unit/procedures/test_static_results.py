"""The static procedure's results: values, budget, dead time, truth recovered."""

import dataclasses
import math
import re

import numpy as np
import pytest

from gyrotest.analysis.earth import EARTH_RATE_DPS
from gyrotest.conformity import judge
from gyrotest.errors import InsufficientDataError
from gyrotest.procedures.static import Static, StaticParameters
from gyrotest.records.result import Result, Verdict
from gyrotest.records.spec import Between, Limit, Output, OutputKind
from gyrotest.units import Quantity, parse_quantity
from tests.unit.analysis.generator import DPH, gyro_noise
from tests.unit.procedures.bench import (
    NOISE,
    by_name,
    meter_sampling,
    rates,
    samples_of,
    static_case,
    static_context,
    voltage_output,
    voltages,
)

EARTH_DPS = EARTH_RATE_DPS * math.sin(math.radians(48.0))


def reduced(rate: np.ndarray, **changes: object) -> dict[str, Result]:
    return by_name(Static().reduce(voltages(rate), static_context(**changes)).results)


def test_every_measurand_of_one_acquisition_has_a_result_in_its_unit() -> None:
    context = static_context()
    found = reduced(rates())
    for measurand in Static().measurands(context.case, context.parameters, context.output):
        if measurand.over is None:
            assert found[measurand.name].unit == measurand.unit
            assert found[measurand.name].label == measurand.label
    assert len(found) == 11


def test_the_bias_is_the_mean_less_the_earths_share() -> None:
    rate = rates()
    bias = reduced(rate)["bias"]
    assert bias.value == pytest.approx(rate.mean() - EARTH_DPS)
    assert "subtracted" in bias.condition


def test_an_unknown_mounting_leaves_the_earths_rate_in_the_uncertainty() -> None:
    rate = rates()
    bias = reduced(rate, case=static_case(mounting=None))["bias"]
    assert bias.value == pytest.approx(rate.mean())
    assert "Earth's rate not subtracted" in bias.condition
    earth = [one for one in bias.budget if "Earth" in one.source]
    assert earth[0].standard_uncertainty * 3600.0 == pytest.approx(15.041 / math.sqrt(3.0))


def test_the_budget_is_complete_and_adds_up() -> None:
    bias = reduced(rates())["bias"]
    by_source = {one.source.split(",")[0]: one.standard_uncertainty for one in bias.budget}
    assert len(bias.budget) == 5
    volts = 2.5 + 0.05 * 0.2
    reading = next(one for one in bias.budget if "of reading" in one.source)
    assert reading.standard_uncertainty == pytest.approx(35e-6 * volts / 0.05 / math.sqrt(3), rel=1e-2)
    assert (reading.half_width, reading.sensitivity) == ("88 µV", "20 (°/s)/V")
    assert by_source["scale factor"] == pytest.approx(0.005 * 0.2 / math.sqrt(3), rel=0.1)
    combined = math.sqrt(sum(one.standard_uncertainty**2 for one in bias.budget))
    assert bias.expanded_uncertainty == pytest.approx((bias.coverage_factor or 0.0) * combined)
    assert (bias.coverage_factor or 0.0) > 2.0
    assert bias.not_included == ()


def test_what_is_not_known_is_not_included() -> None:
    found = reduced(rates(), accuracy=None, output=voltage_output(scale_factor_uncertainty=None))
    assert found["bias"].not_included == ("accuracy of the meter", "uncertainty of the scale factor")
    assert found["allan_minimum"].not_included == found["bias"].not_included
    noisy = samples_of(2.5 + 0.05 * rates(), sampling=meter_sampling(noise=None))
    walk = by_name(Static().reduce(noisy, static_context()).results)["angle_random_walk"]
    assert walk.not_included == ("noise of the meter",)
    unknown = reduced(rates(), since_power_on_s=None)["bias"]
    assert unknown.not_included == ("drift before the record (time of power-on not known)",)


def test_a_small_error_of_pointing_is_in_the_budget() -> None:
    earth = reduced(rates())["bias"].budget[-1]
    half_dph = 15.041 * (math.cos(math.radians(42.0 - 1.0)) - math.cos(math.radians(42.0)))
    assert earth.source == "Earth's share, axis within 1°"
    assert earth.standard_uncertainty * 3600.0 == pytest.approx(half_dph / math.sqrt(3.0), rel=0.02)


def test_coarse_steps_without_noise_are_in_the_budget_and_dithered_ones_are_not() -> None:
    sampling = meter_sampling(unit="deg/s", noise=None)
    for step, source in ((0.05, "resolution, steps of 0.05 °/s"), (0.01, None)):
        values = np.rint(rates() / step) * step
        context = static_context(output=Output(kind=OutputKind.RATE), accuracy=None)
        bias = by_name(Static().reduce(samples_of(values, sampling=sampling), context).results)["bias"]
        found = [one for one in bias.budget if one.source.startswith("resolution")]
        assert [one.source for one in found] == ([source] if source else [])
        if found:
            assert found[0].standard_uncertainty == pytest.approx(0.025 / math.sqrt(3.0))
            assert (found[0].sensitivity, found[0].kind) == ("1", "B")


def test_texts_have_plain_digits() -> None:
    for rate in (rates(), 100.0 * rates() - 20.0):
        reduction = Static().reduce(voltages(rate), static_context())
        texts = [one.condition for one in reduction.results]
        for result in reduction.results:
            texts += [
                text for one in result.budget for text in (one.source, one.half_width, one.sensitivity)
            ]
        for figure in reduction.figures:
            texts += [figure.note, figure.caption, figure.alt, *(panel.note for panel in figure.panels)]
            texts += [mark.label for panel in figure.panels for mark in panel.marks]
        assert not [text for text in texts if re.search(r"[0-9]e[+-]?[0-9]", text)]
    found = reduced(rates())
    assert found["bias_stability_1s"].condition.startswith("3600 averages; ")
    assert found["bias_stability_100s"].condition.endswith("d.o.f.")


def test_identical_repeats_have_no_spread() -> None:
    with pytest.raises(InsufficientDataError, match="same bias to the last digit"):
        Static().reduce_repeats(repeats_of([0.1, 0.1, 0.1]), static_context())


def test_a_low_pass_filter_is_no_bias_stability() -> None:
    """A filter of 20 s makes the curve fall towards short times, below its true floor."""
    rate = gyro_noise(20_000, angle_random_walk=30 * DPH, bias_instability=20 * DPH, seed=3)
    plain, smooth = np.empty_like(rate), 0.0
    for place, one in enumerate(rate):
        smooth += (one - smooth) / 40.0
        plain[place] = smooth
    minimum = reduced(plain + 1e-6 * np.random.default_rng(1).standard_normal(rate.size))[
        "allan_minimum"
    ]
    assert minimum.value is not None
    assert minimum.value > 0.664 * 20.0 * 0.6


def test_a_curve_that_rises_from_its_first_point_on_has_an_upper_bound() -> None:
    rate = gyro_noise(3600, angle_random_walk=0.01 * DPH, rate_random_walk=5 * DPH, seed=2)
    minimum = reduced(rate)["allan_minimum"]
    assert (minimum.at_most, minimum.lower_95) == (True, 0.0)


def test_an_inverted_gyro_has_the_same_figures_and_positive_spreads() -> None:
    rate = rates()
    upright = reduced(rate)
    output = voltage_output(scale_factor=Quantity(-50.0, "mV/(deg/s)"))
    samples = voltages(rate, scale_factor=-0.05)
    inverted = by_name(Static().reduce(samples, static_context(output=output)).results)
    for name, result in upright.items():
        assert inverted[name].value == pytest.approx(result.value, rel=1e-6)
        if result.upper_95 is not None:
            assert inverted[name].upper_95 == pytest.approx(result.upper_95, rel=1e-6)
            assert (inverted[name].value or 0.0) > 0.0


def test_a_rate_output_needs_no_scale_factor_and_may_have_one() -> None:
    rate = rates()
    sampling = meter_sampling(unit="deg/h", noise=None)
    for factor in (None, Quantity(2.0, "")):
        output = Output(kind=OutputKind.RATE, scale_factor=factor)
        samples = samples_of(rate * 3600.0 * (2.0 if factor else 1.0), sampling=sampling)
        found = Static().reduce(samples, static_context(output=output, accuracy=None))
        bias = by_name(found.results)["bias"]
        assert bias.value == pytest.approx(rate.mean() - EARTH_DPS)
        assert bias.not_included == ("uncertainty of the scale factor",)
        (given,) = [one for one in bias.budget if one.kind == "A"]
        assert given.sensitivity == "1"


def test_a_rate_output_has_its_zero_rate_and_its_sources_accuracy_in_degrees_per_second() -> None:
    rate = rates()
    output = Output(
        kind=OutputKind.RATE,
        scale_factor=Quantity(-0.99, ""),
        scale_factor_uncertainty=Quantity(0.5, "%"),
        zero_rate=Quantity(36.0, "deg/min"),
    )
    sampling = meter_sampling(unit="deg/s", noise=None, range=250.0)
    samples = samples_of(0.6 - 0.99 * rate, sampling=sampling)
    context = static_context(output=output)
    bias = by_name(Static().reduce(samples, context).results)["bias"]
    assert bias.value == pytest.approx(rate.mean() - EARTH_DPS)
    assert bias.not_included == ()
    of_range = next(one for one in bias.budget if "of range" in one.source)
    assert of_range.standard_uncertainty == pytest.approx(5e-6 * 250.0 / 0.99 / math.sqrt(3.0))
    assert (of_range.half_width, of_range.sensitivity) == ("4.5 °/h", "1.01")


def test_smoothing_counts_from_its_start_and_the_window_bounds_all() -> None:
    rate = rates()
    parameters = StaticParameters(
        smoothing=(Quantity(10.0, "s"),),
        start=Quantity(20.0, "min"),
        window=(Quantity(10.0, "min"), Quantity(50.0, "min")),
    )
    found = reduced(rate, parameters=parameters)
    assert found["bias"].value == pytest.approx(rate[600:3000].mean() - EARTH_DPS)
    averages = rate[1200:3000].reshape(-1, 10).mean(axis=1)
    assert found["bias_stability_10s"].value == pytest.approx(np.std(averages, ddof=1) * 3600.0)


def test_a_stability_that_the_record_is_too_short_for_is_not_evaluated() -> None:
    found = reduced(rates(samples=100))
    assert found["bias_stability_100s"].value is None
    assert "no two averages of 100 s" in found["bias_stability_100s"].condition
    assert found["bias_stability_10s"].value is not None


def test_the_coefficient_is_the_fits_and_no_share_of_the_minimum() -> None:
    """Where white noise and a walk meet, the curve's minimum over 0.664 is far above the true 8 °/h."""
    rate = gyro_noise(
        36_000,
        angle_random_walk=30 * DPH,
        bias_instability=8 * DPH,
        rate_random_walk=0.3 * DPH,
        seed=11,
    )
    found = reduced(rate, since_power_on_s=0.0)
    minimum, coefficient = found["allan_minimum"], found["bias_instability_coefficient"]
    assert not minimum.at_most
    assert "τ =" in minimum.condition
    assert not coefficient.at_most
    assert "fit over τ = 1 s … " in coefficient.condition
    assert (coefficient.lower_95 or 0.0) < 8.0 < (coefficient.upper_95 or 0.0)
    assert (minimum.value or 0.0) / 0.6643 > 1.08 * (coefficient.value or 0.0)


def test_coefficients_that_the_record_does_not_resolve_are_upper_bounds() -> None:
    found = reduced(gyro_noise(3600, angle_random_walk=30 * DPH, seed=1))
    for name, unit in (
        ("rate_random_walk", "deg/h/sqrt(h)"),
        ("rate_ramp", "deg/h/h"),
        ("quantization_noise", "arcsec"),
        ("bias_instability_coefficient", "deg/h"),
    ):
        one = found[name]
        assert (one.at_most, one.lower_95, one.unit) == (True, 0.0, unit)
        assert one.value == one.upper_95
        assert (one.value or 0.0) > 0.0
        assert one.condition.startswith("not resolved; fit over τ = ")


@pytest.mark.parametrize(
    ("name", "truth", "unit"),
    [("rate_random_walk", 3.0 * 60.0, "deg/h/sqrt(h)"), ("bias_instability_coefficient", 20.0, "deg/h")],
)
def test_a_coefficient_that_shows_is_recovered_in_its_unit(name: str, truth: float, unit: str) -> None:
    rate = gyro_noise(
        20_000,
        angle_random_walk=30 * DPH,
        bias_instability=20 * DPH if name.startswith("bias") else 0.0,
        rate_random_walk=0.0 if name.startswith("bias") else 3.0 * DPH,
        seed=5,
    )
    found = reduced(rate)[name]
    assert not found.at_most
    assert (found.lower_95 or 0.0) < truth < (found.upper_95 or 0.0)
    assert found.value == pytest.approx(truth, rel=0.25)
    assert found.unit == unit


@pytest.mark.parametrize(
    ("name", "high", "low"),
    [
        ("quantization_noise", "1 deg", "1e-3 arcsec"),
        ("rate_random_walk", "1 deg/s/sqrt(s)", "1e-3 °/(h·√h)"),
        ("rate_ramp", "1 deg/s/s", "1e-3 deg/h/h"),
    ],
)
def test_a_bound_passes_above_and_fails_below_in_any_unit(name: str, high: str, low: str) -> None:
    context = static_context()
    result = reduced(gyro_noise(3600, angle_random_walk=30 * DPH, seed=1))[name]
    (measurand,) = [
        one
        for one in Static().measurands(context.case, context.parameters, context.output)
        if one.name == name
    ]
    for text, verdict in ((high, Verdict.PASS), (low, Verdict.FAIL)):
        limit = Limit(max=parse_quantity(text, measurand.dimension))
        judged = judge(measurand, result, limit, case="static", repeat=1)
        assert judged.verdict is verdict


def test_a_floor_that_is_not_reached_is_an_upper_bound() -> None:
    rate = gyro_noise(3600, angle_random_walk=30 * DPH, seed=4)
    found = reduced(rate)["allan_minimum"]
    assert found.at_most
    assert "floor not reached" in found.condition
    assert found.lower_95 == 0.0


def dead_time_samples() -> object:
    fine = gyro_noise(6 * 3600, interval_s=1 / 6, angle_random_walk=30 * DPH, seed=8)
    values = 2.5 + 0.05 * fine.reshape(-1, 6)[:, 0]
    return samples_of(values, sampling=meter_sampling(aperture_s=1 / 6))


def test_dead_time_is_corrected_and_said() -> None:
    found = by_name(Static().reduce(dead_time_samples(), static_context()).results)
    corrected, apparent = found["angle_random_walk"], found["angle_random_walk_apparent"]
    assert apparent.value == pytest.approx(0.5 * math.sqrt(6.0), rel=0.05)
    assert corrected.value == pytest.approx(0.5, rel=0.05)
    assert "dead time corrected, duty 0.167" in corrected.condition
    for name in ("angle_random_walk_apparent", "bias_stability_10s", "allan_minimum"):
        assert "duty 0.167" in found[name].condition


@pytest.mark.parametrize("bandwidth", [None, Quantity(2.0, "Hz")])
def test_dead_time_that_cannot_be_corrected_never_passes(bandwidth: Quantity | None) -> None:
    context = static_context(output=voltage_output(bandwidth=bandwidth))
    found = by_name(Static().reduce(dead_time_samples(), context).results)
    corrected = found["angle_random_walk"]
    assert corrected.value is None
    measurand = next(
        one
        for one in Static().measurands(context.case, context.parameters, context.output)
        if one.name == "angle_random_walk"
    )
    limit = Limit(max=Quantity(1e3, "deg/sqrt(h)"))
    judged = judge(measurand, corrected, limit, case="static", repeat=1)
    assert judged.verdict is Verdict.INCOMPLETE
    assert "bandwidth must exceed 3 Hz" in judged.reason


@pytest.mark.parametrize(
    ("walk_dph", "since_s"), [(0.0, 600.0), (0.0, 4200.0), (0.05, 600.0), (0.1, 7800.0), (0.3, 600.0)]
)
def test_truth_is_recovered_as_the_uncertainties_say(walk_dph: float, since_s: float) -> None:
    """Every unit with its own bias, scale factor, meter errors, warm-up drift and noise."""
    bias_z, walk_z = [], []
    truth = {**NOISE, "rate_random_walk": walk_dph * DPH}
    for seed in range(40):
        random = np.random.default_rng(seed)
        bias = 0.15 * random.standard_normal()
        drift = 0.05 * np.exp(-(since_s + 0.5 + np.arange(3600)) / 240.0)
        noise = gyro_noise(3600, since_power_on_s=since_s, seed=1000 + seed, **truth)
        rate = noise + bias + drift + EARTH_DPS
        scale = 0.05 * (1.0 + random.uniform(-0.005, 0.005))
        volts = 2.5 + scale * rate
        volts += 35e-6 * random.uniform(-1, 1) * 2.5 + 50e-6 * random.uniform(-1, 1)
        context = static_context(since_power_on_s=since_s)
        found = by_name(Static().reduce(samples_of(volts), context).results)
        measured = found["bias"]
        u = (measured.expanded_uncertainty or 0.0) / (measured.coverage_factor or 1.0)
        bias_z.append(((measured.value or 0.0) - bias - drift.mean()) / u)
        walk = found["angle_random_walk"]
        u = ((walk.upper_95 or 0.0) - (walk.lower_95 or 0.0)) / (2 * 1.96)
        walk_z.append(((walk.value or 0.0) - 0.5) / u)
    for z in (bias_z, walk_z):
        assert abs(np.mean(z)) <= 0.55
        assert 0.65 <= np.std(z, ddof=1) <= 1.4


def repeats_of(values: list[float | None]) -> tuple[tuple[Result, ...], ...]:
    return tuple((Result(name="bias", label="Bias", value=value, unit="deg/s"),) for value in values)


def test_the_sources_worked_example_of_bias_repeatability() -> None:
    values = [0.18789, 0.17844, 0.16965, 0.18459, 0.19401]
    context = static_context(case=static_case(repeats=5, between_repeats=Between.POWER_CYCLE))
    (found,) = Static().reduce_repeats(repeats_of(list(values)), context).results
    assert found.name == "bias_repeatability"
    assert (found.value or 0.0) / 3600.0 == pytest.approx(0.00930915, abs=5e-9)


def test_repeats_without_a_power_cycle_are_run_to_run_with_a_wide_interval() -> None:
    (found,) = Static().reduce_repeats(repeats_of([0.1, 0.11, 0.12]), static_context()).results
    assert found.name == "bias_run_to_run"
    assert found.value == pytest.approx(36.0)
    assert found.lower_95 == pytest.approx(0.52 * 36.0, rel=0.01)
    assert found.upper_95 == pytest.approx(6.28 * 36.0, rel=0.01)


@pytest.mark.parametrize("values", [[0.1], [0.1, None, 0.2], [0.1, math.nan]])
def test_a_spread_over_missing_repeats_is_refused(values: list[float | None]) -> None:
    with pytest.raises(InsufficientDataError, match="repeats have a bias"):
        Static().reduce_repeats(repeats_of(values), static_context())


def test_a_later_record_is_less_certain_of_the_turn_on_bias() -> None:
    rate = gyro_noise(3600, angle_random_walk=30 * DPH, rate_random_walk=3 * DPH, seed=3)
    early = reduced(rate, since_power_on_s=0.0)["bias"]
    late = reduced(rate, since_power_on_s=7200.0)["bias"]
    assert (late.expanded_uncertainty or 0.0) > (early.expanded_uncertainty or 0.0)


def test_samples_are_not_changed() -> None:
    samples = voltages(rates())
    before = samples.values.copy()
    samples.values.setflags(write=False)
    Static().reduce(dataclasses.replace(samples), static_context())
    np.testing.assert_array_equal(samples.values, before)
