"""The head of a text table: its encoding, separator, names of columns, and where the data begin."""

import codecs
import csv
import re
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from gyrotest.errors import RecordingError

COMMENT = ("%", "#")
MISSING = frozenset({"", "nan", "na", "n/a", "null", "none", "-", "--"})

_HEAD_BYTES = 1 << 17
_SAMPLE_LINES = 50
_NUMBER = re.compile(
    r"[+-]?(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][+-]?[0-9]+)?|[+-]?inf(?:inity)?", re.IGNORECASE
)
_DECIMAL_COMMA = re.compile(r"[+-]?[0-9]+,[0-9]+(?:[eE][+-]?[0-9]+)?")


@dataclass(frozen=True, slots=True, kw_only=True)
class TextHead:
    """How a text table is to be read. `separator` None: white space. Lines count from 1.

    `names` has one name a column: the file's own, or the columns' numbers.
    """

    encoding: str
    separator: str | None
    decimal: str
    names: tuple[str, ...]
    data_line: int

    def cells(self, line: str) -> list[str]:
        """Split a line; one empty cell too many at its end does not count."""
        cells = split(line, self.separator)
        if len(cells) == len(self.names) + 1 and not cells[-1].strip():
            cells.pop()
        return cells

    def number(self, cell: str) -> float | None:
        """Read a cell: NaN for a missing one, None where it is no number."""
        text = cell.strip()
        if text.lower() in MISSING:
            return float("nan")
        if self.decimal != ".":
            text = text.replace(self.decimal, ".")
        return float(text) if _NUMBER.fullmatch(text) else None


def split(line: str, separator: str | None) -> list[str]:
    """Split a line into cells."""
    if separator is None:
        return line.split()
    if '"' in line:
        return next(csv.reader([line], delimiter=separator))
    return line.split(separator)


def read_head(path: Path, *, skip_rows: int, wanted: Sequence[str | int | None]) -> TextHead:
    """Look at the beginning of a text file; raises `RecordingError`.

    `wanted` are the columns asked for: their names tell which of several header lines has the names.
    """
    encoding, lines = _lines(path)
    sample = [
        line for line in lines[skip_rows:] if line.strip() and not line.lstrip().startswith(COMMENT)
    ]
    if not sample:
        raise RecordingError(f"{path}: holds no rows of data")
    separator = _separator(sample[-_SAMPLE_LINES:])
    rows = [split(line, separator) for line in sample[-_SAMPLE_LINES:]]
    width = Counter(map(len, rows)).most_common(1)[0][0]
    typical = next(row for row in reversed(rows) if len(row) == width)
    while width > 1 and all(not row[-1].strip() for row in rows if len(row) == width):
        width -= 1
        rows = [row[:width] for row in rows]
        typical = typical[:width]
    decimal = "," if separator in (";", "\t") and any(map(_is_decimal_comma, typical)) else "."
    shape = TextHead(
        encoding=encoding,
        separator=separator,
        decimal=decimal,
        names=("",) * width,
        data_line=skip_rows + 1,
    )
    head = _with_names(shape, lines, typical, wanted, path)
    _refuse_decimal_commas(head, lines, skip_rows, [row for row in rows if len(row) == width], path)
    return head


def _with_names(
    shape: TextHead, lines: list[str], typical: list[str], wanted: Sequence[str | int | None], path: Path
) -> TextHead:
    """Find where the data begin and which line before it names the columns."""
    named: list[list[str]] = []
    begin = shape.data_line
    for number, line in enumerate(lines[shape.data_line - 1 :], start=shape.data_line):
        if not line.strip():
            # Blank lines before the first row are none between rows.
            if begin == number:
                begin += 1
            continue
        is_comment = line.lstrip().startswith(COMMENT)
        cells = shape.cells(line.lstrip().lstrip("%#") if is_comment else line)
        if _names_columns(cells, shape):
            named.append([cell.strip() for cell in cells[: len(shape.names)]])
            begin = number + 1
        elif not is_comment and _alike(cells, typical, shape):
            begin = begin if named else number
            break
    else:
        raise RecordingError(f"{path}: holds no rows of data")
    return TextHead(
        encoding=shape.encoding,
        separator=shape.separator,
        decimal=shape.decimal,
        names=_chosen(named, wanted, len(shape.names)),
        data_line=begin,
    )


def _refuse_decimal_commas(
    head: TextHead, lines: list[str], skip_rows: int, rows: list[list[str]], path: Path
) -> None:
    """Refuse half as many names as columns where each two cells read as one number: `gz` over `0,53`."""
    above = [
        number
        for number in range(skip_rows + 1, head.data_line)
        if lines[number - 1].strip() and not lines[number - 1].lstrip().startswith(COMMENT)
    ]
    if head.separator != "," or not above:
        return
    names = split(lines[above[-1] - 1], head.separator)
    is_half = 2 * len(names) == len(head.names) and all(head.number(name) is None for name in names)
    if is_half and all(
        _is_decimal_comma(f"{row[at].strip()},{row[at + 1]}")
        for row in rows
        for at in range(0, len(row), 2)
    ):
        raise RecordingError(
            f"{path}:{above[-1]}: names {len(names)} column{'s' * (len(names) > 1)} where the rows have"
            f" {len(head.names)}: {rows[-1][0].strip()},{rows[-1][1].strip()} looks like one number with a decimal"
            " comma; write decimal points, or ';' between columns; if they are whole numbers, name every column"
            " or leave this line out with 'skip_rows'"
        )


def _chosen(named: list[list[str]], wanted: Sequence[str | int | None], width: int) -> tuple[str, ...]:
    for names in reversed(named):
        if any(one in names for one in wanted if isinstance(one, str)):
            return tuple(names)
    if named:
        return tuple(named[-1])
    return tuple(str(number) for number in range(1, width + 1))


def _names_columns(cells: list[str], shape: TextHead) -> bool:
    return len(cells) >= len(shape.names) and all(
        cell.strip() and shape.number(cell) is None for cell in cells
    )


def _alike(cells: list[str], typical: list[str], shape: TextHead) -> bool:
    """Whether a row has numbers where a typical row of data has them."""
    return len(cells) == len(typical) and all(
        (shape.number(cell) is None) <= (shape.number(other) is None)
        for cell, other in zip(cells, typical, strict=True)
    )


def _separator(sample: list[str]) -> str | None:
    for separator in ("\t", ";", ","):
        if 2 * sum(separator in line for line in sample) > len(sample):
            return separator
    return None


def _is_decimal_comma(cell: str) -> bool:
    return _DECIMAL_COMMA.fullmatch(cell.strip()) is not None


def _lines(path: Path) -> tuple[str, list[str]]:
    """Return the encoding and the whole lines at the beginning of a file."""
    with path.open("rb") as stream:
        content = stream.read(_HEAD_BYTES)
        cut = bool(stream.read(1))
    encoding = _encoding(content)
    text = content.decode(encoding, errors="replace")
    if "\0" in text:
        raise RecordingError(f"{path}: is neither text nor a format that gyrotest reads")
    lines = text.splitlines()
    return encoding, lines[:-1] if cut and len(lines) > 1 else lines


def _encoding(content: bytes) -> str:
    if content.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)):
        return "utf-16"
    try:
        codecs.getincrementaldecoder("utf-8")().decode(content)
    except UnicodeDecodeError:
        return "latin-1"
    return "utf-8-sig"
