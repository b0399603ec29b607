"""Falling through a level: between points, with what interpolating may err by."""

import numpy as np
import pytest

from gyrotest.analysis.crossing import first_fall


def test_a_smooth_curve_falls_where_it_does_within_the_half_width() -> None:
    x = np.array([5.0, 10.0, 20.0, 40.0, 60.0, 80.0, 100.0])
    ratio = x / 55.0
    y = -0.5 * np.log((1.0 - ratio**2) ** 2 + (1.4 * ratio) ** 2)
    found = first_fall(x, y, level=-0.5 * np.log(2.0))
    fine = np.linspace(x[0], x[-1], 200_001)
    fine_ratio = fine / 55.0
    truth = fine[np.argmax((1.0 - fine_ratio**2) ** 2 + (1.4 * fine_ratio) ** 2 > 2.0)]
    assert found is not None
    assert found.place == 3
    assert abs(found.x - truth) < 3e-3 * truth
    assert abs(found.x - truth) <= found.half_width
    assert found.half_width < 0.01 * truth
    assert found.slope < 0.0


def test_a_straight_line_is_crossed_exactly() -> None:
    found = first_fall(np.arange(5.0), 3.0 - np.arange(5.0), level=0.75)
    assert found is not None
    assert found.x == pytest.approx(2.25, abs=1e-12)
    assert found.half_width < 1e-12
    assert found.slope == pytest.approx(-1.0)


def test_two_points_leave_half_their_distance() -> None:
    found = first_fall(np.array([1.0, 3.0]), np.array([1.0, 0.0]), level=0.5)
    assert found is not None
    assert found.x == pytest.approx(2.0)
    assert found.half_width == 1.0


def test_nothing_is_extrapolated() -> None:
    x = np.arange(4.0)
    assert first_fall(x, 1.0 - 0.1 * x, level=0.5) is None
    assert first_fall(x, 1.0 - 0.1 * x, level=1.5) is None
