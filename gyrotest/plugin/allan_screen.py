"""An Allan deviation curve in a few lines of text: dots of braille over two logarithmic axes."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import groupby
from operator import itemgetter

import numpy as np
from rich.text import Text

from gyrotest.plugin.allan_words import (
    DeviationUnit,
    longest_certain_s,
    lowest_so_far,
    unit_of,
    walk_so_far,
)
from gyrotest.plugin.log_axis import LogAxis, round_axis
from gyrotest.plugin.running_allan import RunningCurve

_EMPTY = 0x2800
_DOTS = ((0x01, 0x02, 0x04, 0x40), (0x08, 0x10, 0x20, 0x80))  # a column of a braille cell, downwards
_MARGIN = 8  # of the deviation's numbers and the axis
_WIDEST, _TALLEST = 60, 10
_NARROWEST, _LOWEST = 24, 4
_AROUND = 5  # lines of a panel beside the plot: title, two of the axis, two of readings
_NARROW = 44  # columns of a plot beside which the words are shortened
_GUTTER = 2
_SO_FAR = "so far: "
_LOWEST_POINT = "○"

_CERTAIN, _UNCERTAIN, _MARKED = "cyan", "bright_black", "bold green"


@dataclass(frozen=True, slots=True, kw_only=True)
class Room:
    """What there is of the terminal, in columns and lines."""

    width: int
    height: int


def allan_lines(curves: Sequence[RunningCurve], *, axis: LogAxis, anew: str, room: Room) -> list[Text]:
    """Draw the curves, or what of them there is room for; the axis is that of the averaging time, s."""
    remark = [Text(anew, style="yellow")] if anew else []
    left = Room(width=room.width, height=room.height - len(remark))
    drawn = _panels(curves, axis, left) or _readings(curves[0] if curves else None)
    return [*drawn, *remark][: max(room.height, 0)]


def time_axis(interval_s: float, planned_samples: int) -> LogAxis:
    """Return the axis of a whole record: to a ninth of it, so that the curve grows into it."""
    return LogAxis(low=interval_s, high=interval_s * max(planned_samples / 9, 10.0))


def _panels(curves: Sequence[RunningCurve], axis: LogAxis, room: Room) -> list[Text]:
    """Panels side by side, then below one another; that of the first channel where there is less room."""
    for count in dict.fromkeys((max(len(curves), 1), 1)):
        across = min(count, max(room.width // (_NARROWEST + _MARGIN + _GUTTER), 1))
        down = math.ceil(count / across)
        each = Room(
            width=min((room.width - _GUTTER * (across - 1)) // across - _MARGIN, _WIDEST),
            height=min(room.height // down - _AROUND, _TALLEST),
        )
        if each.width >= _NARROWEST and each.height >= _LOWEST:
            shown = [_panel(one, axis, each) for one in (curves[:count] or (None,))]
            return _arranged(shown, across, each.width + _MARGIN + _GUTTER)
    return []


def _arranged(panels: list[list[Text]], across: int, width: int) -> list[Text]:
    lines = []
    for begin in range(0, len(panels), across):
        for parts in zip(*panels[begin : begin + across], strict=True):
            line = Text()
            for place, part in enumerate(parts):
                line.pad_right(place * width - line.cell_len)
                line.append_text(part)
            lines.append(line)
    return lines


def _panel(curve: RunningCurve | None, axis: LogAxis, plot: Room) -> list[Text]:
    readings = _readings(curve, prefix=_SO_FAR if plot.width > _NARROW else "")
    if curve is None:
        frame = [Text(f"{'│':>{_MARGIN}}") for _ in range(plot.height)]
        title = Text("Allan deviation: too few samples yet", style="bold")
    else:
        unit = unit_of(curve)
        frame = _Raster(curve, axis, unit, plot).lines()
        name = "" if curve.channel == "output" else f"{curve.channel}: "
        title = Text(f"{name}Allan deviation so far, {unit.name}", style="bold")
        if not curve.certain[-1] and plot.width > _NARROW:
            title.append("  (dotted: ± 13 % and more)", style="not bold dim")
    lines = [title, *frame, *_time_marks(axis, plot.width), *readings]
    for line in lines:
        line.truncate(plot.width + _MARGIN, overflow="ellipsis")
    return lines


def _readings(curve: RunningCurve | None, *, prefix: str = _SO_FAR) -> list[Text]:
    words = (lowest_so_far(curve), walk_so_far(curve))
    return [Text(one and f"{prefix}{one}", style="green") for one in words]


class _Raster:
    """A curve in braille: drawn through where it is certain, dotted and dim where it is not."""

    def __init__(self, curve: RunningCurve, axis: LogAxis, unit: DeviationUnit, plot: Room) -> None:
        self._curve, self._axis, self._unit, self._plot = curve, axis, unit, plot
        values = curve.deviation_dps * unit.per_dps
        self._values = round_axis(float(values.min()), float(values.max()))
        self._across = [self._column(float(tau_s)) for tau_s in curve.tau_s]
        self._up = [self._row(float(value)) for value in values]

    def lines(self) -> list[Text]:
        cells, styles = self._cells()
        texts = []
        for row, label in enumerate(self._labels()):
            line = Text(f"{label:>{_MARGIN - 1}}" + ("┤" if label else "│"))
            for style, run in groupby(zip(cells[row], styles[row], strict=True), key=itemgetter(1)):
                line.append("".join(cell for cell, _ in run), style=style or None)
            line.rstrip()
            texts.append(line)
        return texts

    def _cells(self) -> tuple[list[list[str]], list[list[str]]]:
        width, height = self._plot.width, self._plot.height
        masks = np.zeros((height, width), dtype=int)
        styles = [[""] * width for _ in range(height)]
        for x, y, certain in self._dots():
            masks[y // 4, x // 2] |= _DOTS[x % 2][y % 4]
            if styles[y // 4][x // 2] != _CERTAIN:
                styles[y // 4][x // 2] = _CERTAIN if certain else _UNCERTAIN
        cells = [[chr(_EMPTY + mask) if mask else " " for mask in row] for row in masks.tolist()]
        lowest = self._curve.lowest
        if lowest is not None:
            y = round(self._row(lowest.deviation_dps * self._unit.per_dps)) // 4
            x = round(self._column(lowest.tau_s)) // 2
            cells[y][x], styles[y][x] = _LOWEST_POINT, _MARKED
        return cells, styles

    def _dots(self) -> list[tuple[int, int, bool]]:
        begin, end = round(self._across[0]), round(self._across[-1])
        columns = np.arange(begin, end + 1)
        rows = np.rint(np.interp(columns, self._across, self._up)).astype(int).tolist()
        last = self._column(longest_certain_s(self._curve))
        dots = []
        for place, (x, y) in enumerate(zip(columns.tolist(), rows, strict=True)):
            certain = x <= last
            if not certain and x % 2:
                continue
            before = rows[place - 1] if place and certain else y
            step = 1 if before < y else -1
            dots += [(x, one, certain) for one in range(before + step, y, step)]
            dots.append((x, y, certain))
        return dots

    def _labels(self) -> list[str]:
        labels = [""] * self._plot.height
        for value in self._values.marks():
            row = round(self._row(value)) // 4
            if not any(labels[max(row - 1, 0) : row + 2]):
                labels[row] = f"{value:g}"
        return labels

    def _column(self, tau_s: float) -> float:
        """Return the dot's column; a record that outlasts its plan stays at the edge."""
        last = 2 * self._plot.width - 1
        return min(max(self._axis.position(tau_s), 0.0), 1.0) * last if tau_s > 0.0 else 0.0

    def _row(self, value: float) -> float:
        return (1.0 - self._values.position(value)) * (4 * self._plot.height - 1)


def _time_marks(axis: LogAxis, width: int) -> list[Text]:
    ruler, numbers = ["─"] * width, [" "] * (width + _MARGIN)
    unit = " τ, s"
    numbers[-len(unit) :] = unit
    for value in axis.marks():
        column = round(axis.position(value) * (2 * width - 1)) // 2
        text = f"{value:g}"
        begin = _MARGIN + column - (len(text) - 1) // 2
        around = numbers[begin - 1 : begin + len(text) + 1]
        if len(around) == len(text) + 2 and not "".join(around).strip():
            ruler[column] = "┬"
            numbers[begin : begin + len(text)] = text
    return [Text(f"{'└':>{_MARGIN}}{''.join(ruler)}"), Text("".join(numbers).rstrip())]
