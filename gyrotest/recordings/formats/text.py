"""Text: one value a line, columns by white space, comma, semicolon or tab, with any header.

Clean files are read by pyarrow; from the first place that it does not take, line by line, so that
a fault is told with its line.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from gyrotest.errors import RecordingError
from gyrotest.recordings.formats.selection import PART_ROWS, Part, Selection, find_column
from gyrotest.recordings.formats.text_fast import FastText, is_clean
from gyrotest.recordings.formats.text_head import COMMENT, TextHead, read_head


@dataclass(frozen=True, slots=True, kw_only=True)
class TextColumns:
    """The positions of the columns to read, and the filter."""

    value: int
    time: int | None
    where: tuple[tuple[int, str | int | float], ...]

    def keeps(self, cells: list[str], head: TextHead) -> bool:
        """Whether a row passes the filter."""
        return all(_same(cells[at], content, head) for at, content in self.where)


def read_text(path: Path, selection: Selection) -> Iterator[Part]:
    """Yield the rows of a text file; raises `RecordingError` with the line of a fault."""
    wanted = (selection.column, selection.time_column, *selection.where)
    head = read_head(path, skip_rows=selection.skip_rows, wanted=wanted)
    columns = TextColumns(
        value=find_column(selection.column, head.names, path),
        time=None
        if selection.time_column is None
        else find_column(selection.time_column, head.names, path),
        where=tuple(
            (find_column(name, head.names, path), content) for name, content in selection.where.items()
        ),
    )
    done = 0
    if is_clean(path, head):
        fast = FastText(path, head, columns.value, columns.time, columns.where)
        yield from fast.parts()
        if fast.finished:
            return
        done = fast.rows
    yield from _slow(path, head, columns, done)


def _slow(path: Path, head: TextHead, columns: TextColumns, done: int) -> Iterator[Part]:
    rows: list[int] = []
    values: list[float] = []
    times: list[float] = []
    for row, (line, cells) in enumerate(_lines(path, head)):
        if row < done or not columns.keeps(cells, head):
            continue
        rows.append(row)
        values.append(_number(cells, columns.value, path, line, head))
        if columns.time is not None:
            times.append(_number(cells, columns.time, path, line, head))
        if len(rows) == PART_ROWS:
            yield _part(rows, values, times if columns.time is not None else None)
            rows, values, times = [], [], []
    yield _part(rows, values, times if columns.time is not None else None)


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


def _number(cells: list[str], at: int, path: Path, line: int, head: TextHead) -> float:
    number = head.number(cells[at])
    if number is None:
        raise RecordingError(
            f"{path}:{line}: column '{head.names[at]}': '{cells[at].strip()}' is no number"
        )
    return number


def _same(cell: str, content: str | int | float, head: TextHead) -> bool:
    if isinstance(content, str):
        return cell.strip() == content
    return head.number(cell) == content


def _part(rows: list[int], values: list[float], times: list[float] | None) -> Part:
    def array(numbers: list[float]) -> NDArray[np.float64]:
        return np.array(numbers, dtype=np.float64)

    return Part(
        row=np.array(rows, dtype=np.int64),
        values=array(values),
        time=None if times is None else array(times),
    )
