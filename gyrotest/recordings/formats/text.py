"""Text: one value a line, columns by white space, comma, semicolon or tab, with any header.

Clean files are read by pyarrow; from the first place that it does not take, line by line, so that
a fault is told with its line.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from gyrotest.errors import RecordingError
from gyrotest.recordings.formats.selection import PART_ROWS, Content, Part, Selection, find_column
from gyrotest.recordings.formats.text_dates import Dates, parsed
from gyrotest.recordings.formats.text_fast import FastText, is_clean
from gyrotest.recordings.formats.text_head import COMMENT, TextHead, read_head

_NOR_DATES = "; times are numbers in all rows, or dates such as 2026-01-31T12:00:00.5 in all"


@dataclass(frozen=True, slots=True, kw_only=True)
class TextColumns:
    """The positions of the columns to read (the values, then what is beside them), and the filter."""

    values: tuple[int, ...]
    time: int | None
    where: tuple[tuple[int, tuple[Content, ...]], ...]

    def keeps(self, cells: list[str], head: TextHead) -> bool:
        """Whether a row passes the filter."""
        return all(
            any(_same(cells[at], content, head) for content in contents) for at, contents in self.where
        )


def read_text(path: Path, selection: Selection) -> Iterator[Part]:
    """Yield the rows of a text file; raises `RecordingError` with the line of a fault."""
    wanted = (selection.column, selection.time_column, *selection.beside, *selection.where)
    head = read_head(path, skip_rows=selection.skip_rows, wanted=wanted)
    columns = TextColumns(
        values=tuple(
            find_column(one, head.names, path) for one in (selection.column, *selection.beside)
        ),
        time=None
        if selection.time_column is None
        else find_column(selection.time_column, head.names, path),
        where=tuple(
            (find_column(name, head.names, path), contents)
            for name, contents in selection.accepted.items()
        ),
    )
    done = 0
    if is_clean(path, head):
        fast = FastText(path, head, columns.values, columns.time, columns.where)
        yield from fast.parts()
        if fast.finished:
            return
        done = fast.rows
    yield from _slow(path, head, columns, done)


def _slow(path: Path, head: TextHead, columns: TextColumns, done: int) -> Iterator[Part]:
    block = _Block(path, head, columns, dates=None if done else _dates(path, head, columns))
    for row, (line, cells) in enumerate(_lines(path, head)):
        if row < done or not columns.keeps(cells, head):
            continue
        block.add(row, line, cells)
        if block.rows == PART_ROWS:
            yield block.taken()
    yield block.taken()


def _dates(path: Path, head: TextHead, columns: TextColumns) -> Dates | None:
    """Return what reads a time column of dates: the first row tells."""
    first = next(_lines(path, head), None)
    if first is None or columns.time is None:
        return None
    cell = first[1][columns.time]
    return Dates() if head.number(cell) is None and parsed(cell) else None


class _Block:
    """Gathers rows."""

    def __init__(self, path: Path, head: TextHead, columns: TextColumns, *, dates: Dates | None) -> None:
        self._path, self._head, self._columns, self._dates = path, head, columns, dates
        self._rows: list[int] = []
        self._values: list[list[float]] = [[] for _ in columns.values]
        self._times: list[float] = []

    @property
    def rows(self) -> int:
        """How many there are."""
        return len(self._rows)

    def add(self, row: int, line: int, cells: list[str]) -> None:
        """Read a row; raises `RecordingError` with its line."""
        self._rows.append(row)
        for values, at in zip(self._values, self._columns.values, strict=True):
            values.append(_number(cells, at, self._path, line, self._head))
        if self._columns.time is not None:
            self._times.append(self._time(cells, self._columns.time, line))

    def _time(self, cells: list[str], at: int, line: int) -> float:
        if self._dates is None:
            return _number(cells, at, self._path, line, self._head, also=_NOR_DATES)
        try:
            return self._dates.seconds(cells[at])
        except ValueError as error:
            raise RecordingError(
                f"{self._path}:{line}: column '{self._head.names[at]}': {error}"
            ) from error

    def taken(self) -> Part:
        """Return the rows, and begin anew."""
        part = Part(
            row=np.array(self._rows, dtype=np.int64),
            values=np.array(self._values[0], dtype=np.float64),
            time=None if self._columns.time is None else np.array(self._times, dtype=np.float64),
            time_in_s=self._dates is not None,
            beside=tuple(np.array(values, dtype=np.float64) for values in self._values[1:]),
        )
        self._rows, self._values, self._times = [], [[] for _ in self._values], []
        return part


def _lines(path: Path, head: TextHead) -> Iterator[tuple[int, list[str]]]:
    begun, blank = False, 0
    with path.open(encoding=head.encoding, errors="replace") as stream:
        for number, line in enumerate(stream, start=1):
            if number < head.data_line:
                continue
            text = line.strip(" \r\n")
            if not text:
                blank = blank or number
            elif not text.startswith(COMMENT):
                if begun and blank:
                    raise RecordingError(
                        f"{path}:{blank}: is blank, between rows of numbers; remove the line, or put a row of"
                        " 'nan' there if a sample is missing"
                    )
                yield number, _cells(line, path, number, head)
                begun, blank = True, 0


def _cells(line: str, path: Path, number: int, head: TextHead) -> list[str]:
    cells = head.cells(line.rstrip("\r\n"))
    if len(cells) != len(head.names):
        raise RecordingError(
            f"{path}:{number}: has {len(cells)} cells where the other rows have {len(head.names)}"
        )
    return cells


def _number(
    cells: list[str], at: int, path: Path, line: int, head: TextHead, *, also: str = ""
) -> float:
    number = head.number(cells[at])
    if number is None:
        raise RecordingError(
            f"{path}:{line}: column '{head.names[at]}': '{cells[at].strip()}' is no number{also}"
        )
    return number


def _same(cell: str, content: Content, head: TextHead) -> bool:
    if isinstance(content, str):
        return cell.strip() == content
    return head.number(cell) == content
