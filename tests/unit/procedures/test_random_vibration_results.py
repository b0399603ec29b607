"""Frequency response by random vibration: what comes out of a table and a gyro of known response."""

import csv
import dataclasses
import io
import math

import numpy as np
import pytest

from gyrotest.procedures.random_vibration import RandomVibration
from gyrotest.procedures.random_vibration.least_coherence import least_coherence
from gyrotest.records.plan import Reduction
from gyrotest.records.result import Result
from gyrotest.records.station import Encoder
from gyrotest.units import Quantity
from tests.unit.procedures.random_vibration_bench import (
    FREQUENCIES_HZ,
    QUIET,
    case,
    context,
    parameters,
    reduced,
    runs,
)
from tests.unit.procedures.vibration_bench import (
    ENCODER,
    SKEWS_S,
    Gyro,
    daq_sampling,
    streamed,
    vibration_output,
)

SLOW = dataclasses.replace(QUIET, natural_hz=75.0, damping=0.65)


@pytest.fixture(scope="module")
def nominal() -> Reduction:
    return reduced(runs())


@pytest.fixture(scope="module")
def slow() -> Reduction:
    return reduced(runs(SLOW), context(parameters(degree=8)))


def named(reduction: Reduction, name: str) -> Result:
    (found,) = (one for one in reduction.results if one.name == name)
    return found


def value_of(one: Result) -> float:
    assert one.value is not None, one.condition
    return one.value


def uncertainty_of(one: Result) -> float:
    assert one.expanded_uncertainty is not None
    return one.expanded_uncertainty


def crossing_hz(gyro: Gyro, level: float) -> float:
    """Where the gain falls to a level of that at 20 Hz."""
    frequency_hz = np.linspace(20.0, 200.0, 18_001)
    gain = np.array([abs(gyro.response(one)) for one in frequency_hz])
    return float(frequency_hz[np.flatnonzero(gain <= level * gain[0])[0]])


@pytest.mark.parametrize("frequency_hz", FREQUENCIES_HZ)
def test_sensitivity_and_phase_are_the_true_ones_within_their_uncertainty(
    nominal: Reduction, frequency_hz: float
) -> None:
    true = QUIET.response(frequency_hz)
    gain = named(nominal, f"sensitivity_{frequency_hz:g}Hz")
    phase = named(nominal, f"phase_{frequency_hz:g}Hz")
    assert (gain.unit, phase.unit) == ("mV/(deg/s)", "deg")
    assert value_of(gain) == pytest.approx(1e3 * abs(true), abs=1.3 * uncertainty_of(gain))
    assert value_of(phase) == pytest.approx(
        math.degrees(np.angle(true)), abs=1.3 * uncertainty_of(phase)
    )
    assert uncertainty_of(gain) < 1e-3 * value_of(gain)
    assert uncertainty_of(phase) < 0.1


def test_budgets_name_what_is_uncertain(nominal: Reduction) -> None:
    gain, phase = named(nominal, "sensitivity_40Hz"), named(nominal, "phase_40Hz")
    sources = [one.source for one in gain.budget]
    assert sources[0] == "random error, by the curve"
    assert sources[-2:] == ["source, 0.01 % of reading", "encoder, 5 arcsec, up to twice a turn"]
    skew = phase.budget[-1]
    assert (skew.source, skew.half_width) == ("skew of the channels", "1 µs")
    assert skew.standard_uncertainty == pytest.approx(360.0 * 40.0 * 1e-6 / math.sqrt(3.0))
    assert (gain.not_included, phase.not_included) == ((), ())


def test_what_the_station_does_not_state_is_not_included() -> None:
    sampling = daq_sampling(skew_uncertainty_s=None)
    bare = context(accuracy=None, encoder=Encoder(sine="ua", cosine="ub", lines=9000))
    found = reduced(streamed(runs(), sampling=sampling), bare)
    assert named(found, "sensitivity_40Hz").not_included == (
        "accuracy of the source",
        "accuracy of the encoder",
    )
    assert named(found, "phase_40Hz").not_included == ("skew of the channels",)


def test_skew_that_is_stated_is_corrected_and_skew_that_is_not_turns_the_phase(
    nominal: Reduction,
) -> None:
    ignored = daq_sampling(offsets_s=(0.0, 0.0, 0.0))
    wrong = named(reduced(streamed(runs(), sampling=ignored)), "phase_80Hz")
    right = named(nominal, "phase_80Hz")
    lag = -360.0 * 80.0 * (SKEWS_S[1] + SKEWS_S[2]) / 2.0
    assert value_of(wrong) - value_of(right) == pytest.approx(lag, abs=0.02)


def test_a_response_that_does_not_fall_by_3_db_has_a_bandwidth_of_at_least_the_band(
    nominal: Reduction,
) -> None:
    found = named(nominal, "bandwidth_3db")
    assert (found.value, found.at_least, found.lower_95) == (100.0, True, 100.0)
    assert "not reached within the band" in found.condition


def test_bandwidth_and_quarter_turn_within_the_band_are_the_true_ones(slow: Reduction) -> None:
    bandwidth, quarter = named(slow, "bandwidth_3db"), named(slow, "phase_90_frequency")
    assert not bandwidth.at_least
    true = crossing_hz(SLOW, math.sqrt(0.5))
    assert value_of(bandwidth) == pytest.approx(true, abs=1.5 * uncertainty_of(bandwidth))
    phase = math.degrees(np.angle(SLOW.response(value_of(quarter))))
    assert phase == pytest.approx(-90.0, abs=0.05)
    assert uncertainty_of(bandwidth) < 0.2


def test_the_bode_plot_marks_where_the_gain_and_the_phase_have_fallen(slow: Reduction) -> None:
    bode = next(one for one in slow.figures if one.name == "bode")
    (three_db,), (quarter,) = (panel.marks for panel in bode.panels)
    assert three_db.label.startswith("\N{MINUS SIGN}3 dB: 8")
    assert quarter.label.startswith("\N{MINUS SIGN}90°: 6")


def test_flatness_is_told_up_to_a_frequency(nominal: Reduction) -> None:
    gains = [abs(QUIET.response(one)) for one in np.linspace(20.0, 50.0, 301)]
    true = 100.0 * (max(gains) - min(gains)) / gains[0]
    found = named(nominal, "flatness")
    assert value_of(found) == pytest.approx(true, abs=1.5 * uncertainty_of(found))
    assert found.condition == "highest less lowest, 20 … 50 Hz, of that at 20 Hz"


def test_group_delay_is_that_of_the_response(nominal: Reduction) -> None:
    step_hz = 0.01
    angles = [float(np.angle(QUIET.response(20.0 + sign * step_hz))) for sign in (-1.0, 1.0)]
    true_ms = 1e3 * (angles[0] - angles[1]) / (4.0 * math.pi * step_hz)
    found = named(nominal, "group_delay")
    assert (value_of(found), found.unit) == (
        pytest.approx(true_ms, abs=1.5 * uncertainty_of(found)),
        "ms",
    )


def test_runs_that_differ_by_noise_alone_repeat_within_it(nominal: Reduction) -> None:
    for name in ("amplitude_repeatability", "phase_repeatability"):
        found = named(nominal, name)
        assert found.lower_95 == 0.0
        assert 0.0 < value_of(found) < 0.8
        assert found.condition.startswith("3σ of 3 runs, largest at ")


def test_runs_that_differ_more_than_by_noise_make_the_result_less_certain() -> None:
    values = np.array(runs())
    length = values.shape[0] // 4
    for number, share in enumerate((0.97, 1.0, 1.03), start=1):
        one = slice(number * length, (number + 1) * length)
        values[one, 0] = 2.5 + share * (values[one, 0] - 2.5)
    found = reduced(values)
    spread, gain = named(found, "amplitude_repeatability"), named(found, "sensitivity_40Hz")
    assert value_of(spread) == pytest.approx(9.0, abs=0.6)
    (by_runs,) = (one for one in gain.budget if one.source == "spread of the runs")
    assert by_runs.standard_uncertainty == pytest.approx(value_of(gain) * 0.03 / math.sqrt(3.0), rel=0.1)
    assert by_runs.degrees_of_freedom == 2


def test_runs_of_different_bandwidths_make_what_is_read_off_the_band_less_certain() -> None:
    """A unit whose bandwidth changes from run to run: the curve through all runs is no more certain than that."""
    gyros = [dataclasses.replace(SLOW, natural_hz=one) for one in (70.0, 75.0, 80.0)]
    parts = [np.split(runs(one), 4) for one in gyros]
    values = np.concatenate((parts[0][0], *(part[number] for number, part in enumerate(parts, start=1))))
    found = reduced(values, context(parameters(degree=8)))
    true_hz = [crossing_hz(one, math.sqrt(0.5)) for one in gyros]
    by_runs = {
        one.name: line
        for one in found.results
        for line in one.budget
        if line.source == "spread of the runs"
    }
    assert by_runs["bandwidth_3db"].standard_uncertainty == pytest.approx(
        np.std(true_hz, ddof=1) / math.sqrt(3.0), rel=0.1
    )
    assert by_runs["bandwidth_3db"].degrees_of_freedom == 2
    assert {"flatness", "phase_90_frequency", "group_delay"} <= set(by_runs)


def test_a_single_run_has_no_repeatability() -> None:
    length = runs().shape[0] // 4
    found = reduced(runs()[: 2 * length], context(parameters(runs=1)))
    repeatability = named(found, "amplitude_repeatability")
    assert repeatability.value is None
    assert "a single run has no spread" in repeatability.condition
    assert "repeatability" not in [one.name for one in found.figures]


@pytest.mark.parametrize("reversed_encoder", [False, True])
def test_an_inverted_gyro_has_a_negative_sensitivity_and_its_own_phase(
    nominal: Reduction,
    reversed_encoder: bool,
) -> None:
    """Whether its nominal scale factor says so, or the encoder counts against it."""
    if reversed_encoder:
        given = context(encoder=dataclasses.replace(ENCODER, reversed=True))
    else:
        given = context(output=vibration_output(scale_factor=Quantity(-50.0, "mV/(deg/s)")))
    found = reduced(runs(), given)
    sign = -1.0 if reversed_encoder else 1.0
    gain, phase = named(found, "sensitivity_40Hz"), named(found, "phase_40Hz")
    assert value_of(gain) == pytest.approx(sign * value_of(named(nominal, "sensitivity_40Hz")))
    assert value_of(phase) == pytest.approx(value_of(named(nominal, "phase_40Hz")))
    assert any("moves against the sign" in text for text in found.remarks)


def test_a_gyro_whose_negative_scale_factor_is_stated_is_not_remarked_on() -> None:
    wired = dataclasses.replace(QUIET, scale=-0.05)
    negative = vibration_output(scale_factor=Quantity(-50.0, "mV/(deg/s)"))
    found = reduced(runs(wired), context(output=negative))
    assert value_of(named(found, "sensitivity_40Hz")) == pytest.approx(
        -1e3 * abs(QUIET.response(40.0)), rel=1e-3
    )
    assert not any("sign" in text for text in found.remarks)


def test_missing_samples_are_told_and_no_segment_bridges_them() -> None:
    from gyrotest.records.recording import Gap
    from gyrotest.records.spec import Gaps

    lost = tuple(range(150_000, 150_050))
    gaps = (Gap(after=lost[0] - 1, missing=len(lost), reason="lost"),)
    given = context(gaps=gaps, case=case(gaps=Gaps.LONGEST_STRETCH))
    found = reduced(streamed(runs(), lost=lost), given)
    gain = named(found, "sensitivity_40Hz")
    assert value_of(gain) == pytest.approx(
        1e3 * abs(QUIET.response(40.0)), abs=1.5 * uncertainty_of(gain)
    )
    assert "50 samples are missing; no segment of the spectra bridges them." in found.remarks


def test_a_polynomial_that_is_too_stiff_says_so_and_is_less_certain() -> None:
    stiff = reduced(runs(SLOW), context(parameters(degree=2)))
    gain = named(stiff, "sensitivity_40Hz")
    assert any("degree 2 does not follow the sensitivity" in text for text in stiff.remarks)
    assert any(one.source == "lack of fit of the curve" for one in gain.budget)
    assert abs(value_of(gain) - 1e3 * abs(SLOW.response(40.0))) < uncertainty_of(gain)


def test_the_export_has_a_line_for_each_frequency(nominal: Reduction) -> None:
    (export,) = nominal.exports
    rows = list(csv.DictReader(io.StringIO(export.text)))
    assert export.name == "response.csv"
    assert [float(one["frequency_hz"]) for one in rows[:3]] == [20.0, 21.0, 22.0]
    assert len(rows) == 81
    at_40 = next(one for one in rows if float(one["frequency_hz"]) == 40.0)
    gain = value_of(named(nominal, "sensitivity_40Hz"))
    assert float(at_40["fitted_sensitivity [mV/(deg/s)]"]) == pytest.approx(gain)
    assert float(at_40["run_2_sensitivity [mV/(deg/s)]"]) == pytest.approx(gain, rel=0.005)
    assert (at_40["left_out"], float(at_40["coherence"]) > 0.999) == ("0", True)


def test_figures_come_in_the_order_of_the_certificate(nominal: Reduction) -> None:
    assert [one.name for one in nominal.figures] == ["bode", "coherence", "repeatability", "runs"]
    table = nominal.figures[0].table
    assert table is not None
    assert [row[0].text for row in table.rows] == ["22.5 Hz", "40 Hz", "80 Hz"]


def test_no_figure_has_more_than_a_few_hundred_points_a_curve(nominal: Reduction) -> None:
    curves = [c for one in nominal.figures for panel in one.panels for c in panel.curves]
    assert max(len(one.x) for one in curves) <= 250


def test_nothing_is_computed_over_repeats() -> None:
    assert RandomVibration().reduce_repeats((), context()).results == ()


def test_the_least_coherence_has_an_interval_that_allows_for_its_being_the_least(
    nominal: Reduction,
) -> None:
    found = named(nominal, "coherence_minimum")
    assert found.lower_95 is not None
    assert found.upper_95 is not None
    assert found.unit == "%"
    assert 99.0 < found.lower_95 < value_of(found) < found.upper_95 < 100.0


def test_the_interval_of_the_least_coherence_covers_the_true_one() -> None:
    rng = np.random.default_rng(11)
    averages, covered, trials = 60, 0, 300
    for _ in range(trials):
        x, noise = (rng.normal(size=(40, averages, 2)) @ [1.0, 1j] for _ in range(2))
        y = x + noise * math.sqrt(1.0 / 0.9 - 1.0)
        cross = np.abs((y * x.conj()).mean(axis=1)) ** 2
        power = (np.abs(x) ** 2).mean(axis=1) * (np.abs(y) ** 2).mean(axis=1)
        found = least_coherence(cross / power, averages=averages)
        covered += found.lower_95 <= 0.9 <= found.upper_95
    assert covered / trials >= 0.93
