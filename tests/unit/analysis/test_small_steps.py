"""Small steps: what is followed, by how much noise may decide, and drift that drops out."""

import math

import numpy as np
import pytest

from gyrotest.analysis.small_steps import (
    Followed,
    Level,
    Response,
    contrast,
    smallest_followed,
)
from gyrotest.errors import InsufficientDataError


def response(share: float, u: float = 0.05) -> Response:
    return Response(share=share, standard_uncertainty=u, degrees_of_freedom=math.inf)


def level(up: float, down: float | None = None, u: float = 0.05) -> Level:
    return Level(size_dps=1.0, up=response(up, u), down=response(up if down is None else down, u))


@pytest.mark.parametrize(
    ("share", "followed"),
    [
        (1.0, Followed.YES),
        (0.61, Followed.YES),
        (0.59, Followed.UNDECIDED),
        (0.41, Followed.UNDECIDED),
        (0.39, Followed.NO),
        (-1.0, Followed.NO),
    ],
)
def test_a_response_is_decided_where_its_whole_interval_is_on_one_side(
    share: float, followed: Followed
) -> None:
    assert response(share).followed is followed


def test_a_level_is_followed_only_both_ways() -> None:
    assert level(1.0, 0.0).followed is Followed.NO
    assert level(1.0, 0.5).followed is Followed.UNDECIDED
    assert level(0.5, 0.0).followed is Followed.NO
    assert level(1.0, 1.0).followed is Followed.YES
    assert level(1.0, 0.9).weaker.share == 0.9


@pytest.mark.parametrize(
    ("shares", "place", "not_followed"),
    [
        ([0.0, 0.0, 1.0, 1.0], 2, 1),
        ([0.0, 0.5, 1.0, 1.0], 2, 0),
        ([1.0, 0.0, 1.0, 1.0], 2, 1),
        ([1.0, 1.0, 1.0], 0, None),
        ([0.5, 1.0], 1, None),
        ([1.0, 0.5], None, None),
        ([0.0, 0.0], None, 1),
    ],
)
def test_the_smallest_followed_has_all_above_it_followed(
    shares: list[float], place: int | None, not_followed: int | None
) -> None:
    found = smallest_followed([level(one) for one in shares])
    assert (found.place, found.not_followed) == (place, not_followed)


def test_noise_alone_hardly_ever_makes_a_level_pass() -> None:
    """A level that gives just less than half passes no more than once in forty times."""
    random = np.random.default_rng(2)
    shares = 0.499 + 0.2 * random.standard_normal(4000)
    passed = sum(response(one, 0.2).followed is Followed.YES for one in shares)
    assert passed <= 0.03 * 4000


def test_a_contrast_takes_a_linear_drift_out() -> None:
    weights = contrast(np.array([1, 5]), 7)
    course = np.array([0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0]) + 3.0 + 0.7 * np.arange(7)
    assert weights @ course == pytest.approx(1.0)
    assert weights.sum() == pytest.approx(0.0)


@pytest.mark.parametrize("places", [[], [0], [2]])
def test_a_change_without_a_neighbour_is_refused(places: list[int]) -> None:
    with pytest.raises(InsufficientDataError):
        contrast(np.array(places, dtype=np.int64), 3)


def test_no_level_is_refused() -> None:
    with pytest.raises(InsufficientDataError):
        smallest_followed([])
