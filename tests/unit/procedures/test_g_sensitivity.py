"""g-sensitivity on a level shaft: coefficients, both mountings, both methods, figures, honest uncertainties."""

import math
from collections.abc import Mapping
from dataclasses import replace

import numpy as np
import pytest

from gyrotest.errors import InsufficientDataError
from gyrotest.procedures.g_sensitivity import GSensitivity, GSensitivityParameters
from gyrotest.records.plan import Pointing, Rotating
from gyrotest.records.recording import Auxiliary
from gyrotest.records.result import Result
from gyrotest.records.spec import Over
from gyrotest.records.station import Encoder
from gyrotest.units import Quantity

from .shaft_bench import (
    EARTH_DPS,
    FRAME_X,
    FRAME_Z,
    GRAVITY_G,
    LATITUDE_DEG,
    MEMS,
    OUTPUT,
    SHAFT,
    Bench,
    Recorded,
    Unit,
)

ZETA = Unit().zeta
FOUR = tuple(Quantity(one, "deg") for one in (0.0, 90.0, 180.0, 270.0))
OBLIQUE = {"x": "-z", "y": "y", "z": "x"}


def named(results: tuple[Result, ...]) -> dict[str, Result]:
    return {one.name: one for one in results}


def value(results: Mapping[str, Result], name: str) -> float:
    found = results[name].value
    assert found is not None
    return found


def standard(one: Result) -> float:
    assert one.expanded_uncertainty is not None
    assert one.coverage_factor is not None
    return one.expanded_uncertainty / one.coverage_factor


@pytest.mark.parametrize("frame", [FRAME_X, FRAME_Z, OBLIQUE])
def test_both_mountings_give_all_three_coefficients_however_the_slot_mounts_the_unit(
    frame: Mapping[str, str],
) -> None:
    found = named(Bench(frame=frame).both())
    for axis, zeta in zip("xyz", ZETA, strict=True):
        assert value(found, f"g_sensitivity_{axis}") == pytest.approx(zeta, abs=1e-5)
    assert value(found, "g_sensitivity_magnitude") == pytest.approx(math.hypot(*ZETA), abs=1e-5)
    assert value(found, "cross_axis_y") == pytest.approx(0.4, abs=1e-3)
    assert value(found, "cross_axis_z") == pytest.approx(-0.7, abs=1e-3)
    assert found["g_sensitivity_x"].condition == "from 2 mountings"
    assert value(found, "agreement") < 100.0


def test_one_mounting_shows_the_axes_across_the_shaft() -> None:
    reduction = Bench().mounting(1)
    found = named(reduction.results)
    assert set(found) == {
        "bias",
        "mounted_g_sensitivity_x",
        "mounted_g_sensitivity_z",
        "mounted_cross_axis",
        "mounted_drift_before",
        "mounted_drift_after",
    }
    assert value(found, "bias") == pytest.approx(0.2, abs=1e-5)
    before = 3600.0 * math.hypot(ZETA[0], ZETA[2]) / math.sqrt(2.0)
    assert value(found, "mounted_drift_before") == pytest.approx(before, rel=0.02)
    assert value(found, "mounted_drift_after") < 0.1
    assert found["bias"].condition.startswith("turned by 0°: y along the shaft")
    assert "averages over 30° (5 s)" in found["mounted_drift_after"].condition


def test_the_second_mounting_shows_the_remaining_coefficient() -> None:
    found = named(Bench().mounting(2).results)
    assert value(found, "mounted_g_sensitivity_y") == pytest.approx(ZETA[1], abs=1e-5)
    assert "mounted_g_sensitivity_z" not in found
    assert "turned by 90°: −z along the shaft" in found["mounted_g_sensitivity_x"].condition


def test_standing_at_positions_gives_the_same() -> None:
    bench = Bench(parameters=GSensitivityParameters(positions=FOUR), rest_s=10.0)
    assert all(isinstance(one.stimulus, Pointing) for one in bench.steps)
    found = named(bench.both())
    for axis, zeta in zip("xyz", ZETA, strict=True):
        assert value(found, f"g_sensitivity_{axis}") == pytest.approx(zeta, abs=1e-5)
    assert "cross_axis_y" not in found


def test_a_turn_goes_there_and_back_between_records_at_rest() -> None:
    steps = Bench().steps
    assert [one.name for one in steps[:3]] == ["rest before", "turn 1 forward", "turn 1 back"]
    assert steps[-1].name == "rest after"
    rates = [one.stimulus.rate_dps for one in steps if isinstance(one.stimulus, Rotating)]
    assert rates == [6.0, -6.0] * 5
    assert steps[1].samples == 1166
    assert steps[0].samples == 600


def test_both_methods_are_compared_and_what_they_have_in_common_cancels() -> None:
    unit = replace(Unit(), noise=MEMS, scale_error=0.004)
    standing = Bench(
        unit=unit, parameters=GSensitivityParameters(positions=FOUR), rest_s=60.0, interval_s=0.2
    ).both()
    turning = Bench(
        unit=replace(unit, seed=2),
        parameters=GSensitivityParameters(compare_with="positions", turns=2),
        interval_s=0.2,
        earlier={"positions": standing},
    )
    reduction = turning.together()
    found = named(reduction.results)
    difference = found["method_difference_z"]
    assert value(found, "method_difference_z") == pytest.approx(
        value(found, "g_sensitivity_z") - value(named(standing), "g_sensitivity_z")
    )
    sources = [one.source for one in difference.budget]
    assert "noise and drift" in sources
    assert "noise and drift (case 'positions')" in sources
    assert "nominal scale factor" not in sources
    assert value(found, "method_agreement") < 150.0
    (figure,) = reduction.figures
    assert figure.table is not None
    assert [one.heading for one in figure.table.columns][-2:] == ["Case positions", "U"]


def test_the_same_coefficient_from_two_mountings_that_differ_does_not_agree() -> None:
    bench = Bench()
    first = bench.mounting(1).results
    second = replace(bench, unit=replace(bench.unit, zeta=(0.04, -0.05, 0.08))).mounting(2).results
    found = named(GSensitivity().reduce_repeats((first, second), bench.context(None)).results)
    assert value(found, "agreement_difference") == pytest.approx(-0.01, abs=1e-5)
    assert value(found, "agreement") > 300.0
    assert value(found, "drift_after") > 3600.0 * 0.005 / math.sqrt(2.0) * 0.9


def test_a_scale_factor_that_was_measured_is_used() -> None:
    measured = Result(
        name="scale_factor",
        label="Scale factor",
        value=50.2,
        unit="mV/(deg/s)",
        expanded_uncertainty=0.02,
        coverage_factor=2.0,
    )
    bench = Bench(
        unit=replace(Unit(), scale_error=0.004),
        parameters=GSensitivityParameters(scale_factor_from="scale_factor"),
        earlier={"scale_factor": (measured,)},
    )
    found = named(bench.both())
    assert value(found, "g_sensitivity_z") == pytest.approx(ZETA[2], abs=1e-5)
    (line,) = [one for one in found["g_sensitivity_z"].budget if "scale factor" in one.source]
    assert line.source == "scale factor from case 'scale_factor'"
    assert line.standard_uncertainty == pytest.approx(2e-4 * ZETA[2], rel=0.05)


def test_an_azimuth_beside_north_counts_with_the_side_on_which_it_matters_more() -> None:
    """cos(−15° + 30°) = cos(−15°): to that side alone nothing would change."""
    beside = replace(SHAFT, azimuth=Quantity(-15.0, "deg"), azimuth_uncertainty=Quantity(30.0, "deg"))
    found = named(Bench(shaft=beside).both())
    (line,) = [one for one in found["g_sensitivity_z"].budget if one.source == "azimuth of the shaft"]
    north_dps = EARTH_DPS * math.cos(math.radians(LATITUDE_DEG))
    change = math.cos(math.radians(15.0)) - math.cos(math.radians(45.0))
    assert line.standard_uncertainty == pytest.approx(
        north_dps * change / GRAVITY_G / math.sqrt(3.0), rel=0.01
    )


def test_an_azimuth_that_is_hardly_known_dominates_the_budget() -> None:
    vague = replace(SHAFT, azimuth_uncertainty=Quantity(30.0, "deg"))
    (line,) = [
        one
        for one in named(Bench(shaft=vague).mounting(1).results)["mounted_g_sensitivity_z"].budget
        if one.source == "azimuth of the shaft"
    ]
    assert line.half_width == "30°"
    assert line.standard_uncertainty * 3600.0 > 2.0


def test_what_could_not_be_had_is_named() -> None:
    bare = Bench(
        encoder=replace(Bench().encoder, accuracy=None),
        output=replace(OUTPUT, scale_factor_uncertainty=None),
    )
    recorded = bare.recorded(1)
    sampling = replace(recorded.samples.sampling, skew_uncertainty_s=None)
    found = named(recorded.of(sampling=sampling).reduced().results)
    assert found["mounted_g_sensitivity_x"].not_included == (
        "uncertainty of the scale factor",
        "accuracy of the encoder",
        "skew of the channels",
    )


def test_a_skew_that_is_stated_is_corrected() -> None:
    bench = Bench()
    recorded = bench.recorded(1)
    late = (recorded.samples.values[:, 1] + 6.0 * 0.5) % 360.0
    # Half a second late in both directions: forward the angle has gone on, back it has gone back.
    back = np.concatenate([np.full(dwell.samples, "back" in dwell.name) for dwell in recorded.dwells])
    rest = np.concatenate([np.full(dwell.samples, "rest" in dwell.name) for dwell in recorded.dwells])
    skewed = np.where(back, (recorded.samples.values[:, 1] - 3.0) % 360.0, late)
    skewed[rest] = recorded.samples.values[rest, 1]
    sampling = replace(recorded.samples.sampling, offsets_s=(0.0, 0.5))
    found = named(recorded.column(1, skewed).of(sampling=sampling).reduced().results)
    assert value(found, "mounted_g_sensitivity_z") == pytest.approx(ZETA[2], abs=1e-5)
    assert value(found, "mounted_drift_after") < 0.1


def grating(bench: Bench, lines: int = 157) -> Recorded:
    """The same turn read by a grating, whose signals have faults of their own."""
    recorded = bench.recorded(1)
    phase = lines * np.radians(recorded.samples.values[:, 1])
    values = np.column_stack(
        (recorded.samples.values[:, 0], 0.02 + 1.1 * np.sin(phase), -0.01 + 0.9 * np.cos(phase + 0.05))
    )
    sampling = replace(
        recorded.samples.sampling,
        auxiliary=(Auxiliary(name="encoder_sine", unit="V"), Auxiliary(name="encoder_cosine", unit="V")),
        offsets_s=(0.0, 0.0, 0.0),
    )
    return recorded.of(values=np.asfortranarray(values), sampling=sampling)


def test_a_grating_is_counted_from_the_end_of_the_run_up() -> None:
    bench = Bench(encoder=Encoder(sine="ua", cosine="ub", lines=157))
    reduction = grating(bench).reduced()
    found = named(reduction.results)
    assert value(found, "mounted_g_sensitivity_z") == pytest.approx(ZETA[2], abs=2e-4)
    assert any("counts from where each turn begins" in one for one in reduction.remarks)


def test_a_grating_with_too_many_lines_is_starved_and_refused() -> None:
    bench = Bench(encoder=Encoder(sine="ua", cosine="ub", lines=307))
    with pytest.raises(InsufficientDataError, match="Hz"):
        grating(bench, 307).reduced()


def test_a_drift_by_the_square_of_gravity_is_remarked() -> None:
    reduction = Bench(unit=replace(Unit(), square=0.01)).mounting(1)
    (remark,) = reduction.remarks
    assert "The residual follows twice the angle by 18 °/h" in remark


def test_outliers_are_dropped_and_counted() -> None:
    recorded = Bench(unit=replace(Unit(), noise=MEMS)).recorded(1)
    spiked = recorded.samples.values[:, 0].copy()
    spiked[[1000, 5000, 9000]] += 0.1
    reduction = recorded.column(0, spiked).reduced()
    assert "Outliers: 3 of 12860 samples dropped." in reduction.remarks
    spiked[::50] += 0.1
    with pytest.raises(InsufficientDataError, match=r"at most 1% may be dropped"):
        recorded.column(0, spiked).reduced()


def test_lost_samples_are_counted() -> None:
    recorded = Bench().recorded(1)
    kept = np.ones(recorded.samples.flags.size, dtype=bool)
    kept[3000:3100] = False
    assert recorded.samples.index is not None
    lost = recorded.of(
        values=recorded.samples.values[kept],
        flags=recorded.samples.flags[kept],
        index=recorded.samples.index[kept],
    )
    reduction = lost.reduced()
    assert reduction.remarks == ("100 of 12860 samples are missing.",)
    assert value(named(reduction.results), "mounted_g_sensitivity_z") == pytest.approx(ZETA[2], abs=1e-5)


def test_figures_show_fit_and_residual_of_both_directions_and_the_drift_before_and_after() -> None:
    over_angle, over_time = Bench(unit=replace(Unit(), noise=MEMS)).mounting(1).figures
    top, bottom = over_angle.panels
    assert [one.label for one in top.points] == ["forward", "back", "at rest"]
    assert [len(one.x) for one in top.points] == [16, 16, 1]
    assert all(len(one.u) == len(one.x) for one in bottom.points)
    inside = [abs(y) <= u for one in bottom.points for y, u in zip(one.y, one.u, strict=True)]
    assert sum(inside) >= 0.8 * len(inside)
    (panel,) = over_time.panels
    assert [one.label for one in panel.curves] == ["before", "after"]


def test_everything_that_is_measured_is_declared() -> None:
    bench = Bench(parameters=GSensitivityParameters(compare_with="turning"))
    bench = replace(bench, earlier={"turning": Bench().both()})
    declared = GSensitivity().measurands(bench.case, bench.parameters, bench.output)
    once = {one.name for one in declared if one.over is None}
    over = {one.name for one in declared if one.over is Over.REPEATS}
    assert {one.name for one in bench.mounting(1).results} <= once
    assert {one.name for one in bench.both()} == over - {"cross_axis_x"}
    labels = {one.name: (one.label, one.unit) for one in declared}
    for one in (*bench.mounting(2).results, *bench.both()):
        assert (one.label, one.unit) == labels[one.name]


def test_units_with_noise_and_errors_of_their_own_are_recovered_honestly() -> None:
    """z = (value − truth)/u over 32 units, each with its own noise, scale, azimuth and index error."""
    z: dict[str, list[float]] = {}
    for seed in range(32):
        drawn = np.random.default_rng(1000 + seed)
        unit = Unit(
            zeta=tuple(drawn.normal(0.0, 0.05, 3)),
            cross_axis=tuple(drawn.normal(0.0, 0.01, 2)),
            scale_error=drawn.uniform(-0.005, 0.005),
            azimuth_error_deg=drawn.uniform(-0.5, 0.5),
            index_error_deg=drawn.uniform(-0.1, 0.1),
            noise=MEMS,
            seed=seed,
        )
        found = named(
            Bench(unit=unit, interval_s=0.25, parameters=GSensitivityParameters(turns=2)).both()
        )
        for axis, zeta in zip("xyz", unit.zeta, strict=True):
            one = found[f"g_sensitivity_{axis}"]
            z.setdefault(axis, []).append((value(found, one.name) - zeta) / standard(one))
    every = np.array([one for several in z.values() for one in several])
    assert abs(every.mean()) < 0.3
    assert 0.8 < every.std(ddof=1) < 1.25
    for several in z.values():
        assert abs(np.mean(several)) < 0.55
        assert 0.65 < np.std(several, ddof=1) < 1.4
