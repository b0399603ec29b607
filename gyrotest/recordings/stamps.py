"""Time stamps of a recorded file: how regular they are, and their samples' places on a grid.

An interval of more than `GAP` times the median is a gap; shorter ones are jitter and count as one
step of the grid each, so that a slightly wrong clock opens no gaps. A stamp that is missing, that
repeats or that goes back leaves its sample without a place.
"""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gyrotest.errors import InsufficientDataError

GAP = 1.5
MOST_WITHOUT_PLACE = 0.01

# The median is taken over this many intervals at the beginning.
_MEDIAN_OVER = 1_000_000

# Departures below this part of an interval are the rounding of decimal stamps.
_NO_JITTER = 1e-6


@dataclass(frozen=True, slots=True, kw_only=True)
class Stamps:
    """What was found. `interval_s` is the mean of the intervals that are no gaps.

    `missing` counts the samples that fit into the gaps; `longest_after_s` is the stamp before the
    longest gap. Jitter is the departure of an interval, gaps apart, from the mean.
    """

    count: int
    first_s: float
    median_s: float
    interval_s: float
    gaps: int
    missing: int
    longest_gap_s: float
    longest_after_s: float
    jitter_rms_s: float
    jitter_max_s: float
    repeated: int
    backward: int
    absent: int

    @property
    def without_place(self) -> int:
        """How many samples have no place on the grid."""
        return self.repeated + self.backward + self.absent


class Ascent:
    """The stamps that go forward, part by part."""

    def __init__(self) -> None:
        self.latest_s = -np.inf
        self.repeated = self.backward = self.absent = 0

    def accepted(self, times_s: NDArray[np.float64]) -> NDArray[np.bool_]:
        """Return which stamps are later than all before them, and count the others."""
        known = np.where(np.isfinite(times_s), times_s, -np.inf)
        before = np.maximum.accumulate(np.concatenate([[self.latest_s], known]))
        accepted: NDArray[np.bool_] = known > before[:-1]
        absent = ~np.isfinite(times_s)
        repeated = ~absent & (known == before[:-1])
        self.absent += int(np.count_nonzero(absent))
        self.repeated += int(np.count_nonzero(repeated))
        self.backward += int(np.count_nonzero(~accepted & ~absent & ~repeated))
        self.latest_s = float(before[-1])
        return accepted


class Grid:
    """Places on a grid, from the stamps' intervals; the first sample has place 0."""

    def __init__(self, stamps: Stamps) -> None:
        self._gap_s = GAP * stamps.median_s
        self._interval_s = stamps.interval_s
        self._ascent = Ascent()
        self._last_s: float | None = None
        self._last_place = 0

    def places(self, times_s: NDArray[np.float64]) -> tuple[NDArray[np.bool_], NDArray[np.int64]]:
        """Return which samples have a place, and the places of those."""
        accepted = self._ascent.accepted(times_s)
        known = times_s[accepted]
        if not known.size:
            return accepted, np.empty(0, dtype=np.int64)
        before = known[0] if self._last_s is None else self._last_s
        steps = steps_of(np.diff(known, prepend=before), self._gap_s, self._interval_s)
        if self._last_s is None:
            steps[0] = 0
        places = self._last_place + np.cumsum(steps)
        self._last_s, self._last_place = float(known[-1]), int(places[-1])
        return accepted, places


def steps_of(intervals_s: NDArray[np.float64], gap_s: float, interval_s: float) -> NDArray[np.int64]:
    """How many steps of the grid each interval is: one, or more where it is a gap."""
    steps = np.ones(intervals_s.size, dtype=np.int64)
    gaps = intervals_s > gap_s
    steps[gaps] = np.maximum(2, np.rint(intervals_s[gaps] / interval_s)).astype(np.int64)
    return steps


def survey(parts_s: Iterable[NDArray[np.float64]]) -> Stamps:
    """Look at all stamps of a file, part by part; raises `InsufficientDataError` below two."""
    ascent = Ascent()
    parts = (part[ascent.accepted(part)] for part in parts_s)
    head: list[NDArray[np.float64]] = []
    for part in parts:
        head.append(part)
        if sum(one.size for one in head) > _MEDIAN_OVER:
            break
    begin = np.concatenate(head) if head else np.empty(0)
    if begin.size < 2:
        raise InsufficientDataError(
            f"has {begin.size} time stamps that go forward; two at least are needed"
        )
    median_s = float(np.median(np.diff(begin)))
    sums = _Sums(median_s)
    sums.add(begin)
    for part in parts:
        sums.add(part)
    return sums.stamps(float(begin[0]), ascent)


class _Sums:
    """The running sums of a survey."""

    def __init__(self, median_s: float) -> None:
        self._median_s = median_s
        self._last_s: float | None = None
        self._count = self._regular = 0
        # Sums of the departures from the median: those of the intervals would lose digits.
        self._sum = self._squares = 0.0
        self._least, self._most = np.inf, -np.inf
        self._gaps: list[NDArray[np.float64]] = []
        self._longest = (0.0, 0.0)

    def add(self, times_s: NDArray[np.float64]) -> None:
        if not times_s.size:
            return
        known = times_s if self._last_s is None else np.concatenate([[self._last_s], times_s])
        self._count += times_s.size
        self._last_s = float(times_s[-1])
        intervals = np.diff(known)
        is_gap = intervals > GAP * self._median_s
        self._add_gaps(intervals[is_gap], known[:-1][is_gap])
        departures = intervals[~is_gap] - self._median_s
        if departures.size:
            self._regular += departures.size
            self._sum += float(departures.sum())
            self._squares += float(np.dot(departures, departures))
            self._least = min(self._least, float(departures.min()))
            self._most = max(self._most, float(departures.max()))

    def _add_gaps(self, lengths_s: NDArray[np.float64], after_s: NDArray[np.float64]) -> None:
        if lengths_s.size:
            self._gaps.append(lengths_s)
            at = int(np.argmax(lengths_s))
            self._longest = max(self._longest, (float(lengths_s[at]), float(after_s[at])))

    def stamps(self, first_s: float, ascent: Ascent) -> Stamps:
        mean = self._sum / self._regular if self._regular else 0.0
        interval_s = self._median_s + mean
        lengths_s = np.concatenate(self._gaps) if self._gaps else np.empty(0)
        steps = steps_of(lengths_s, GAP * self._median_s, interval_s)
        variance = self._squares / self._regular - mean**2 if self._regular else 0.0
        return Stamps(
            count=self._count,
            first_s=first_s,
            median_s=self._median_s,
            interval_s=interval_s,
            gaps=int(lengths_s.size),
            missing=int((steps - 1).sum()),
            longest_gap_s=self._longest[0],
            longest_after_s=self._longest[1],
            jitter_rms_s=float(np.sqrt(max(0.0, variance))),
            jitter_max_s=max(self._most - mean, mean - self._least) if self._regular else 0.0,
            repeated=ascent.repeated,
            backward=ascent.backward,
            absent=ascent.absent,
        )


def described(stamps: Stamps) -> Iterator[str]:
    """Yield what a reader of a certificate should know of the stamps."""
    jitter = f"jitter {stamps.jitter_rms_s:.2g} s rms and at most {stamps.jitter_max_s:.2g} s"
    if stamps.jitter_max_s < _NO_JITTER * stamps.median_s:
        jitter = "no jitter"
    yield (
        f"{stamps.count} time stamps, mean interval {stamps.interval_s:.6g} s "
        f"(median {stamps.median_s:.6g} s), {jitter}"
    )
    if stamps.gaps:
        yield (
            f"gaps (intervals above {GAP:g} × the median): {stamps.gaps}, with room for {stamps.missing} "
            f"samples, the longest {stamps.longest_gap_s:.6g} s after {stamps.longest_after_s:.9g} s"
        )
    if stamps.without_place:
        yield (
            f"samples left out for their time stamps: {stamps.repeated} repeated, "
            f"{stamps.backward} gone back, {stamps.absent} missing"
        )
