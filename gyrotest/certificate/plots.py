"""Figures as SVG: roles become styles, labels stand beside what they name.

Written out directly: a general plotting library needs longer for its import and a dozen figures
than all the rest of a certificate, and text stays text here, in the certificate's own font.
"""

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from html import escape

import numpy as np
from numpy.typing import ArrayLike, NDArray

from gyrotest.certificate.axes import Axis, axis, times_ten
from gyrotest.certificate.labels import Box, Layout, dense
from gyrotest.records.figure import Band, Bars, Curve, Figure, Panel, Role, Scale, Width

_WIDTHS = {Width.FULL: 510.0, Width.HALF: 246.0}
_LEFT, _RIGHT, _TOP = 46.0, 9.0, 4.0
_PANEL, _LOG_FACTOR, _BETWEEN = 96.0, 1.95, 9.0
_FLOOR_SHOWN = 4.0  # of a noise floor far below the data, its highest part down to this factor is shown
_TICK_LABELS, _AXIS_LABEL = 12.0, 13.0
_FONT = 6.6
_INK, _FAINT, _FRAME, _GRID, _MINOR = "#2b3440", "#5d6773", "#8a949e", "#d5dbe1", "#e9edf1"
_BAND, _BAR = "#bccddd", "#86a6c3"
_STYLES = {
    Role.DATA: ("#1f4e79", "1.1", ""),
    Role.MEAN: ("#12304f", "0.8", ""),
    Role.MODEL: ("#946200", "1.1", ""),
    Role.GUIDE: ("#946200", "0.9", "1 1.8"),
    Role.LIMIT: ("#c1272d", "1", "4.5 2.2"),
    Role.DATASHEET: ("#6a4c93", "0.9", "6 1.8 1.2 1.8"),
    Role.FLOOR: ("#7d8791", "0.9", ""),
}
_BEHIND = (Role.FLOOR, Role.DATASHEET, Role.LIMIT)


@dataclass(frozen=True, slots=True)
class _Line:
    """A curve and where it lies on the paper."""

    curve: Curve
    x: NDArray[np.float64]
    y: NDArray[np.float64]


def svg(figure: Figure) -> str:
    """Draw a figure; its size is in points."""
    width = _WIDTHS[figure.width]
    heights = [
        _PANEL * one.height * (_LOG_FACTOR if one.y_scale is Scale.LOG else 1) for one in figure.panels
    ]
    total = _TOP + sum(heights) + _BETWEEN * (len(heights) - 1) + _TICK_LABELS + _AXIS_LABEL
    x_axis = axis(
        (value for panel in figure.panels for value in _x_values(panel)),
        figure.panels[0].x_scale,
        begin=_LEFT,
        end=width - _RIGHT,
        tight=True,
    )
    parts: list[str] = []
    top = _TOP
    for panel, height in zip(figure.panels, heights, strict=True):
        frame = Box(left=_LEFT, top=top, width=width - _LEFT - _RIGHT, height=height)
        parts += _panel(panel, x_axis, frame)
        top += height + _BETWEEN
    parts += _x_labels(x_axis, figure.panels[-1].x_label, top - _BETWEEN)
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{width:g}pt" height="{total:g}pt" '
        f'viewBox="0 0 {width:g} {total:g}" font-family="Inter" font-size="{_FONT}">'
        f"{''.join(parts)}</svg>"
    )


def _x_values(panel: Panel) -> Iterator[float]:
    yield from (value for curve in panel.curves for value in curve.x)
    yield from (value for band in panel.bands for value in band.x)
    if panel.bars:
        yield from panel.bars.edges
    yield from (mark.x for mark in panel.marks)


def _y_values(panel: Panel) -> Iterator[float]:
    for curve in panel.curves:
        if curve.role is not Role.FLOOR:
            yield from curve.y
        elif curve.y:
            # A floor far below may leave the frame; it must not press the data together.
            yield from (max(value, max(curve.y) / _FLOOR_SHOWN) for value in curve.y)
    for band in panel.bands:
        yield from band.lower
        yield from band.upper
    if panel.bars:
        yield from panel.bars.heights
        yield 0.0
    yield from (mark.y for mark in panel.marks)


def _panel(panel: Panel, x: Axis, frame: Box) -> Iterator[str]:
    y = axis(_y_values(panel), panel.y_scale, begin=frame.top + frame.height, end=frame.top, tight=False)
    layout = Layout(frame, _FONT)
    yield from _grid(x, y, frame)
    for band in panel.bands:
        yield _band(band, x, y)
    if panel.bars:
        yield _bars(panel.bars, x, y)
    lines = [_Line(curve, *_placed(curve, x, y)) for curve in panel.curves if curve.x]
    for line in sorted(lines, key=lambda one: one.curve.role not in _BEHIND):
        yield _drawn(line)
        layout.avoid(line.x, line.y)
    yield (
        f'<rect x="{frame.left:g}" y="{frame.top:.1f}" width="{frame.width:g}" height="{frame.height:.1f}" '
        f'fill="none" stroke="{_FRAME}" stroke-width="0.6"/>'
    )
    yield from _texts(panel, lines, x, y, layout)
    yield from _y_labels(y, panel.y_label, frame)


def _placed(curve: Curve, x: Axis, y: Axis) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Place a curve on the paper; of a noise floor, what lies below the frame is cut off."""
    if curve.role is not Role.FLOOR:
        return x.place(curve.x), y.place(curve.y)
    positive = [(one, value) for one, value in zip(curve.x, curve.y, strict=True) if value > 0]
    points = dense(x.place([one for one, _ in positive]), y.run([value for _, value in positive]))
    kept = points[points[:, 1] <= y.begin]
    return kept[:, 0], kept[:, 1]


def _texts(panel: Panel, lines: list[_Line], x: Axis, y: Axis, layout: Layout) -> Iterator[str]:
    """Write the marks, the curves' names and the note, each where there is room left."""
    for mark in panel.marks:
        left, top = float(x.place(mark.x)), float(y.place(mark.y))
        layout.taken.append(Box(left=left - 2.5, top=top - 2.5, width=5, height=5))
        yield f'<circle cx="{left:.1f}" cy="{top:.1f}" r="2.2" fill="{_STYLES[Role.DATA][0]}"/>'
        box = layout.around(mark.label, left, top)
        yield _leader(left, top, box) + _label(mark.label, box, _INK)
    for line in lines:
        if line.curve.label and len(line.x):
            box = layout.along(line.curve.label, line.x, line.y)
            yield _label(line.curve.label, box, _STYLES[line.curve.role][0])
    for band in panel.bands:
        if band.label and band.x:
            box = layout.along(band.label, x.place(band.x), y.place(band.upper))
            yield _label(band.label, box, _FAINT)
    if panel.note:
        yield _label(panel.note, layout.corner(panel.note), _INK)


def _grid(x: Axis, y: Axis, frame: Box) -> Iterator[str]:
    def across(value: float) -> str:
        return f"M{x.place(value):.1f} {frame.top:.1f}v{frame.height:.1f}"

    def along(value: float) -> str:
        return f"M{frame.left:g} {y.place(value):.1f}h{frame.width:g}"

    yield _lines(x.minor, across, _MINOR) + _lines(y.minor, along, _MINOR)
    yield _lines([tick.value for tick in x.ticks], across, _GRID)
    yield _lines([tick.value for tick in y.ticks], along, _GRID)


def _lines(values: ArrayLike, drawn: Callable[[float], str], colour: str) -> str:
    path = "".join(drawn(value) for value in np.asarray(values, dtype=np.float64))
    return f'<path d="{path}" stroke="{colour}" stroke-width="0.45" fill="none"/>' if path else ""


def _band(band: Band, x: Axis, y: Axis) -> str:
    if not band.x:
        return ""
    left = x.place(band.x)
    outline = np.concatenate((left, left[::-1]))
    edge = np.concatenate((y.place(band.upper), y.place(band.lower)[::-1]))
    return f'<path d="{_path(outline, edge)}Z" fill="{_BAND}" stroke="none"/>'


def _bars(bars: Bars, x: Axis, y: Axis) -> str:
    left, top, foot = x.place(bars.edges), y.place(bars.heights), float(y.place(0.0))
    path = "".join(
        f"M{begin:.1f} {foot:.1f}V{high:.1f}H{end:.1f}V{foot:.1f}Z"
        for begin, end, high in zip(left[:-1], left[1:], top, strict=True)
    )
    return f'<path d="{path}" fill="{_BAR}" stroke="#ffffff" stroke-width="0.4"/>'


def _drawn(line: _Line) -> str:
    if not len(line.x):
        return ""
    colour, width, dashes = _STYLES[line.curve.role]
    dashed = f' stroke-dasharray="{dashes}"' if dashes else ""
    return (
        f'<path d="{_path(line.x, line.y)}" fill="none" stroke="{colour}" '
        f'stroke-width="{width}" stroke-linejoin="round"{dashed}/>'
    )


def _path(x: NDArray[np.float64], y: NDArray[np.float64]) -> str:
    return "M" + "L".join(f"{left:.1f} {top:.1f}" for left, top in zip(x, y, strict=True))


def _y_labels(y: Axis, label: str, frame: Box) -> Iterator[str]:
    for tick in y.ticks:
        top = float(y.place(tick.value)) + _FONT * 0.36
        yield _text(tick.label, frame.left - 4, top, anchor="end", colour=_FAINT)
    middle = frame.top + frame.height / 2
    yield (
        f'<text x="0" y="0" transform="translate(9 {middle:.1f}) rotate(-90)" text-anchor="middle" '
        f'fill="{_INK}">{escape(_scaled(label, y))}</text>'
    )


def _x_labels(x: Axis, label: str, bottom: float) -> Iterator[str]:
    for tick in x.ticks:
        left = float(x.place(tick.value))
        yield _text(tick.label, left, bottom + 9, anchor="middle", colour=_FAINT)
    yield _text(_scaled(label, x), (x.begin + x.end) / 2, bottom + 20, anchor="middle", colour=_INK)


def _scaled(label: str, drawn: Axis) -> str:
    """The label of an axis whose numbers are to be read with a factor."""
    return f"{label}, × {times_ten(drawn.exponent)}" if drawn.exponent else label


def _leader(x: float, y: float, box: Box) -> str:
    """Join a mark to its text where that stands away from it."""
    end_x = min(max(x, box.left), box.left + box.width)
    end_y = min(max(y, box.top), box.top + box.height)
    if math.hypot(end_x - x, end_y - y) < 7:
        return ""
    return f'<path d="M{x:.1f} {y:.1f}L{end_x:.1f} {end_y:.1f}" stroke="{_FAINT}" stroke-width="0.5"/>'


def _label(text: str, box: Box, colour: str) -> str:
    return (
        f'<rect x="{box.left:.1f}" y="{box.top:.1f}" width="{box.width:.1f}" height="{box.height:.1f}" '
        f'fill="#ffffff" fill-opacity="0.7"/>'
    ) + _text(
        text, box.left + box.width / 2, box.top + box.height * 0.76, anchor="middle", colour=colour
    )


def _text(text: str, x: float, y: float, *, anchor: str, colour: str) -> str:
    return f'<text x="{x:.1f}" y="{y:.1f}" text-anchor="{anchor}" fill="{colour}">{escape(text)}</text>'
