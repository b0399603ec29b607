"""Readings in lines of text: fields between separators, or groups of a regular expression."""

import math
import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from gyrotest.instruments.streaming.flow import many
from gyrotest.instruments.streaming.readings import Readings
from gyrotest.records.recording import SampleFlag

_LONGEST = 4096
_SHOWN = 60
# What a line is thought to be long before one was seen.
_GUESS_BYTES = 64.0


@dataclass(frozen=True, slots=True, kw_only=True)
class Layout:
    """How a line's numbers are found and what they are worth.

    `split` gives the texts of a line's fields, None for one that does not fit. `places` are those of the
    values, `scales` their factors; the first `outputs` values are outputs, at `full_scale` they overload.
    """

    split: Callable[[bytes], Sequence[bytes] | None]
    places: tuple[int, ...]
    scales: tuple[float, ...]
    outputs: int
    full_scale: float = math.inf
    counter: int | None = None


def by_columns(columns: Sequence[str], separator: str) -> Callable[[bytes], Sequence[bytes] | None]:
    """Split at a separator (empty: at spaces); a line with more or fewer fields does not fit."""
    mark, count = separator.encode() or None, len(columns)

    def split(line: bytes) -> Sequence[bytes] | None:
        fields = line.split(mark)
        return fields if len(fields) == count else None

    return split


def by_pattern(pattern: str) -> tuple[Callable[[bytes], Sequence[bytes] | None], tuple[str, ...]]:
    """Match the whole line; gives its named groups, and their names in that order."""
    compiled = re.compile(pattern.encode())
    names = tuple(compiled.groupindex)
    places = tuple(compiled.groupindex.values())

    def split(line: bytes) -> Sequence[bytes] | None:
        match = compiled.fullmatch(line)
        return None if match is None else [match[place] or b"" for place in places]

    return split, names


class LineDecoder:
    """Finds readings in text as it arrives."""

    def __init__(self, layout: Layout) -> None:
        self._layout = layout
        self._scales = np.array(layout.scales)
        self._shortest = math.inf
        self._unfit = 0
        self._last_unfit = b""
        self.restart()

    @property
    def reading_bytes(self) -> float:
        """The shortest line so far."""
        return self._shortest if math.isfinite(self._shortest) else _GUESS_BYTES

    def restart(self) -> None:
        """Forget what has arrived; what comes up to the first line end may be part of a line."""
        self._rest = b""
        self._begun = False
        self._pending = 0
        self._seen = 0

    def push(self, data: bytes) -> Readings:
        """Take bytes; returns the readings of the lines that are complete."""
        *lines, self._rest = (self._rest + data).split(b"\n")
        self._seen += len(data)
        if len(self._rest) > _LONGEST:
            self._rest = self._rest[-_LONGEST:]
            self._begun = False
        if lines and not self._begun:
            del lines[0]
            self._begun = True
        return self._read(lines)

    def waiting(self) -> int:
        """Bytes that wait for the rest of their line."""
        return len(self._rest)

    def complaint(self) -> str:
        """What arrived in place of lines that fit."""
        if self._last_unfit:
            return (
                f"no line fits; the last one is {_shown(self._last_unfit)}: correct pattern, columns or"
                " separator; or is baud_rate that of the unit?"
            )
        return f"{self._seen} bytes but no line end among them; is baud_rate that of the unit?"

    def forget(self) -> None:
        """Count anew."""
        self._unfit = 0

    def remarks(self) -> tuple[str, ...]:
        """Lines that did not fit."""
        if not self._unfit:
            return ()
        return (f"{many(self._unfit, 'line')} did not fit, the last one {_shown(self._last_unfit)}",)

    def _read(self, lines: list[bytes]) -> Readings:
        rows: list[list[float]] = []
        counts: list[int] = []
        lost: list[int] = []
        for whole in lines:
            line = whole.removesuffix(b"\r")
            if not line:
                continue
            if self._take(line, rows, counts):
                lost.append(self._pending)
                self._pending = 0
                self._shortest = min(self._shortest, len(whole) + 1)
            else:
                self._pending += 1
                self._unfit += 1
                self._last_unfit = line
        return self._readings(rows, counts, lost)

    def _take(self, line: bytes, rows: list[list[float]], counts: list[int]) -> bool:
        layout = self._layout
        fields = layout.split(line)
        if fields is None:
            return False
        try:
            row = [float(fields[place]) for place in layout.places]
            if layout.counter is not None:
                counts.append(int(fields[layout.counter]))
        except ValueError:
            return False
        rows.append(row)
        return True

    def _readings(self, rows: list[list[float]], counts: list[int], lost: list[int]) -> Readings:
        layout = self._layout
        values = np.array(rows, dtype=np.float64).reshape(-1, len(layout.places)) * self._scales
        flags = np.zeros(len(values), dtype=np.uint8)
        flags[~np.isfinite(values).all(axis=1)] |= np.uint8(SampleFlag.NOT_A_NUMBER)
        over = (np.abs(values[:, : layout.outputs]) >= layout.full_scale).any(axis=1)
        flags[over] |= np.uint8(SampleFlag.OVERLOAD)
        counter = None if layout.counter is None else np.array(counts, dtype=np.int64)
        return Readings(values=values, flags=flags, counter=counter, lost=np.array(lost, dtype=np.int64))


def _shown(line: bytes) -> str:
    text = line.decode("ascii", errors="backslashreplace")
    return repr(text if len(text) <= _SHOWN else f"{text[:_SHOWN]}…")
