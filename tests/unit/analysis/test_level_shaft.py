"""A level shaft: gravity and the Earth's rate along what turns with it, and how a unit lies there."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from gyrotest.analysis.gravity import STANDARD_GRAVITY, normal_gravity_g
from gyrotest.analysis.level_shaft import Circle, ShaftPose, earth_rate_dps, specific_force_g
from gyrotest.analysis.mounting import AXES, frame_complaints, own_axes, undetermined_axes
from gyrotest.errors import InsufficientDataError

POSE = ShaftPose(latitude_deg=40.0, azimuth_deg=25.0)
ANGLES = np.linspace(0.0, 360.0, 25)
FRAME = {"x": "x", "y": "y", "z": "z"}
SIGNED = [f"{sign}{axis}" for axis in AXES for sign in ("", "-")]


@pytest.mark.parametrize(
    ("latitude_deg", "gravity"),
    [(0.0, 9.7803253), (45.0, 9.8061978), (-45.0, 9.8061978), (90.0, 9.8321849)],
)
def test_normal_gravity_is_that_of_the_ellipsoid(latitude_deg: float, gravity: float) -> None:
    """WGS 84: gravity at the equator, at 45° and at the poles, m/s²."""
    assert normal_gravity_g(latitude_deg) * STANDARD_GRAVITY == pytest.approx(gravity, abs=1e-7)


def test_gravity_turns_through_x_and_z() -> None:
    force = specific_force_g(POSE, ANGLES) / normal_gravity_g(40.0)
    angle = np.radians(ANGLES)
    assert force[:, 0] == pytest.approx(-np.sin(angle), abs=1e-12)
    assert force[:, 1] == pytest.approx(0.0, abs=1e-12)
    assert force[:, 2] == pytest.approx(np.cos(angle), abs=1e-12)


def test_a_tilted_shaft_feels_gravity_along_itself() -> None:
    tilted = ShaftPose(latitude_deg=40.0, azimuth_deg=25.0, tilt_deg=2.0)
    force = specific_force_g(tilted, ANGLES)
    assert force[:, 1] == pytest.approx(normal_gravity_g(40.0) * math.sin(math.radians(2.0)))
    assert np.linalg.norm(force, axis=1) == pytest.approx(normal_gravity_g(40.0))


def test_the_earths_rate_is_that_of_the_equations() -> None:
    rate = earth_rate_dps(POSE, ANGLES) * 3600.0 / 15.041
    angle, latitude, azimuth = np.radians(ANGLES), math.radians(40.0), math.radians(25.0)
    level = math.cos(latitude) * math.cos(azimuth)
    assert rate[:, 0] == pytest.approx(level * np.cos(angle) - math.sin(latitude) * np.sin(angle))
    assert rate[:, 2] == pytest.approx(level * np.sin(angle) + math.sin(latitude) * np.cos(angle))
    assert rate[:, 1] == pytest.approx(math.cos(latitude) * math.sin(azimuth))


@given(st.floats(-90.0, 90.0), st.floats(0.0, 360.0), st.floats(-5.0, 5.0), st.floats(-720.0, 720.0))
def test_no_pose_changes_the_size_of_the_earths_rate(
    latitude: float, azimuth: float, tilt: float, angle: float
) -> None:
    pose = ShaftPose(latitude_deg=latitude, azimuth_deg=azimuth, tilt_deg=tilt)
    rate = earth_rate_dps(pose, np.array([angle]))
    assert np.linalg.norm(rate) * 3600.0 == pytest.approx(15.041)


def test_left_in_the_earths_rate_looks_like_a_false_drift_of_9_7_degrees_an_hour_a_g() -> None:
    """S5.4 at 40° latitude: what goes with −sinθ and cosθ."""
    pose = ShaftPose(latitude_deg=40.0, azimuth_deg=90.0)
    force, rate = (one(pose, ANGLES) for one in (specific_force_g, earth_rate_dps))
    slope = np.linalg.lstsq(force[:, [0, 2]], rate[:, 0], rcond=None)[0]
    assert slope[0] * 3600.0 == pytest.approx(9.7, abs=0.05)


def test_a_circle_is_shifted_like_its_angles() -> None:
    shifted = Circle.of(ANGLES).shifted(12.5)
    assert shifted.cosine == pytest.approx(Circle.of(ANGLES + 12.5).cosine)
    assert shifted.sine == pytest.approx(Circle.of(ANGLES + 12.5).sine)


@given(st.sampled_from(SIGNED), st.sampled_from(SIGNED), st.sampled_from(AXES), st.floats(-360.0, 360.0))
def test_own_axes_are_right_handed_and_perpendicular(x: str, y: str, about: str, turned: float) -> None:
    if x.removeprefix("-") == y.removeprefix("-"):
        return
    third = ({*AXES} - {x.removeprefix("-"), y.removeprefix("-")}).pop()
    frames = [{"x": x, "y": y, "z": z} for z in (third, f"-{third}")]
    good = [one for one in frames if not list(frame_complaints(one))]
    assert len(good) == 1
    axes = own_axes(good[0], about, turned)
    assert axes @ axes.T == pytest.approx(np.eye(3), abs=1e-12)
    assert np.linalg.det(axes) == pytest.approx(1.0)
    place = AXES.index(about)
    assert axes[place] == pytest.approx(own_axes(good[0], about, 0.0)[place])


def test_a_quarter_about_x_brings_y_to_where_z_was_and_z_against_y() -> None:
    before, after = own_axes(FRAME, "x", 0.0), own_axes(FRAME, "x", 90.0)
    assert np.array_equal(after[1], before[2])
    assert np.array_equal(after[2], -before[1])


@pytest.mark.parametrize(
    ("frame", "message"),
    [
        ({"x": "x", "y": "z", "z": "y"}, "left-handed"),
        ({"x": "x", "y": "x", "z": "z"}, "two axes lie along one"),
        ({"x": "x", "y": "up", "z": "z"}, "'up' is no axis"),
        ({"x": "x"}, "found x"),
    ],
)
def test_what_is_no_frame_is_said(frame: dict[str, str], message: str) -> None:
    (found,) = frame_complaints(frame)
    assert message in found
    with pytest.raises(InsufficientDataError, match=r"write e\.g\."):
        own_axes(frame, "x", 0.0)


def test_the_axis_along_the_shaft_of_every_mounting_stays_unknown() -> None:
    def mountings(*turned: float) -> tuple[str, ...]:
        return undetermined_axes([own_axes(FRAME, "x", one) for one in turned])

    assert mountings(0.0) == ("y",)
    assert mountings(0.0, 180.0) == ("y",)
    assert mountings(90.0) == ("z",)
    assert mountings(0.0, 90.0) == ()
    assert mountings(45.0) == ("y", "z")
    assert undetermined_axes([]) == AXES
