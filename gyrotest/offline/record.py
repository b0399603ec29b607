"""A rate record out of a file: read, evenly spaced, sound, and in °/s."""

import re
import shlex
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from gyrotest.analysis.continuity import stuck_stretch
from gyrotest.analysis.noise import SHORTEST_RECORD
from gyrotest.analysis.resolution import digital_step
from gyrotest.errors import GyrotestError, InsufficientDataError, RecordingError
from gyrotest.offline.leaps import largest_leap
from gyrotest.offline.reading import Column, Watch, read_column
from gyrotest.offline.request import Request
from gyrotest.offline.sources import Source, time_like
from gyrotest.offline.uniform import Uniform, uniform_by_row, uniform_by_time
from gyrotest.procedures.rest.soundness import rounding_complaint
from gyrotest.procedures.wording import plain
from gyrotest.recordings.formats.contents import contents
from gyrotest.recordings.formats.detect import Format, detect
from gyrotest.recordings.formats.selection import Selection
from gyrotest.recordings.reader import read_header
from gyrotest.records.recording import Sampling
from gyrotest.units import conversion_factor, printed_unit

_INTERVALS_AGREE = 1e-3
_SAMPLE = "sample"
_UNIT_IN_NAME = re.compile(r"(?:^|[\[( _])(ms|us|ns|[µμ]s)[\])]?$", re.IGNORECASE)


@dataclass(frozen=True, slots=True, kw_only=True)
class RateRecord:
    """Evenly spaced rates, shape (n,).

    Each sample is the mean over `reading_s`, `readings` times in each interval.
    """

    source: Source
    rate_dps: NDArray[np.float64]
    interval_s: float
    begin_s: float
    reading_s: float
    readings: int
    remarks: tuple[str, ...]

    @property
    def duty(self) -> float:
        """Part of each interval over which the rate is averaged, 0 … 1."""
        return min(self.readings * self.reading_s / self.interval_s, 1.0)


def rate_record(source: Source, request: Request, watch: Watch) -> RateRecord:
    """Read a column and check it; raises `GyrotestError`, its message beginning with the file."""
    try:
        return _rate_record(source, request, watch)
    except (GyrotestError, OSError) as error:
        raise placed(error, source) from error


def placed(error: Exception, source: Source) -> RecordingError:
    """Return an error whose message begins with the file and the column."""
    place, told = str(source.path), str(error)
    if not told.startswith(place):
        told = f"{place}: {source.name}: {told}" if source.name else f"{place}: {told}"
    return RecordingError(told)


def check_known(path: Path, request: Request) -> None:
    """Check what every column of a file needs; raises `RecordingError` with all that is not known."""
    own = own_sampling(path)
    faults: list[str] = []
    for needed in (
        lambda: request.conversion(own.unit if own else None),
        lambda: _stated_interval(request, own, path),
        lambda: _check_time_unit(request, path),
    ):
        try:
            needed()
        except RecordingError as error:
            faults.append(str(error))
    if faults:
        raise RecordingError(f"{path}: {'; '.join(faults)}")


def _rate_record(source: Source, request: Request, watch: Watch) -> RateRecord:
    own = own_sampling(source.path)
    conversion = request.conversion(own.unit if own else None)
    interval_s = _stated_interval(request, own, source.path)
    selection, unit_s = _selection(source, request), _time_factor_s(request)
    column = read_column(source, selection, watch, time_unit_s=unit_s)
    if not column.values.size:
        raise InsufficientDataError(_nothing(request))
    uniform = _uniform(column, request, interval_s)
    values = column.values[uniform.stretch.start : uniform.stretch.stop]
    unit = own.unit if own else request.unit or ""
    first_row = uniform.stretch.start if column.row is None else int(column.row[uniform.stretch.start])
    remarks = (*uniform.remarks, *_checked(values, first_row, unit))
    reading_s, readings = _reading(request, own, uniform.interval_s)
    values *= conversion.factor
    values -= conversion.offset_dps
    values.setflags(write=False)
    return RateRecord(
        source=source,
        rate_dps=values,
        interval_s=uniform.interval_s,
        begin_s=uniform.begin_s,
        reading_s=reading_s,
        readings=readings,
        remarks=remarks,
    )


def own_sampling(path: Path) -> Sampling | None:
    """Return how one of our own recordings was sampled; None of any other file."""
    return read_header(path).sampling if detect(path) is Format.OWN else None


def _selection(source: Source, request: Request) -> Selection:
    return Selection(
        column=source.column,
        array=source.array,
        time_column=request.time_column,
        where=request.where,
        skip_rows=request.skip_rows,
    )


def _stated_interval(request: Request, own: Sampling | None, path: Path) -> float | None:
    stated_s = request.interval_s
    if own and stated_s is not None and abs(stated_s / own.interval_s - 1.0) > _INTERVALS_AGREE:
        raise RecordingError(
            f"is a recording with a sample every {own.interval_s:g} s; leave --rate out"
        )
    if own:
        return own.interval_s
    if stated_s is None and request.time_column is None:
        near = time_like(path, request)
        hint = f"--time-column {shlex.quote(near)}" if near else "--time-column NAME"
        raise RecordingError(f"its sampling rate is not known; give e.g. --rate '100 Hz', or {hint}")
    return stated_s


def _uniform(column: Column, request: Request, interval_s: float | None) -> Uniform:
    if column.time_s is not None:
        return uniform_by_time(
            column.time_s,
            interval_s=interval_s,
            window=request.window,
            gaps=request.gaps,
        )
    if interval_s is None:
        raise RecordingError("its sampling rate is not known; give e.g. --rate '100 Hz'")
    return uniform_by_row(column, interval_s=interval_s, window=request.window, gaps=request.gaps)


def _time_factor_s(request: Request) -> float:
    if request.time_unit == _SAMPLE and request.interval_s is not None:
        return request.interval_s
    return 1.0 if request.time_unit is None else conversion_factor(request.time_unit, "s")


def _check_time_unit(request: Request, path: Path) -> None:
    """Refuse to take for seconds what is called milliseconds."""
    if request.time_column is None or request.time_unit is not None:
        return
    name = _column_name(request.time_column, path, request.skip_rows)
    found = _UNIT_IN_NAME.search(name)
    if found:
        raise RecordingError(
            f"its time column is called '{name}'; give --time-unit {found[1]}, or --time-unit s if it is in"
            " seconds all the same"
        )


def _column_name(column: str | int, path: Path, skip_rows: int) -> str:
    if isinstance(column, str):
        return column
    tables = contents(path, skip_rows=skip_rows)
    names = tables[0].columns if len(tables) == 1 else ()
    return names[column - 1] if 0 < column <= len(names) else ""


def _nothing(request: Request) -> str:
    if not request.where:
        return "there are no samples"
    filters = ", ".join(f"{name}={content}" for name, content in request.where.items())
    return f"no row has {filters}; look at --where"


def _checked(values: NDArray[np.float64], first_row: int, unit: str) -> tuple[str, ...]:
    """Refuse what no analysis can use; say what else is to be known."""
    if not np.isfinite(values.sum()):
        _refuse_not_finite(values, first_row)
    if values.size < SHORTEST_RECORD:
        raise InsufficientDataError(
            f"{values.size} samples are too few: a noise model needs at least {SHORTEST_RECORD}"
        )
    if values.min() == values.max():
        raise InsufficientDataError(
            f"all {values.size} samples are {values[0]:.9g} {printed_unit(unit)}: a constant carries no noise"
        )
    stuck = stuck_stretch(values)
    if stuck is not None:
        raise InsufficientDataError(
            f"rows {first_row + stuck.start + 1} to {first_row + stuck.stop} are all"
            f" {values[stuck.start]:.9g} {printed_unit(unit)}: the reading is stuck, or its steps are too"
            " coarse for the noise; choose a part without them by --window"
        )
    step = digital_step(values)
    complaint = "" if step is None else rounding_complaint(values, step, unit)
    rounding = (f"The gyro's noise is {complaint}.",) if complaint else ()
    return (*rounding, *_leaps(values, first_row, unit))


def _leaps(values: NDArray[np.float64], first_row: int, unit: str) -> tuple[str, ...]:
    leap = largest_leap(values)
    if leap is None:
        return ()
    return (
        f"At row {first_row + leap.at + 1} the record leaps by {plain(leap.size, 3)} {printed_unit(unit)},"
        f" {plain(leap.times_usual, 2)} times the usual step: a spike, a fault or a motion is not noise, and all"
        " values hold it; leave it out by --window.",
    )


def _refuse_not_finite(values: NDArray[np.float64], first_row: int) -> None:
    bad = np.flatnonzero(~np.isfinite(values))
    if bad.size:
        kind = "missing or not a number" if np.isnan(values[bad[0]]) else "infinite"
        raise InsufficientDataError(
            f"row {first_row + int(bad[0]) + 1} is {kind} ({bad.size} of {values.size} rows are not finite);"
            " choose a part without them by --window"
        )


def _reading(request: Request, own: Sampling | None, interval_s: float) -> tuple[float, int]:
    """Return the aperture of a reading and how many there are in an interval."""
    if request.reading_s is not None:
        return request.reading_s, 1
    if request.duty is not None:
        return request.duty * interval_s, 1
    return (own.aperture_s, own.readings) if own else (interval_s, 1)
