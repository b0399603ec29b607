"""Which columns of a file are analysed: those asked for, else its rate columns where they are plain."""

import difflib
import re
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from gyrotest.errors import RecordingError
from gyrotest.offline.request import Request
from gyrotest.recordings.formats.contents import Table, contents

_RATE = re.compile(
    r"gyr|omega|ang(ular)?[ _]?(rate|vel)|(^|[^a-z])rate|dps|deg/s|rads?/s|°/s|^[gw][ _]?[xyz]$",
    re.IGNORECASE,
)
_NO_RATE = re.compile(
    r"temp|sample[ _]?rate|bias|raw_?time|time_?stamp|input|encoder|acc|scale|range|status",
    re.IGNORECASE,
)
_TIME = re.compile(
    r"^(t|n|index|row|time\b.*|timestamp.*|t[ _]?\[?\(?(s|ms|us)\)?\]?|.*[ _]time|time_.*|samples?"
    r"|count(er)?|date.*|utc.*|epoch.*|sec(onds?)?|ms)$",
    re.IGNORECASE,
)
_AXES = 3
_MANY = 1000


@dataclass(frozen=True, slots=True, kw_only=True)
class Source:
    """A column of a file; `name` is what it is called among the others."""

    path: Path
    array: str | None
    column: str | int | None
    name: str


def sources_of(path: Path, request: Request) -> tuple[Source, ...]:
    """Return the columns of a file to analyse.

    Raises `RecordingError`, naming what is there, where they are not asked for and not plain.
    """
    if request.columns:
        return tuple(_source(path, request.array, column) for column in request.columns)
    held = contents(path, skip_rows=request.skip_rows)
    _check_array(path, request.array, held)
    tables = [
        one for one in held if request.array in (None, one.array) and not _is_time_array(one.array)
    ]
    rates = list(_rates(tables, request))
    plain = rates or [one for one in _only(tables, request) if one.columns]
    if len(plain) != 1 and not (plain and all(map(_is_single, plain))):
        raise RecordingError(_ambiguous(path, tables))
    return tuple(
        _source(path, one.array or None, None if _is_single(one) else column)
        for one in plain
        for column in one.columns
    )


def _is_single(table: Table) -> bool:
    return len(table.columns) == 1 and table.columns[0].isdecimal()


def _check_array(path: Path, wanted: str | None, held: tuple[Table, ...]) -> None:
    names = [one.array for one in held]
    if wanted is None or wanted in names:
        return
    if not any(names):
        raise RecordingError(f"{path}: is one table, without arrays to choose from; leave --array out")
    near = difflib.get_close_matches(wanted, names, n=1)
    hint = f"; is '{near[0]}' meant?" if near else ""
    raise RecordingError(
        f"{path}: holds no numbers called '{wanted}', but {_listed(tuple(names))}{hint}"
    )


def time_like(path: Path, request: Request) -> str | None:
    """Return the name of a column or array that looks like time stamps, for a hint."""
    try:
        tables = contents(path, skip_rows=request.skip_rows)
    except RecordingError:
        return None
    names = [name for table in tables for name in _time_names(table)]
    return names[0] if names else None


def _rates(tables: list[Table], request: Request) -> Iterator[Table]:
    """Yield the tables with columns that are called rates, and only those columns."""
    for one in tables:
        named = tuple(name for name in one.columns if _is_rate(name) and name != request.time_column)
        if named:
            yield Table(array=one.array, columns=named)
        elif _is_rate(one.array) and len(one.columns) <= _AXES and one.columns[0].isdecimal():
            yield one


def _only(tables: list[Table], request: Request) -> Iterator[Table]:
    """Yield the one column that there is beside the time."""
    times = (request.time_column, str(request.time_column))
    rest = [
        Table(
            array=one.array,
            columns=tuple(name for name in one.columns if name not in times and not _is_time(name)),
        )
        for one in tables
    ]
    if sum(len(one.columns) for one in rest) == 1:
        yield from rest


def _source(path: Path, array: str | None, column: str | int | None) -> Source:
    parts = (array, None if column is None else f"column {column}" if _numbered(column) else str(column))
    return Source(
        path=path, array=array, column=_column(column), name=" ".join(part for part in parts if part)
    )


def _numbered(column: str | int) -> bool:
    return isinstance(column, int) or column.isdecimal()


def _column(column: str | int | None) -> str | int | None:
    return int(column) if isinstance(column, str) and column.isdecimal() else column


def _is_rate(name: str) -> bool:
    return bool(_RATE.search(name)) and not _NO_RATE.search(name)


def _is_time(name: str) -> bool:
    return bool(_TIME.match(name.strip()))


def _is_time_array(name: str) -> bool:
    """Whether an array, in whatever groups, is called a time."""
    return _is_time(name.rpartition("/")[2])


def _time_names(table: Table) -> Iterator[str]:
    if _is_time_array(table.array):
        yield table.array
    yield from table.dates
    yield from filter(_is_time, table.columns)


def _ambiguous(path: Path, tables: list[Table]) -> str:
    if not tables:
        return f"{path}: holds no column of numbers to analyse"
    held = "; ".join(
        f"'{one.array}' with columns {_listed(one.columns)}" if one.array else _listed(one.columns)
        for one in tables[:10]
    )
    if any(len(one.columns) > _MANY for one in tables):
        held += " (do its samples lie side by side? then transpose it)"
    choose = "--array and --column" if len(tables) > 1 else "--column (more than once for several)"
    return f"{path}: which column is the rate cannot be told; it holds {held}; choose with {choose}"


def _listed(names: tuple[str, ...]) -> str:
    return ", ".join(names[:20]) + (f", … {names[-1]}" if len(names) > 20 else "")
