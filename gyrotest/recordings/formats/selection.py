"""What is wanted of a file, and the blocks of rows that every format gives."""

import difflib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from gyrotest.errors import RecordingError

PART_ROWS = 65_536

Content = str | int | float


@dataclass(frozen=True, slots=True, kw_only=True)
class Selection:
    """Which column of which array, and which rows; columns by name or by number from 1.

    `beside` are further columns, or by name other arrays of as many rows. `where` keeps the rows whose
    columns have these contents, or one of several. `skip_rows` leaves out so many lines at the top of
    a text file before anything else is looked at.
    """

    column: str | int | None = None
    array: str | None = None
    time_column: str | int | None = None
    beside: tuple[str | int, ...] = ()
    where: Mapping[str, Content | tuple[Content, ...]] = field(default_factory=dict)
    skip_rows: int = 0

    @property
    def accepted(self) -> Mapping[str, tuple[Content, ...]]:
        """The contents with which `where` keeps a row, by column."""
        return {
            name: content if isinstance(content, tuple) else (content,)
            for name, content in self.where.items()
        }


@dataclass(frozen=True, slots=True, kw_only=True)
class Part:
    """Rows of a file in their order: each one's number (from 0), value, and time as it stands there.

    `beside` are the further columns that were asked for, each of as many rows. With `time_in_s` the
    times were dates, and are seconds since the first one. A cell that is missing is NaN. The numbers
    jump where `where` left rows out, and where one of our own recordings has a gap.
    """

    row: NDArray[np.int64]
    values: NDArray[np.float64]
    time: NDArray[np.float64] | None = None
    time_in_s: bool = False
    beside: tuple[NDArray[np.float64], ...] = ()

    def kept(self, rows: NDArray[np.bool_]) -> "Part":
        """Some of the rows."""
        return Part(
            row=self.row[rows],
            values=self.values[rows],
            time=None if self.time is None else self.time[rows],
            time_in_s=self.time_in_s,
            beside=tuple(one[rows] for one in self.beside),
        )

    def time_s(self, unit_s: float) -> NDArray[np.float64] | None:
        """Return the times in seconds; `unit_s` is the unit that they stand in, unless they were dates."""
        return self.time if self.time is None or self.time_in_s else self.time * unit_s


def find_column(wanted: str | int | None, names: Sequence[str], path: Path) -> int:
    """Return the position (from 0) of a column.

    Raises `RecordingError` naming the columns that there are, and the nearest one.
    """
    if wanted is None:
        if len(names) == 1:
            return 0
        raise RecordingError(
            f"{path}: has {len(names)} columns ({_listed(names)}); choose one with 'column'"
        )
    if isinstance(wanted, int):
        if 1 <= wanted <= len(names):
            return wanted - 1
        raise RecordingError(
            f"{path}: has no column {wanted}; its {len(names)} columns are {_listed(names)}"
        )
    stripped = [name.strip() for name in names]
    if stripped.count(wanted) > 1:
        places = ", ".join(str(at) for at, name in enumerate(stripped, start=1) if name == wanted)
        raise RecordingError(
            f"{path}: columns {places} are all called '{wanted}'; choose one by its number"
        )
    if wanted in stripped:
        return stripped.index(wanted)
    raise RecordingError(
        f"{path}: has no column '{wanted}'; its columns are {_listed(names)}{_near(wanted, names)}"
    )


def find_name(wanted: str | None, names: Sequence[str], path: Path, setting: str) -> str:
    """Return the name of an array in a file of several; raises `RecordingError` as `find_column`."""
    if wanted is None and len(names) == 1:
        return names[0]
    if wanted is None:
        raise RecordingError(f"{path}: holds {_listed(names) or 'nothing'}; choose one with '{setting}'")
    if wanted not in names:
        raise RecordingError(f"{path}: holds no '{wanted}', but {_listed(names)}{_near(wanted, names)}")
    return wanted


def _listed(names: Sequence[str]) -> str:
    return ", ".join(names[:20]) + (", …" if len(names) > 20 else "")


def _near(wanted: str, names: Sequence[str]) -> str:
    near = difflib.get_close_matches(wanted, [name.strip() for name in names], n=1)
    return f"; is '{near[0]}' meant?" if near else ""
