"""The evenly spaced part of a column."""

import re

import numpy as np
import pytest
from numpy.typing import NDArray

from gyrotest.analysis.continuity import Stretch
from gyrotest.errors import InsufficientDataError
from gyrotest.offline.reading import Column
from gyrotest.offline.request import Window
from gyrotest.offline.uniform import Uniform, uniform_by_row, uniform_by_time
from gyrotest.records.spec import Gaps


def _by_row(row: NDArray[np.int64] | None, gaps: Gaps = Gaps.REFUSE, **window: float) -> Uniform:
    size = 100 if row is None else row.size
    return uniform_by_row(
        Column(values=np.zeros(size), row=row, time_s=None),
        interval_s=0.5,
        window=Window(**window) if window else None,
        gaps=gaps,
    )


def _by_time(
    time_s: NDArray[np.float64],
    *,
    interval_s: float | None = None,
    gaps: Gaps = Gaps.REFUSE,
    **window: float,
) -> Uniform:
    return uniform_by_time(
        time_s, interval_s=interval_s, window=Window(**window) if window else None, gaps=gaps
    )


def _gapped(size: int = 100) -> NDArray[np.int64]:
    """Rows of which 30 … 34 and 60 are missing."""
    row = np.arange(size)
    return row[(row < 30) | ((row > 34) & (row != 60))]


class TestByRow:
    def test_all_rows_are_one_stretch(self) -> None:
        found = _by_row(None)
        assert (found.stretch, found.begin_s, found.remarks) == (Stretch(start=0, stop=100), 0.0, ())

    def test_a_window_is_counted_from_the_first_sample(self) -> None:
        found = _by_row(None, begin_s=5.0, end_s=20.0)
        assert (found.stretch, found.begin_s) == (Stretch(start=10, stop=40), 5.0)

    def test_a_window_beyond_the_record_is_refused(self) -> None:
        with pytest.raises(InsufficientDataError, match="ends beyond the record of 50 s"):
            _by_row(None, begin_s=5.0, end_s=50.5)

    def test_the_first_gap_is_named(self) -> None:
        with pytest.raises(InsufficientDataError, match=r"5 are missing after row 30 \(the first of 2"):
            _by_row(_gapped())

    def test_the_longest_stretch_is_used_where_that_is_asked_for(self) -> None:
        found = _by_row(_gapped(), Gaps.LONGEST_STRETCH)
        assert found.stretch.size == 39
        assert found.begin_s == 61 * 0.5
        assert "2 gaps" in found.remarks[0]

    def test_a_window_between_gaps_needs_no_permission(self) -> None:
        found = _by_row(_gapped(), begin_s=17.5, end_s=30.0)
        assert (found.stretch.size, found.begin_s, found.remarks) == (25, 17.5, ())


class TestByTime:
    def test_the_interval_is_the_mean_of_the_stamps(self) -> None:
        found = _by_time(7.0 + 0.01003 * np.arange(1000))
        assert found.interval_s == pytest.approx(0.01003, rel=1e-12)
        assert (found.begin_s, found.remarks) == (0.0, ())

    def test_a_stated_rate_stands_where_the_stamps_agree(self) -> None:
        assert _by_time(0.01003 * np.arange(1000), interval_s=0.01).interval_s == 0.01

    def test_a_stated_rate_that_the_stamps_deny_is_refused(self) -> None:
        with pytest.raises(InsufficientDataError, match="100 Hz is stated, the time stamps say 50 Hz"):
            _by_time(0.02 * np.arange(1000), interval_s=0.01)

    def test_the_first_step_that_is_no_interval_is_named(self) -> None:
        time_s = 0.01 * np.arange(1000)
        time_s[500:] += 0.05
        with pytest.raises(InsufficientDataError, match=r"row 501 comes 0.06 s after the one before"):
            _by_time(time_s)
        found = _by_time(time_s, gaps=Gaps.LONGEST_STRETCH)
        assert found.stretch.size == 500
        assert "1 gap in the record" in found.remarks[0]

    def test_a_stamp_that_repeats_is_no_interval(self) -> None:
        time_s = 0.01 * np.arange(1000)
        time_s[200] = time_s[199]
        with pytest.raises(InsufficientDataError, match="row 201 comes 0 s after"):
            _by_time(time_s)

    def test_a_little_jitter_is_told(self) -> None:
        jitter = np.random.default_rng(2).uniform(-2e-4, 2e-4, 1000)
        (remark,) = _by_time(0.01 * np.arange(1000) + jitter).remarks
        assert re.match(r"The time stamps jitter by 0\.00016 s rms", remark)

    def test_much_jitter_is_refused_with_its_place(self) -> None:
        time_s = 0.01 * np.arange(1000) + np.random.default_rng(2).uniform(-2e-3, 2e-3, 1000)
        with pytest.raises(InsufficientDataError, match=r"jitter by 0\.0016 s rms .* most at row \d+;"):
            _by_time(time_s)

    @pytest.mark.parametrize("time_s", [np.zeros(50), -0.01 * np.arange(50), np.zeros(1)])
    def test_stamps_that_do_not_go_forward_are_refused(self, time_s: NDArray[np.float64]) -> None:
        with pytest.raises(InsufficientDataError, match="do not go forward"):
            _by_time(time_s)

    def test_a_stamp_that_is_no_number_is_named(self) -> None:
        time_s = 0.01 * np.arange(50)
        time_s[7] = np.nan
        with pytest.raises(InsufficientDataError, match="time stamp of row 8 is nan"):
            _by_time(time_s)

    def test_a_window_is_counted_from_the_first_stamp(self) -> None:
        found = _by_time(1e9 + 0.25 * np.arange(1000), begin_s=10.0, end_s=20.0)
        assert (found.stretch, found.begin_s) == (Stretch(start=40, stop=80), 10.0)
        with pytest.raises(InsufficientDataError, match="ends beyond"):
            _by_time(0.25 * np.arange(1000), begin_s=10.0, end_s=251.0)

    def test_a_window_without_samples_is_refused(self) -> None:
        time_s = np.concatenate([0.25 * np.arange(100), 1000.0 + 0.25 * np.arange(100)])
        with pytest.raises(InsufficientDataError, match="no samples are left"):
            _by_time(time_s, begin_s=100.0, end_s=200.0)
