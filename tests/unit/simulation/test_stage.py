"""A simulated stage with a level shaft: where gravity and the Earth are as it turns, and its own errors."""

import math
from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from gyrotest.analysis.level_shaft import ShaftPose, earth_rate_dps, specific_force_g
from gyrotest.analysis.mounting import own_axes
from gyrotest.records.plan import Placement
from gyrotest.records.station import Shaft, Site
from gyrotest.simulation.carriage import Carriage, carriages, gravity_g
from gyrotest.simulation.stage import ShaftErrors, shaft_errors, stage_axes, stage_carriages
from gyrotest.units import Quantity

SITE = Site(latitude=Quantity(48.0, "deg"), heading=Quantity(20.0, "deg"))
SHAFT = Shaft(azimuth=Quantity(37.0, "deg"), tilt=Quantity(1.5, "deg"))
ANGLES = np.arange(-30.0, 390.0, 15.0)
FRAMES = (
    {"x": "x", "y": "y", "z": "z"},
    {"x": "z", "y": "x", "z": "y"},
    {"x": "-z", "y": "y", "z": "x"},
)
NONE = ShaftErrors()


def sitting(
    frame: dict[str, str],
    placement: Placement | None,
    *,
    errors: ShaftErrors = NONE,
    leans_deg: float = 0.0,
) -> Carriage:
    (found,) = stage_carriages(
        [""],
        stage_axes(SHAFT, errors, SITE),
        frame=frame,
        placement=placement,
        site=SITE,
        misalignment_deg=lambda _: leans_deg,
    )
    return found


def at(found: Carriage, angles: NDArray[np.float64]) -> NDArray[np.float64]:
    """The forces along own x, y, z, and the Earth's rate along the sensitive axis, (n, 4)."""
    assert found.force_g is not None
    forces = [found.force_g[name].mean(angles, angles) for name in "xyz"]
    return np.column_stack([*forces, found.earth_at_dps(angles, angles)])


@pytest.mark.parametrize("frame", FRAMES)
@pytest.mark.parametrize("sensitive", ["x", "y", "z"])
@pytest.mark.parametrize("turned_deg", [0.0, 90.0, -90.0, 33.0])
def test_gravity_and_the_earth_are_where_the_analysis_has_them(
    frame: dict[str, str], sensitive: str, turned_deg: float
) -> None:
    found = sitting(frame, Placement(sensitive_axis=sensitive, turned_deg=turned_deg))
    axes = own_axes(frame, sensitive, turned_deg)
    pose = ShaftPose(latitude_deg=48.0, azimuth_deg=37.0, tilt_deg=1.5)
    own = specific_force_g(pose, ANGLES) @ axes.T
    earth = (earth_rate_dps(pose, ANGLES) @ axes.T)[:, "xyz".index(sensitive)]
    assert at(found, ANGLES)[:, :3] == pytest.approx(own, abs=1e-8)
    assert at(found, ANGLES)[:, 3] == pytest.approx(earth, abs=1e-6)
    assert found.table_share == pytest.approx(axes["xyz".index(sensitive), 1], abs=1e-12)


def test_an_index_error_has_turned_the_stage_at_the_angle_0_and_an_azimuth_error_all_of_it() -> None:
    placement = Placement(sensitive_axis="x", turned_deg=0.0)
    ahead = sitting(FRAMES[0], placement, errors=ShaftErrors(index_deg=2.0))
    straight = sitting(FRAMES[0], placement)
    assert at(ahead, ANGLES) == pytest.approx(at(straight, ANGLES + 2.0), abs=1e-12)
    aside = sitting(FRAMES[0], placement, errors=ShaftErrors(azimuth_deg=3.0, tilt_deg=0.1))
    pose = ShaftPose(latitude_deg=48.0, azimuth_deg=40.0, tilt_deg=1.6)
    assert at(aside, ANGLES)[:, 3] == pytest.approx(earth_rate_dps(pose, ANGLES)[:, 0], abs=1e-6)


def test_a_leaning_axis_feels_the_turning_and_loses_nothing_else() -> None:
    placement = Placement(sensitive_axis="z", turned_deg=90.0)
    straight, leaning = (sitting(FRAMES[0], placement, leans_deg=one) for one in (0.0, 2.0))
    assert straight.table_share == pytest.approx(0.0, abs=1e-12)
    assert leaning.table_share == pytest.approx(math.sin(math.radians(2.0)))
    assert at(leaning, ANGLES)[:, :3] == pytest.approx(at(straight, ANGLES)[:, :3])
    along = sitting(FRAMES[1], placement, leans_deg=2.0)
    assert along.table_share == pytest.approx(1.0)


def test_what_acts_is_averaged_while_the_stage_turns() -> None:
    found = sitting(FRAMES[0], Placement(sensitive_axis="x", turned_deg=0.0))
    assert found.force_g is not None
    fine = np.linspace(10.0, 100.0, 20_001)
    mean = float(np.mean(found.force_g["x"].mean(fine[:-1], fine[1:])))
    assert found.force_g["x"].mean(np.array([10.0]), np.array([100.0])) == pytest.approx(
        [mean], abs=1e-8
    )


def test_away_from_a_stage_gravity_acts_along_the_axis_itself_where_its_mounting_is_known() -> None:
    (down,) = carriages([""], {"": (-1.0, 0.0, 0.0)}, table_axis=(1.0, 0.0, 0.0), site=SITE)
    drift = {"x": 0.01, "y": 0.1, "z": 1.0}
    assert down.felt_dps(drift).at_rest == pytest.approx(-0.01 * gravity_g(SITE))
    (unknown,) = carriages([""], {}, table_axis=(1.0, 0.0, 0.0), site=SITE)
    assert unknown.felt_dps(drift).at_rest == 0.0
    three = carriages("xyz", {"z": (1.0, 0.0, 0.0)}, table_axis=(1.0, 0.0, 0.0), site=None)
    assert [one.felt_dps(drift).at_rest for one in three] == [0.0, 0.0, 1.0]


def test_the_shafts_errors_fill_the_half_widths_and_stay_for_a_unit() -> None:
    shaft = replace(SHAFT, azimuth_uncertainty=Quantity(2.0, "deg"))
    drawn = [shaft_errors(shaft, seed=1, serial_number=str(unit), stage="stage") for unit in range(200)]
    assert 1.8 < max(abs(one.azimuth_deg) for one in drawn) <= 2.0
    assert 0.045 < max(abs(one.tilt_deg) for one in drawn) <= 0.05
    assert 0.09 < max(abs(one.index_deg) for one in drawn) <= 0.1
    assert drawn[7] == shaft_errors(shaft, seed=1, serial_number="7", stage="stage")
