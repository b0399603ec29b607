"""Drift by gravity over the angle of a shaft: coefficients, errors of the bench, samples, accelerometers."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from gyrotest.analysis.accelerometer import accelerometer_in_positions, accelerometer_on_shaft
from gyrotest.analysis.drift_spread import spread
from gyrotest.analysis.g_sensitivity import Arcs, ShaftFit, ShaftModel, fit_shaft, second_harmonic
from gyrotest.analysis.level_shaft import Circle, ShaftPose, earth_rate_dps, specific_force_g
from gyrotest.analysis.mounting import own_axes
from gyrotest.analysis.shaft_errors import (
    FittedShaft,
    azimuth_error,
    encoder_errors,
    gain_error,
    index_error,
    placement_error,
    tilt_error,
    timing_error,
)
from gyrotest.analysis.shaft_samples import (
    ShaftSamples,
    averaged,
    missing_sectors,
    near_the_model,
    while_even,
)
from gyrotest.analysis.six_positions import six_positions
from gyrotest.analysis.wandering_fit import Spans
from gyrotest.errors import InsufficientDataError

POSE = ShaftPose(latitude_deg=48.0, azimuth_deg=30.0)
ACROSS_X = np.array([1.0, 0.0, 0.0])
MODEL = ShaftModel(pose=POSE, sensitive=ACROSS_X)
BIAS, ALONG_X, ALONG_Z, CROSS = 0.2, 0.03, -0.05, 0.004
SPAN_S = 4.0
TINY = 1e-6


def arcs(angle_deg: NDArray[np.float64], rate_dps: NDArray[np.float64]) -> Arcs:
    return Arcs(
        spans=Spans(
            begins_s=SPAN_S * np.arange(angle_deg.size), durations_s=np.full(angle_deg.size, SPAN_S)
        ),
        circle=Circle.of(angle_deg),
        rate_dps=rate_dps,
    )


def turned(turns: int = 2) -> Arcs:
    there = 6.0 * SPAN_S * (np.arange(15) + 0.5)
    return arcs(
        np.tile(np.concatenate((there, there[::-1])), turns), np.tile(np.repeat((6.0, -6.0), 15), turns)
    )


def output(where: Arcs, pose: ShaftPose = POSE) -> NDArray[np.float64]:
    force, earth = specific_force_g(pose, where.circle), earth_rate_dps(pose, where.circle)
    values = BIAS + ALONG_X * force[:, 0] + ALONG_Z * force[:, 2] + CROSS * where.rate_dps + earth[:, 0]
    return np.asarray(values + TINY * np.random.default_rng(1).normal(size=values.size))


def fit(where: Arcs | None = None, values: NDArray[np.float64] | None = None) -> ShaftFit:
    where = turned() if where is None else where
    return fit_shaft(output(where) if values is None else values, where, MODEL)


def test_bias_coefficients_and_the_turnings_share_are_found() -> None:
    assert fit().coefficients == pytest.approx([BIAS, ALONG_X, ALONG_Z, CROSS], abs=2e-6)


def test_at_rest_at_four_angles_there_is_no_share_of_the_turning() -> None:
    standing = arcs(np.repeat([0.0, 90.0, 180.0, 270.0], 4), np.zeros(16))
    assert fit(standing).coefficients == pytest.approx([BIAS, ALONG_X, ALONG_Z], abs=3e-6)


def test_the_drift_is_what_goes_with_gravity() -> None:
    found = fit()
    force = specific_force_g(POSE, found.arcs.circle)
    assert found.drift == pytest.approx(ALONG_X * force[:, 0] + ALONG_Z * force[:, 2], abs=2e-5)


def test_angles_that_do_not_tell_the_coefficients_apart_are_refused() -> None:
    two = arcs(np.repeat([0.0, 180.0], 8), np.zeros(16))
    with pytest.raises(InsufficientDataError, match="depend on each other"):
        fit(two)


def test_a_drift_by_the_square_of_gravity_shows_at_twice_the_angle() -> None:
    where = turned()
    square = 1e-4 * where.circle.cosine**2
    seen = second_harmonic(fit(where, output(where) + square))
    assert seen.amplitude == pytest.approx(0.5e-4, rel=0.05)
    assert seen.amplitude > 5.0 * seen.uncertainty
    none = second_harmonic(fit())
    assert none.amplitude < 4.0 * none.uncertainty


# Errors of the bench: what they do by the linear formula is what they do to a fit.


def test_an_azimuth_error_does_what_the_formula_says() -> None:
    true = output(turned(), replace(POSE, azimuth_deg=32.0))
    wrong = fit(values=true).coefficients - fit().coefficients
    assert azimuth_error(FittedShaft.of(fit()), 2.0) == pytest.approx(wrong, abs=1e-7)
    # Ω_E·cosφ·sinA·ΔA: what 2° do at this place, along z.
    expected = -15.041 / 3600.0 * np.cos(np.radians(48.0)) * np.sin(np.radians(30.0)) * np.radians(2.0)
    assert wrong[2] == pytest.approx(expected, rel=0.05)


def test_an_index_error_mixes_the_coefficients() -> None:
    where = turned()
    true = output(replace(where, circle=where.circle.shifted(1.0)))
    wrong = fit(where, true).coefficients - fit(where).coefficients
    assert index_error(FittedShaft.of(fit(where)), 1.0) == pytest.approx(wrong, abs=1e-7)
    assert wrong[1] == pytest.approx(ALONG_Z * np.radians(1.0), rel=0.1)


def test_an_error_of_timing_cancels_between_the_directions() -> None:
    effect = timing_error(FittedShaft.of(fit()), 0.1)
    assert np.abs(effect[1:3]).max() < 0.05 * np.radians(0.6) * abs(ALONG_Z)


def test_an_encoder_error_at_twice_the_angle_reaches_the_coefficients_and_one_at_the_angle_does_not() -> (
    None
):
    once, twice = encoder_errors(FittedShaft.of(fit()), 0.5)
    assert once.shape == twice.shape == (2, 4)
    assert np.linalg.norm(once[:, 2]) < 0.1 * np.linalg.norm(twice[:, 2])
    assert np.linalg.norm(twice[:, 2]) == pytest.approx(
        np.radians(0.5) * np.hypot(ALONG_X, ALONG_Z) / 2.0, rel=0.2
    )


def test_the_uncertainty_of_a_tilt_adds_to_it_to_whichever_side_it_is() -> None:
    """A tilt of the size of its uncertainty must not cancel it."""
    moved = []
    for tilt_deg in (0.1, -0.1):
        model = replace(MODEL, pose=replace(POSE, tilt_deg=tilt_deg))
        moved.append(
            tilt_error(FittedShaft.of(fit_shaft(output(turned()), turned(), model)), 0.1, 0.08)[0]
        )
    assert np.abs(moved) == pytest.approx(0.08 * np.sin(np.radians(0.2)), rel=0.05)


def test_gain_tilt_and_placement_do_what_they_should() -> None:
    fitted = FittedShaft.of(fit())
    assert gain_error(fitted, 0.01)[1] == pytest.approx(0.01 * ALONG_X, rel=0.15)
    assert tilt_error(fitted, 0.1, 0.08)[0] == pytest.approx(0.08 * np.sin(np.radians(0.1)), rel=0.05)
    axes = own_axes({"x": "x", "y": "y", "z": "z"}, "x", 0.0)
    moved = placement_error(fitted, 1.0, axes, np.array([ALONG_X, 0.02, ALONG_Z]), 0)
    assert moved == pytest.approx([0.0, 0.0, 0.02 * np.radians(1.0), 0.0], abs=1e-5)


# Samples


def turn(begin_deg: float = 5.0, end_deg: float = 355.0, rate_dps: float = 6.0) -> ShaftSamples:
    time = np.arange(0.0, abs(end_deg - begin_deg) / rate_dps, 0.1)
    angle = begin_deg + np.sign(end_deg - begin_deg) * rate_dps * time
    return ShaftSamples(
        name="turn",
        output=np.cos(np.radians(angle)),
        angle_deg=angle,
        time_s=time,
        interval_s=0.1,
        forward=end_deg > begin_deg,
    )


def test_run_up_and_reversal_are_left_out_by_the_measured_rate() -> None:
    one = turn()
    ramp = np.clip(one.time_s / 4.0, 0.0, 1.0) * np.clip((one.time_s[-1] - one.time_s) / 4.0, 0.0, 1.0)
    angle = 5.0 + np.cumsum(6.0 * 0.1 * ramp)
    kept = while_even(replace(one, angle_deg=angle))
    assert 3.0 < kept.time_s[0] < 4.6
    assert one.time_s[-1] - 4.6 < kept.time_s[-1] < one.time_s[-1] - 2.8
    assert while_even(one) is one


def test_outliers_are_found_beside_the_model() -> None:
    one = turn()
    noisy = one.output + 1e-3 * np.random.default_rng(1).normal(size=one.output.size)
    noisy[[50, 200]] += 0.1
    (kept,) = near_the_model([replace(one, output=noisy)], mads=7.5)
    assert np.flatnonzero(~kept).tolist() == [50, 200]


def test_averages_are_those_of_the_samples() -> None:
    one = turn()
    found = averaged([one], span_s=5.0)
    assert found.values.size == 12
    assert found.values == pytest.approx(found.arcs.circle.cosine)
    assert found.arcs.rate_dps == pytest.approx(6.0)
    assert found.arcs.spans.durations_s.sum() == pytest.approx(one.time_s.size * 0.1)
    assert found.arcs.spans.begins_s[0] == pytest.approx(one.time_s[0] - 0.05)


def test_sectors_that_are_missing_are_named_for_each_direction() -> None:
    whole, short = turn(), turn(355.0, 130.0)
    assert list(missing_sectors([whole, short], forward=True)) == []
    assert list(missing_sectors([whole, short], forward=False)) == [
        (0.0, 30.0), (30.0, 60.0), (60.0, 90.0), (90.0, 120.0)
    ]  # fmt: skip
    assert len(list(missing_sectors([whole], forward=False))) == 12


def test_the_spread_of_a_course_is_known_better_than_that_of_noise() -> None:
    groups = np.repeat(np.arange(20), 3)
    covariance = 0.01**2 * np.eye(60)
    draws = np.random.default_rng(2).normal(0.0, 0.01, (300, 60))
    noise = np.array([spread(one, groups, covariance).deviation for one in draws])
    first = spread(draws[0], groups, covariance)
    assert first.count == 20
    assert first.degrees_of_freedom == pytest.approx(19.0, rel=0.5)
    assert noise.mean() == pytest.approx(0.01 / np.sqrt(3.0), rel=0.03)
    course = np.sin(2.0 * np.pi * np.arange(60) / 60.0)
    found = np.array([spread(course + one, groups, covariance).deviation for one in draws])
    one = spread(course + draws[0], groups, covariance)
    assert (one.upper_95 - one.lower_95) / 4.0 == pytest.approx(found.std(), rel=0.25)


# Six positions, and accelerometers

UPS = np.array([sign * axis for axis in np.eye(3) for sign in (1.0, -1.0)])


def positions(noise: float = 1e-4) -> NDArray[np.float64]:
    gyro = 0.3 + UPS @ np.array([0.02, -0.05, 0.01])
    accelerometer = 25.0 + UPS @ np.array([3.0, 2000.0, -8.0])
    values = np.column_stack((gyro, accelerometer))
    return np.asarray(values + noise * np.random.default_rng(3).normal(size=values.shape))


def covariances(deviation: float = 1e-4) -> NDArray[np.float64]:
    return np.stack([deviation**2 * np.eye(6)] * 2)


def test_six_positions_give_bias_and_all_three_coefficients() -> None:
    found = six_positions(positions(), UPS, covariances())
    assert found.bias == pytest.approx([0.3, 25.0], abs=5e-4)
    assert found.sensitivity[0] == pytest.approx([0.02, -0.05, 0.01], abs=5e-4)
    assert found.residual_freedom == 2
    expected = 1e-4 / np.sqrt([6.0, 2.0, 2.0, 2.0])
    assert np.sqrt(np.diag(found.covariance[0])) == pytest.approx(
        expected * np.sqrt(max(found.misfit[0], 1.0)), rel=1e-6
    )


def test_positions_that_were_not_quite_those_widen_the_uncertainty() -> None:
    found = six_positions(positions(noise=1e-3), UPS, covariances())
    assert found.misfit.max() > 10.0
    assert np.sqrt(found.covariance[0, 1, 1]) > 2e-4


def test_a_rate_that_is_not_known_is_in_the_uncertainty() -> None:
    earth = 15.041 / 3600.0
    found = six_positions(positions(), UPS, covariances(), unknown_rate=np.array([earth, 0.0]))
    assert np.sqrt(found.covariance[0, 1, 1]) == pytest.approx(earth / np.sqrt(3.0), rel=0.01)
    assert np.sqrt(found.covariance[1, 1, 1]) < 1e-3


def test_positions_on_one_side_are_refused() -> None:
    with pytest.raises(InsufficientDataError, match="3 positions for four coefficients"):
        six_positions(positions()[:3], UPS[:3], covariances()[:, :3, :3])
    with pytest.raises(InsufficientDataError, match="up in one and down in another"):
        six_positions(positions()[:4], UPS[:4], covariances()[:, :4, :4])


def test_positions_show_an_accelerometers_scale_factor_bias_and_lean() -> None:
    found = accelerometer_in_positions(six_positions(positions(), UPS, covariances()), 1, 1)
    assert found.scale_factor == pytest.approx(2000.0, abs=1e-3)
    assert found.bias_g == pytest.approx(25.0 / 2000.0, abs=1e-6)
    assert found.cross_axis == pytest.approx([3.0 / 2000.0, -8.0 / 2000.0], abs=1e-6)


def test_a_turning_shaft_shows_an_accelerometers_scale_factor_and_bias() -> None:
    """S5.6: the same fit, of an output that follows no rotation."""
    where, axis = turned(), np.array([0.0, 0.0, 1.0])
    force = specific_force_g(POSE, where.circle)
    values = 0.8 * (force[:, 2] + 0.02 + 0.005 * -force[:, 0])
    values = values + 1e-5 * np.random.default_rng(4).normal(size=values.size)
    found = accelerometer_on_shaft(fit_shaft(values, where, ShaftModel(pose=POSE, sensitive=None)), axis)
    assert found.scale_factor == pytest.approx(0.8, abs=1e-5)
    assert found.bias_g == pytest.approx(0.02, abs=1e-4)
    assert found.cross_axis == pytest.approx([0.005], abs=1e-4)
    assert found.scale_factor_uncertainty < 1e-5


def test_what_does_not_follow_gravity_is_no_accelerometer() -> None:
    with pytest.raises(InsufficientDataError, match="is it an accelerometer"):
        accelerometer_in_positions(
            six_positions(positions(noise=0.1), UPS, covariances(0.1)), channel=0, sensitive=2
        )
