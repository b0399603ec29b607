"""What a figure shows, as matplotlib's artists: panels above one another that share their x axis."""

import math
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.figure import Figure as Paper
from matplotlib.lines import Line2D
from matplotlib.patches import PathPatch
from matplotlib.path import Path

from gyrotest.certificate.axes import fit, lay_scales, write_x_label, write_y_label
from gyrotest.certificate.labels import write_texts
from gyrotest.certificate.legend import legends
from gyrotest.certificate.points import draw_points
from gyrotest.certificate.style import BAND, BAR, POINTS, STROKES, WIDTHS, series_stroke, stroke_of
from gyrotest.records.figure import Band, Bars, Curve, Figure, Panel, Role, Scale

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_LEFT, _RIGHT, _TOP, _BOTTOM = 46.0, 9.0, 4.0, 25.0
_PANEL, _LOG_FACTOR, _BETWEEN = 96.0, 1.95, 9.0
_FLOOR_SHOWN = 4.0  # of a noise floor far below the data, its highest part down to this factor is shown
_BEHIND, _BEFORE = 2.0, 2.5
_MARK = 4.4
_LEVELS = {Role.LIMIT, Role.MEAN, Role.GUIDE, Role.DATASHEET}
_SERIES_BAND = 0.28  # opacity: bands of several records lie over one another


def drawing(figure: Figure) -> Paper:
    """Draw a figure; one dot of the paper is one point."""
    paper, frames = _paper(figure)
    for axes, panel in zip(frames, figure.panels, strict=True):
        lay_scales(axes, figure.panels[0].x_scale, panel.y_scale)
        _draw_panel(axes, panel)
    fit(frames, [x for panel in figure.panels for points in panel.points for x in points.x])
    for axes, panel, entries in zip(frames, figure.panels, legends(figure), strict=True):
        write_y_label(axes, panel.y_label)
        write_texts(axes, panel, entries)
    write_x_label(frames[-1], figure.panels[-1].x_label)
    return paper


def _paper(figure: Figure) -> tuple[Paper, list["Axes"]]:
    """Cut the paper to size, with a frame for each panel."""
    heights = [
        _PANEL * one.height * (_LOG_FACTOR if one.y_scale is Scale.LOG else 1) for one in figure.panels
    ]
    width = WIDTHS[figure.width]
    total = _TOP + sum(heights) + _BETWEEN * (len(heights) - 1) + _BOTTOM
    paper = Paper(figsize=(width / POINTS, total / POINTS), dpi=POINTS)
    grid = {
        "left": _LEFT / width,
        "right": 1 - _RIGHT / width,
        "top": 1 - _TOP / total,
        "bottom": _BOTTOM / total,
        "hspace": _BETWEEN / (sum(heights) / len(heights)),
    }
    frames = paper.subplots(
        len(heights), sharex=True, squeeze=False, height_ratios=heights, gridspec_kw=grid
    )
    return paper, list(frames[:, 0])


def _draw_panel(axes: "Axes", panel: Panel) -> None:
    if panel.y_range is not None:
        axes.set_ylim(*panel.y_range)
    for band in panel.bands:
        _draw_band(axes, band)
    if panel.bars:
        _draw_bars(axes, panel.bars)
    for curve in panel.curves:
        if _is_level(curve, panel):
            axes.axhline(curve.y[0], **_look(curve))
            axes.update_datalim(list(zip(curve.x, curve.y, strict=True)))
        else:
            _draw_curve(axes, curve)
    for points in panel.points:
        draw_points(axes, points)
    for mark in panel.marks:
        axes.plot(
            [mark.x], [mark.y], "o", color=STROKES[Role.DATA].colour, markersize=_MARK, markeredgewidth=0
        )


def _draw_band(axes: "Axes", band: Band) -> None:
    if band.series:
        colour, alpha = series_stroke(band.series).colour, _SERIES_BAND
    else:
        colour, alpha = BAND, None
    axes.fill_between(band.x, band.lower, band.upper, color=colour, alpha=alpha, linewidth=0)


def _draw_bars(axes: "Axes", bars: Bars) -> None:
    """Draw all bars as one shape, standing on the axis."""
    sides = zip(bars.edges[:-1], bars.edges[1:], bars.heights, strict=True)
    corners = [[(x0, 0.0), (x0, y), (x1, y), (x1, 0.0)] for x0, x1, y in sides]
    shape = Path.make_compound_path_from_polys(np.asarray(corners))
    patch = PathPatch(shape, facecolor=BAR, edgecolor="white", linewidth=0.4)
    patch.sticky_edges.y.append(0.0)
    axes.add_patch(patch)


def _draw_curve(axes: "Axes", curve: Curve) -> None:
    line = Line2D(curve.x, curve.y, **_look(curve))
    if curve.role is Role.FLOOR:
        _lay_below(axes, line, curve)
    else:
        axes.add_line(line)


def _is_level(curve: Curve, panel: Panel) -> bool:
    """Whether it holds for the points of its panel, not for a few, so that it runs from frame to frame."""
    places = [x for points in panel.points for x in points.x]
    within = sum(min(curve.x) <= x <= max(curve.x) for x in places) if curve.x else 0
    return curve.role in _LEVELS and len(set(curve.y)) == 1 and 0 < len(places) <= 2 * within


def _look(curve: Curve) -> dict[str, Any]:
    stroke = stroke_of(curve)
    return {
        "color": stroke.colour,
        "linewidth": stroke.width,
        "linestyle": (0, stroke.dashes) if stroke.dashes else "-",
        "zorder": _BEHIND if stroke.behind else _BEFORE,
    }


def _lay_below(axes: "Axes", line: Line2D, curve: Curve) -> None:
    """Draw a noise floor; far below, it may leave the frame: it must not press the data together."""
    axes.add_artist(line)
    shown = max(curve.y, default=math.nan) / _FLOOR_SHOWN
    axes.update_datalim([(x, max(y, shown)) for x, y in zip(curve.x, curve.y, strict=True)])
