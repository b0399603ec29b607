"""The evenly spaced part of a column that is analysed, by its rows or by its time stamps."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gyrotest.analysis.continuity import Stretch, stretches_by_index, stretches_by_time
from gyrotest.errors import InsufficientDataError
from gyrotest.offline.reading import Column
from gyrotest.offline.request import Window
from gyrotest.records.spec import Gaps

_MEDIAN_OVER = 1_000_000
_MOST_JITTER = 0.1
_NO_JITTER = 1e-6
_RATES_AGREE = 0.01


@dataclass(frozen=True, slots=True, kw_only=True)
class Uniform:
    """Samples `stretch` of a column, one every `interval_s`; the first comes `begin_s` after the file's."""

    stretch: Stretch
    interval_s: float
    begin_s: float
    remarks: tuple[str, ...]


def uniform_by_row(column: Column, *, interval_s: float, window: Window | None, gaps: Gaps) -> Uniform:
    """Take the samples in the window, none of them missing; raises `InsufficientDataError`."""
    count = column.values.size
    place = np.arange(0) if column.row is None else column.row - column.row[0]
    if window is None:
        inside = Stretch(start=0, stop=count)
    else:
        edges = [round(one / interval_s) for one in (window.begin_s, window.end_s)]
        length = count if column.row is None else int(place[-1]) + 1
        _check_end(window, length * interval_s, past=edges[1] > length)
        start, stop = edges if column.row is None else np.searchsorted(place, edges)
        inside = Stretch(start=int(start), stop=int(stop))
    if column.row is None:
        return Uniform(
            stretch=inside, interval_s=interval_s, begin_s=inside.start * interval_s, remarks=()
        )
    found = _clipped(stretches_by_index(column.row), inside)
    first = "" if len(found) < 2 else _missing(column.row, found[0].stop)
    used = _used(found, gaps, first)
    return Uniform(
        stretch=used,
        interval_s=interval_s,
        begin_s=int(place[used.start]) * interval_s,
        remarks=_gap_remarks(found, used, inside),
    )


def uniform_by_time(
    time_s: NDArray[np.float64], *, interval_s: float | None, window: Window | None, gaps: Gaps
) -> Uniform:
    """Take the samples in the window, their time stamps evenly apart; raises `InsufficientDataError`.

    `interval_s` is the one stated, if any: the stamps must agree with it.
    """
    _check_finite(time_s)
    median_s = float(np.median(np.diff(time_s[:_MEDIAN_OVER]))) if time_s.size > 1 else 0.0
    if median_s <= 0.0:
        raise InsufficientDataError(
            f"the time stamps do not go forward (median step {median_s:.6g} s); choose another"
            " --time-column, or give --rate instead"
        )
    inside = Stretch(start=0, stop=time_s.size)
    if window is not None:
        length_s = float(time_s[-1] - time_s[0]) + median_s
        _check_end(window, length_s, past=window.end_s > length_s + 0.5 * median_s)
        since = time_s - time_s[0]
        edges = np.searchsorted(since, (window.begin_s - median_s / 1e6, window.end_s - median_s / 1e6))
        inside = Stretch(start=int(edges[0]), stop=int(edges[1]))
    found = _clipped(stretches_by_time(time_s, interval_s=median_s), inside)
    first = "" if len(found) < 2 else _odd_step(time_s, found[0].stop, median_s)
    used = _used(found, gaps, first)
    part_s = time_s[used.start : used.stop]
    mean_s = float(part_s[-1] - part_s[0]) / max(used.size - 1, 1)
    _check_rate(mean_s, interval_s)
    return Uniform(
        stretch=used,
        interval_s=mean_s if interval_s is None else interval_s,
        begin_s=float(part_s[0] - time_s[0]),
        remarks=(*_gap_remarks(found, used, inside), *_jitter(part_s, mean_s, used.start)),
    )


def _check_end(window: Window, length_s: float, *, past: bool) -> None:
    if past:
        raise InsufficientDataError(
            f"the window [{window.begin_s:g} s, {window.end_s:g} s) ends beyond the record of {length_s:g} s"
        )


def _check_finite(time_s: NDArray[np.float64]) -> None:
    bad = np.flatnonzero(~np.isfinite(time_s))
    if bad.size:
        raise InsufficientDataError(
            f"the time stamp of row {bad[0] + 1} is {time_s[bad[0]]} ({bad.size} of {time_s.size} are no"
            " numbers); choose another --time-column, or give --rate instead"
        )


def _check_rate(mean_s: float, stated_s: float | None) -> None:
    if stated_s is not None and abs(mean_s / stated_s - 1.0) > _RATES_AGREE:
        raise InsufficientDataError(
            f"a sampling rate of {1.0 / stated_s:.6g} Hz is stated, the time stamps say"
            f" {1.0 / mean_s:.6g} Hz; leave --rate out, or look at --time-unit"
        )


def _clipped(stretches: tuple[Stretch, ...], inside: Stretch) -> tuple[Stretch, ...]:
    edges = ((max(one.start, inside.start), min(one.stop, inside.stop)) for one in stretches)
    return tuple(Stretch(start=start, stop=stop) for start, stop in edges if start < stop)


def _used(found: tuple[Stretch, ...], gaps: Gaps, first: str) -> Stretch:
    if not found:
        raise InsufficientDataError("no samples are left in the window")
    if len(found) > 1 and gaps is Gaps.REFUSE:
        count = len(found) - 1
        more = "" if count == 1 else f" (the first of {count} such places)"
        raise InsufficientDataError(
            f"the samples are not evenly spaced: {first}{more}; with --gaps longest_stretch the longest"
            " part without a gap is used"
        )
    return max(found, key=lambda one: one.size)


def _missing(row: NDArray[np.int64], stop: int) -> str:
    missing = int(row[stop] - row[stop - 1]) - 1
    return f"{missing} {'is' if missing == 1 else 'are'} missing after row {int(row[stop - 1]) + 1}"


def _odd_step(time_s: NDArray[np.float64], stop: int, median_s: float) -> str:
    step = float(time_s[stop] - time_s[stop - 1])
    return (
        f"the time stamp of row {stop + 1} comes {step:.6g} s after the one before"
        f" ({float(time_s[stop - 1]):.9g} s), others {median_s:.6g} s"
    )


def _gap_remarks(found: tuple[Stretch, ...], used: Stretch, inside: Stretch) -> tuple[str, ...]:
    if len(found) < 2:
        return ()
    gaps = len(found) - 1
    return (
        f"{gaps} gap{'s' * (gaps > 1)} in the record: only the longest part without one is used, rows"
        f" {used.start + 1} to {used.stop}, {used.size} of {inside.size} samples.",
    )


def _jitter(time_s: NDArray[np.float64], mean_s: float, first: int) -> tuple[str, ...]:
    """Refuse stamps that are not evenly apart; tell of those that nearly are."""
    departure = np.diff(time_s)
    departure -= mean_s
    rms = float(np.sqrt(np.mean(departure * departure))) if departure.size else 0.0
    at = int(np.argmax(np.abs(departure))) if departure.size else 0
    if rms > _MOST_JITTER * mean_s:
        raise InsufficientDataError(
            f"the samples are not evenly spaced: their time stamps jitter by {rms:.2g} s rms about steps of"
            f" {mean_s:.6g} s, most at row {first + at + 2}; if only the stamps are late and the gyro's own"
            " clock is even, leave --time-column out and give --rate"
        )
    if not departure.size or abs(float(departure[at])) < _NO_JITTER * mean_s:
        return ()
    return (
        f"The time stamps jitter by {rms:.2g} s rms, at most {abs(float(departure[at])):.2g} s;"
        f" the samples are taken as evenly {mean_s:.6g} s apart.",
    )
