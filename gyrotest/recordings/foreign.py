"""A recorded file as samples at places on a grid: its window, its stamps, its unit."""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from gyrotest.errors import InsufficientDataError, RecordingError
from gyrotest.recordings.formats.detect import read_parts
from gyrotest.recordings.formats.selection import Part, Selection
from gyrotest.recordings.regroup import Placed
from gyrotest.recordings.stamps import MOST_WITHOUT_PLACE, Grid, Stamps, survey
from gyrotest.records.recording import SampleFlag

# How far the sampling rate that is stated may be from the one in the time stamps.
_RATES_AGREE = 0.01


@dataclass(frozen=True, slots=True, kw_only=True)
class Window:
    """Which rows count: `first` … `last` by number from 1, and times in `[start_s, end_s)`."""

    first: int = 1
    last: int | None = None
    start_s: float | None = None
    end_s: float | None = None

    def takes(self, row: NDArray[np.int64], time_s: NDArray[np.float64]) -> NDArray[np.bool_]:
        """Return which rows are inside."""
        inside: NDArray[np.bool_] = row + 1 >= self.first
        if self.last is not None:
            inside &= row + 1 <= self.last
        if self.start_s is not None:
            inside &= time_s >= self.start_s
        if self.end_s is not None:
            inside &= time_s < self.end_s
        return inside


class ForeignFile:
    """A file that is read as often as asked, block by block.

    `interval_s` is known from outside or, with a time column, found in the stamps; `factors` turn the
    numbers of each column into the unit wanted, `time_factor_s` those of the time column into seconds,
    where they are no dates. The first `outputs` columns are what is tested: a sample that lacks one of
    them is flagged; where one of the others is missing it is NaN.
    Everything raises `RecordingError`.
    """

    def __init__(
        self,
        path: Path,
        selection: Selection,
        window: Window,
        *,
        interval_s: float | None,
        factors: Sequence[float],
        outputs: int = 1,
        time_factor_s: float,
    ) -> None:
        self._path, self._selection, self._window = path, selection, window
        self._factors = np.array(factors, dtype=np.float64)
        self._outputs, self._time_factor_s = outputs, time_factor_s
        self.stamps = None if selection.time_column is None else self._surveyed(interval_s)
        self.interval_s = self._known_interval(interval_s)

    def samples(self) -> Iterator[Placed]:
        """Yield the window's samples; the first one has place 0."""
        grid = Grid(self.stamps) if self.stamps else None
        begin: int | None = None
        for part in self._parts():
            row, time_s, values = part.row, self._time_s(part), self._scaled(part)
            if grid is None:
                begin = int(row[0]) if begin is None and row.size else begin
                place = row - (begin or 0)
            else:
                accepted, place = grid.places(time_s)
                time_s, values = time_s[accepted], values[accepted]
            yield self._placed(place, time_s, values)

    def _placed(
        self, place: NDArray[np.int64], time_s: NDArray[np.float64], values: NDArray[np.float64]
    ) -> Placed:
        flags = np.zeros(place.size, dtype=np.uint8)
        outputs = values[:, : self._outputs]
        if not np.isfinite(outputs).all():
            flags[np.isnan(outputs).any(axis=1)] = SampleFlag.NOT_A_NUMBER.value
            flags[np.isinf(outputs).any(axis=1)] = SampleFlag.OVERLOAD.value
        return Placed(place=place, time_s=time_s, values=values, flags=flags)

    def _scaled(self, part: Part) -> NDArray[np.float64]:
        """Return all columns (n, columns) in their units."""
        columns = (part.values, *part.beside)
        scaled = np.empty((part.row.size, len(columns)), order="F")
        for at, column in enumerate(columns):
            np.multiply(column, self._factors[at], out=scaled[:, at])
        return scaled

    def _parts(self) -> Iterator[Part]:
        """Yield the rows inside the window, and stop reading behind it."""
        last = self._last_row()
        for part in read_parts(self._path, self._selection):
            if part.row.size and last is not None and part.row[0] > last:
                return
            inside = self._window.takes(part.row, self._time_s(part))
            yield part if inside.all() else part.kept(inside)

    def _last_row(self) -> int | None:
        """The number of the last row that can be inside, where the numbers tell."""
        last = math.inf if self._window.last is None else self._window.last - 1
        if self._selection.time_column is None and self._window.end_s is not None:
            last = min(last, math.ceil(self._window.end_s / self.interval_s))
        return None if math.isinf(last) else int(last)

    def _time_s(self, part: Part) -> NDArray[np.float64]:
        stamps_s = part.time_s(self._time_factor_s)
        if stamps_s is not None:
            return stamps_s
        # The quotient of two decimal numbers is rounded once, so that a window's edge is met.
        return part.row / (1.0 / self.interval_s)

    def _surveyed(self, interval_s: float | None) -> Stamps:
        try:
            found = survey(self._time_s(part) for part in self._parts())
        except InsufficientDataError as error:
            raise RecordingError(
                f"{self._path}: column '{self._selection.time_column}' {error}"
            ) from error
        if found.without_place > MOST_WITHOUT_PLACE * (found.count + found.without_place):
            raise RecordingError(
                f"{self._path}: in column '{self._selection.time_column}' {found.repeated} time stamps repeat, "
                f"{found.backward} go back and {found.absent} are missing beside {found.count} that go forward; "
                f"choose another column or window, or give 'sample_rate' instead"
            )
        if interval_s is not None and abs(found.interval_s / interval_s - 1.0) > _RATES_AGREE:
            raise RecordingError(
                f"{self._path}: a sampling rate of {1.0 / interval_s:.6g} Hz is stated, its time stamps say "
                f"{1.0 / found.interval_s:.6g} Hz; leave 'sample_rate' out, or look at 'time_unit'"
            )
        return found

    def _known_interval(self, interval_s: float | None) -> float:
        if interval_s is not None:
            return interval_s
        if self.stamps is None:
            raise RecordingError(
                f"{self._path}: its sampling rate is not known; give 'sample_rate', e.g. '100 Hz', or a "
                f"'time_column'"
            )
        return self.stamps.interval_s
