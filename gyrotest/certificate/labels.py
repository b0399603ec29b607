"""The texts inside a plot: beside what they name, away from the curves and from each other."""

import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from itertools import zip_longest
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.transforms import Bbox
from numpy.typing import ArrayLike, NDArray

from gyrotest.certificate.legend import Entry, draw_legend, legend_size, size
from gyrotest.certificate.style import FAINT, INK, stroke_of
from gyrotest.records.figure import Mark, Panel, Role

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_GAP = 4.0
_DISTANCES = (4.0, 8.0, 14.0, 20.0, 28.0, 36.0, 46.0)  # of a mark's text, the nearest is tried first
_SPACING = 3.0
_PLACES = 25
_ASIDE = 7  # places for a legend each way
_LEADER = 7.0  # from which distance on a mark is joined to its text
_MARK = 2.5


def write_texts(axes: "Axes", panel: Panel, entries: Sequence[Entry]) -> None:
    """Write the marks' texts, the legend, the names of curves and bands, and the note, where there is room."""
    names = list(_names(axes, panel))
    if not (panel.marks or panel.note or entries or any(name.text for name in names)):
        return
    marks = [axes.transData.transform((mark.x, mark.y)) for mark in panel.marks]
    layout = Layout(
        frame=axes.get_window_extent(),
        ink=np.vstack([np.empty((0, 2)), *(name.line for name in names), *_dots(axes, panel)]),
        taken=[Bbox.from_bounds(x - _MARK, y - _MARK, 2 * _MARK, 2 * _MARK) for x, y in marks],
    )
    for mark, (x, y) in zip(panel.marks, marks, strict=True):
        _write_mark(axes, mark, layout.around(mark.label, x, y), x, y)
    if entries:
        box = layout.aside(*legend_size(entries))
        draw_legend(axes, entries, left=box.x0, top=box.y1)
    for name in names:
        if name.text and len(name.line):
            _write(axes, name.text, layout.along(name.text, name.line), name.colour)
    if panel.note:
        _write(axes, panel.note, layout.corner(panel.note), INK)


@dataclass(frozen=True, slots=True)
class _Name:
    """What is to be written beside a line, and where the line runs on the paper."""

    text: str
    colour: str
    line: NDArray[np.float64]


def _names(axes: "Axes", panel: Panel) -> Iterator[_Name]:
    for curve in panel.curves:
        text = "" if panel.legend and curve.role is Role.DATA else curve.label
        yield _Name(text, stroke_of(curve).colour, _line(axes, curve.x, curve.y))
    for band in panel.bands:
        if band.label or panel.legend:
            yield _Name(band.label, FAINT, _line(axes, band.x, band.upper))
        if panel.legend:
            yield _Name("", FAINT, _line(axes, band.x, band.lower))


def _dots(axes: "Axes", panel: Panel) -> Iterator[NDArray[np.float64]]:
    """Where single points and their bars stand on the paper."""
    for points in panel.points:
        for x, y, u in zip_longest(points.x, points.y, points.u, fillvalue=0.0):
            yield _line(axes, (x, x), (y - u, y + u))


@dataclass(slots=True, kw_only=True)
class Layout:
    """The texts of one plot, placed one after another; `ink` are points (n, 2) along its curves."""

    frame: Bbox
    ink: NDArray[np.float64]
    taken: list[Bbox] = field(default_factory=list)

    def along(self, text: str, line: NDArray[np.float64]) -> Bbox:
        """Place the name of a curve beside it, at its right end rather than at its left."""
        width, height = extent = size(text)
        rows = np.unique(np.linspace(0, len(line) - 1, _PLACES).astype(int))
        places = (
            (left, foot)
            for x, y in line[rows[::-1]]
            for left in (x - width, x - width / 2, x)
            for foot in (y + 1.5, y - height - 1.5)
        )
        return self._best(places, extent)

    def around(self, text: str, x: float, y: float) -> Bbox:
        """Place the text of a mark around its point."""
        width, height = extent = size(text)
        places = (
            (left, foot)
            for away in _DISTANCES
            for left in (x + away, x - width - away, x - width / 2)
            for foot in (y + away, y - height - away, y - height / 2)
        )
        return self._best(places, extent)

    def corner(self, text: str) -> Bbox:
        """Place a note in the emptiest corner."""
        extent = size(text)
        return self._best(self._spread(*extent, 2), extent)

    def aside(self, width: float, height: float) -> Bbox:
        """Place what takes so much room in a corner, or where else there is more room."""
        places = (*self._spread(width, height, 2), *self._spread(width, height, _ASIDE))
        return self._best(places, (width, height))

    def _spread(self, width: float, height: float, count: int) -> list[tuple[float, float]]:
        """Return places evenly over the frame, from the upper right on; two each way are its corners."""
        x0, y0, x1, y1 = self.frame.extents
        rights = np.linspace(x1 - width - _GAP, x0 + _GAP, count)
        return [
            (left, foot) for foot in np.linspace(y1 - height - _GAP, y0 + _GAP, count) for left in rights
        ]

    def _best(self, places: Iterable[tuple[float, float]], extent: tuple[float, float]) -> Bbox:
        """Take the first of the best places, each a lower left corner."""
        low = np.asarray(list(places))
        high = low + extent
        outside = np.any((low < self.frame.min) | (high > self.frame.max), axis=1)
        taken = np.asarray([box.get_points() for box in self.taken]).reshape(-1, 2, 2)
        hidden = _hits(low, high, taken[:, 0], taken[:, 1])
        cost = 1000 * outside + 100 * hidden + _hits(low, high, self.ink, self.ink)
        best = int(cost.argmin())
        self.taken.append(Bbox([low[best], high[best]]))
        return self.taken[-1]


def _hits(
    low: NDArray[np.float64],
    high: NDArray[np.float64],
    others_low: NDArray[np.float64],
    others_high: NDArray[np.float64],
) -> NDArray[np.int64]:
    """Count for each box how many others it touches; a point is a box without extent."""
    across, along = (
        (low[:, k, None] < others_high[:, k]) & (others_low[:, k] < high[:, k, None]) for k in (0, 1)
    )
    return np.asarray(np.count_nonzero(across & along, axis=1))


def dense(line: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return points (n, 2) along a polyline, a few points of paper apart."""
    if len(line) < 2:
        return line
    way = np.concatenate(([0.0], np.cumsum(np.hypot(*np.diff(line, axis=0).T))))
    at = np.linspace(0.0, way[-1], math.ceil(way[-1] / _SPACING) + 1)
    return np.column_stack((np.interp(at, way, line[:, 0]), np.interp(at, way, line[:, 1])))


def _line(axes: "Axes", x: ArrayLike, y: ArrayLike) -> NDArray[np.float64]:
    """Return where a curve runs on the paper, within the frame."""
    points = dense(axes.transData.transform(np.column_stack((x, y))))
    x0, y0, x1, y1 = axes.get_window_extent().extents
    inside = (points[:, 0] >= x0) & (points[:, 0] <= x1) & (points[:, 1] >= y0) & (points[:, 1] <= y1)
    return points[inside]


def _write(axes: "Axes", text: str, box: Bbox, colour: str) -> None:
    axes.annotate(
        text,
        xy=((box.x0 + box.x1) / 2, (box.y0 + box.y1) / 2),
        xycoords="figure points",
        ha="center",
        va="center",
        color=colour,
        bbox={"boxstyle": "square,pad=0.1", "facecolor": "white", "alpha": 0.7, "linewidth": 0},
    )


def _write_mark(axes: "Axes", mark: Mark, box: Bbox, x: float, y: float) -> None:
    """Write the text of a mark, joined to it where that stands away."""
    end = (min(max(x, box.x0), box.x1), min(max(y, box.y0), box.y1))
    if math.dist(end, (x, y)) >= _LEADER:
        leader = {"arrowstyle": "-", "color": FAINT, "linewidth": 0.5, "shrinkA": 0, "shrinkB": 0}
        axes.annotate(
            "",
            xy=(x, y),
            xytext=end,
            xycoords="figure points",
            textcoords="figure points",
            arrowprops=leader,
        )
    _write(axes, mark.label, box, INK)
