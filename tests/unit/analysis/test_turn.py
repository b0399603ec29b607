"""A turn between two rests: found, integrated, and as uncertain as it says."""

import numpy as np
import pytest
from numpy.typing import NDArray

from gyrotest.analysis.turn import Parts, find_rests, turn_integral
from gyrotest.errors import InsufficientDataError

INTERVAL_S = 0.01
ANGLE_DEG = -360.0
SLOPE = 16.4


def turned(
    rng: np.random.Generator,
    *,
    rest: tuple[int, int] = (300, 300),
    turn: int = 600,
    level: float = 5.0,
    drift: float = 0.0,
    sigma: float = 3.0,
) -> NDArray[np.float64]:
    """Counts of a smooth turn between two rests."""
    shape = 1.0 - np.cos(2.0 * np.pi * (np.arange(turn) + 0.5) / turn)
    rate = np.zeros(sum(rest) + turn)
    rate[rest[0] : rest[0] + turn] = shape * ANGLE_DEG / (shape.sum() * INTERVAL_S)
    course = level + drift * np.linspace(-0.5, 0.5, rate.size)
    return SLOPE * rate + course + sigma * rng.normal(size=rate.size)


def integral(values: NDArray[np.float64], parts: Parts, place: NDArray[np.int64] | None = None):
    places = np.arange(values.size) if place is None else place
    return turn_integral(values, places, parts, interval_s=INTERVAL_S)


def test_a_turn_without_noise_has_its_angle():
    values = turned(np.random.default_rng(1), sigma=0.0)
    found = integral(values, Parts(begin=300, end=900))
    assert found.integral == pytest.approx(SLOPE * ANGLE_DEG, rel=1e-12)
    assert found.rest_level == pytest.approx(5.0, rel=1e-12)
    assert found.lasts_s == pytest.approx(6.0)


def test_the_output_at_rest_is_carried_through_the_turn_on_a_straight_line():
    values = turned(np.random.default_rng(1), rest=(300, 900), sigma=0.0, drift=40.0)
    found = integral(values, Parts(begin=300, end=900))
    assert found.integral == pytest.approx(SLOPE * ANGLE_DEG, rel=1e-9)
    assert found.difference == pytest.approx(40.0 * 1200 / 1799, rel=1e-3)
    assert found.drift == pytest.approx(found.difference / 2.0 * 6.0)


@pytest.mark.parametrize("rest", [(300, 300), (0, 500), (500, 0), (300, 2000)])
def test_the_rests_are_found_within_what_is_still(rest):
    values = turned(np.random.default_rng(2), rest=rest)
    parts = find_rests(values)
    assert 0.6 * rest[0] <= parts.begin <= rest[0] + 30
    assert 0.6 * rest[1] <= values.size - parts.end <= rest[1] + 30


@pytest.mark.parametrize("sign", [1.0, -1.0])
@pytest.mark.parametrize("is_told", [True, False])
def test_the_truth_lies_as_far_off_as_the_uncertainty_says(is_told, sign):
    far = []
    for seed in range(150):
        values = sign * turned(np.random.default_rng(seed))
        found = integral(values, Parts(begin=300, end=900) if is_told else find_rests(values))
        uncertainty = np.hypot(found.noise, found.rest)
        far.append((found.integral - sign * SLOPE * ANGLE_DEG) / uncertainty)
        assert found.drift is None or found.drift < 3.0 * uncertainty
    assert abs(np.mean(far)) <= 0.35
    assert 0.75 <= np.std(far) <= 1.3


def test_gaps_in_the_rests_do_not_matter_and_one_in_the_turn_does():
    values = turned(np.random.default_rng(4))
    parts = Parts(begin=300, end=900)
    place = np.arange(values.size)
    apart = np.where(place < 200, place, place + 50)
    assert integral(values, parts, apart).integral == pytest.approx(
        integral(values, parts).integral, abs=2.0
    )
    with pytest.raises(InsufficientDataError, match="7 samples of the turn are missing"):
        integral(values, parts, np.where(place < 500, place, place + 7))


def test_records_that_hold_no_turn_between_rests_are_refused():
    rng = np.random.default_rng(6)
    with pytest.raises(InsufficientDataError, match="nothing turns: the whole record is at rest"):
        find_rests(rng.normal(size=1000))
    with pytest.raises(InsufficientDataError, match="neither end of the record is at rest"):
        find_rests(1000.0 * np.cos(np.linspace(0.0, 20.0, 1000)) + rng.normal(size=1000))
    with pytest.raises(InsufficientDataError, match="63 samples are too few for a turn"):
        find_rests(np.zeros(63))
    with pytest.raises(InsufficientDataError, match="15 samples at rest are too few for a mean"):
        integral(turned(rng), Parts(begin=15, end=900))
    with pytest.raises(InsufficientDataError, match="no rest before the turn"):
        integral(turned(rng), Parts(begin=0, end=1200))
    with pytest.raises(InsufficientDataError, match="no sample is left for the turn"):
        integral(turned(rng), Parts(begin=600, end=600))
