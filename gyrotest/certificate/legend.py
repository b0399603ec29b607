"""A legend: the names of curves and points under one another, each behind a piece of what it names."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from matplotlib.font_manager import FontProperties
from matplotlib.lines import Line2D
from matplotlib.textpath import text_to_path
from matplotlib.transforms import Affine2D

from gyrotest.certificate.points import marker_line
from gyrotest.certificate.style import FONT_SIZE, INK, POINTS, Marker, Stroke, marker_of, stroke_of
from gyrotest.records.figure import Figure, Panel, Role

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_HEIGHT = 1.25  # of a line of text, in font sizes
_GAP = 4.0
_SAMPLE = 18.0  # of a line
_LAYER = 3.0


@dataclass(frozen=True, slots=True)
class Entry:
    """A name, and the line or the marker before it."""

    text: str
    sample: Stroke | Marker


def legends(figure: Figure) -> tuple[tuple[Entry, ...], ...]:
    """Return what the legend of each panel names: points always, data curves where it asks for that.

    What a panel above has named is not named again.
    """
    named: list[tuple[Entry, ...]] = []
    for panel in figure.panels:
        above = {entry for entries in named for entry in entries}
        named.append(tuple(one for one in _entries(panel) if one not in above))
    return tuple(named)


def _entries(panel: Panel) -> Iterator[Entry]:
    for curve in panel.curves:
        if curve.role is Role.DATA and curve.label and panel.legend:
            yield Entry(curve.label, stroke_of(curve))
    for points in panel.points:
        if points.label:
            yield Entry(points.label, marker_of(points.series))


def legend_size(entries: Sequence[Entry]) -> tuple[float, float]:
    """Return the width and the height of a legend, in points."""
    return _SAMPLE + _GAP + max(size(one.text)[0] for one in entries), size("")[1] * len(entries)


def draw_legend(axes: "Axes", entries: Sequence[Entry], *, left: float, top: float) -> None:
    """Draw a legend from its upper left corner down, in points of the paper."""
    height = size("")[1]
    for row, entry in enumerate(entries):
        middle = top - (row + 0.5) * height
        axes.add_artist(_sample(axes, entry.sample, left, middle))
        place = (left + _SAMPLE + _GAP, middle)
        axes.annotate(entry.text, xy=place, xycoords="figure points", va="center", color=INK)


def size(text: str) -> tuple[float, float]:
    """The width and the height that a text takes, in points."""
    font = FontProperties(size=FONT_SIZE)
    width, _, _ = text_to_path.get_text_width_height_descent(text, font, ismath=False)
    return width + 2, _HEIGHT * FONT_SIZE


def _sample(axes: "Axes", sample: Stroke | Marker, x: float, y: float) -> Line2D:
    paper = Affine2D().scale(1 / POINTS) + axes.figure.dpi_scale_trans
    if isinstance(sample, Marker):
        return marker_line((x + _SAMPLE / 2,), (y,), sample, zorder=_LAYER, transform=paper)
    return Line2D(
        (x, x + _SAMPLE),
        (y, y),
        transform=paper,
        color=sample.colour,
        linewidth=sample.width,
        linestyle=(0, sample.dashes) if sample.dashes else "-",
    )
