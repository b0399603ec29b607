"""Gaps, jitter and stamps that do not go forward are found, counted and placed."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from gyrotest.errors import InsufficientDataError
from gyrotest.recordings.regroup import Averages, Placed, consecutive
from gyrotest.recordings.stamps import Grid, described, survey


def test_a_gap_is_counted_with_the_samples_that_it_lacks():
    times = np.concatenate([np.arange(100) * 0.01, 5.0 + np.arange(100) * 0.01])
    found = survey([times])
    assert found.interval_s == pytest.approx(0.01)
    assert (found.gaps, found.missing) == (1, 400)
    assert found.longest_gap_s == pytest.approx(4.01)
    assert found.longest_after_s == pytest.approx(0.99)
    accepted, places = Grid(found).places(times)
    assert accepted.all()
    assert places.tolist() == [*range(100), *range(500, 600)]


def test_coarse_stamps_open_no_gaps_however_long_the_file():
    # 102.4 Hz, stamped in whole milliseconds: the median interval is 10 ms, the true one 9.765625.
    times = np.round(np.arange(200_000) / 102.4, 3)
    found = survey([times])
    assert found.interval_s == pytest.approx(1 / 102.4, rel=1e-6)
    assert found.gaps == 0
    assert found.jitter_max_s == pytest.approx(0.0005, rel=0.6)
    assert Grid(found).places(times)[1].tolist() == list(range(200_000))


def test_stamps_that_repeat_go_back_or_lack_have_no_place():
    times = np.array([0.0, 1.0, 1.0, 2.0, 0.5, 3.0, np.nan, 4.0])
    found = survey([times])
    assert (found.repeated, found.backward, found.absent, found.without_place) == (1, 1, 1, 3)
    accepted, places = Grid(found).places(times)
    assert accepted.tolist() == [True, True, False, True, False, True, False, True]
    assert places.tolist() == [0, 1, 2, 3, 4]
    assert "1 repeated, 1 gone back, 1 missing" in " ".join(described(found))


@given(
    steps=st.lists(st.sampled_from([1, 1, 1, 1, 2, 7]), min_size=4, max_size=60),
    cuts=st.lists(st.integers(0, 60), max_size=5),
)
def test_the_way_a_file_is_cut_into_parts_changes_nothing(steps, cuts):
    times = np.cumsum(np.array([1, 1, 1, *steps])) * 0.125
    parts = np.split(times, sorted(min(cut, times.size) for cut in cuts))
    assert survey(parts) == survey([times])
    grid = Grid(survey([times]))
    places = np.concatenate([grid.places(part)[1] for part in parts])
    assert (
        places.tolist() == np.rint((times - times[0]) / 0.125).astype(int).tolist()
        or np.median(steps) > 1
    )


def test_a_single_stamp_has_no_interval():
    with pytest.raises(InsufficientDataError, match="1 time stamps"):
        survey([np.array([1.0])])


def placed(places: list[int]) -> Placed:
    index = np.array(places, dtype=np.int64)
    return Placed(
        place=index,
        time_s=index * 0.1,
        values=np.stack([index, -2.0 * index], axis=1),
        flags=(index == 4).astype(np.uint8),
    )


@given(cut=st.integers(0, 12))
def test_means_are_of_whole_groups_only(cut):
    places = [0, 1, 2, 3, 4, 5, 7, 8, 9, 10, 11, 12]
    averages = Averages(3)
    parts = list(averages.of([placed(places[:cut]), placed(places[cut:])]))
    assert np.concatenate([part.place for part in parts]).tolist() == [0, 1, 3]
    means = np.concatenate([part.values for part in parts])
    assert means.tolist() == [[1.0, -2.0], [4.0, -8.0], [10.0, -20.0]]
    assert np.concatenate([part.flags for part in parts]).tolist() == [0, 1, 0]
    assert averages.incomplete == 1


def test_stretches_are_cut_where_a_place_is_missing():
    assert [run.place.tolist() for run in consecutive(placed([0, 1, 4, 6, 7]))] == [[0, 1], [4], [6, 7]]
    assert list(consecutive(placed([]))) == []
