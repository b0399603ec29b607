"""Axes: the range that a panel shows, its ticks with their numbers, and its labels."""

import math
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.lines import Line2D
from matplotlib.ticker import AutoLocator, LogLocator, MaxNLocator, NullLocator, ScalarFormatter
from matplotlib.transforms import blended_transform_factory
from numpy.typing import ArrayLike

from gyrotest.certificate.numbers import MINUS, plain
from gyrotest.certificate.style import GRID, MINOR_GRID, POINTS
from gyrotest.records.figure import Scale

if TYPE_CHECKING:
    from collections.abc import Sequence

    from matplotlib.axes import Axes
    from matplotlib.axis import Axis

_SUPERSCRIPTS = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")
_MARGIN, _LOG_MARGIN = 0.05, 0.03
_CLEAR = 0.04  # of the width, between a single point and the frame
_NEARLY = 0.015
_FEW_DECADES = 2.2  # up to which ticks within a decade get numbers as well
_DEEPEST = 1e15  # how far down a logarithmic axis reaches
_POWERS = (-3, 5)  # of ten, from which on numbers share a factor
_GRID_WIDTH, _GRID_LAYER = 0.45, 0.5
_LABEL_LEFT = 7.0


def lay_scales(axes: "Axes", x: Scale, y: Scale) -> None:
    """Make the axes linear or logarithmic."""
    axes.set(xscale=x.value, yscale=y.value)
    axes.margins(x=_LOG_MARGIN if x is Scale.LOG else 0.0, y=_LOG_MARGIN if y is Scale.LOG else _MARGIN)


def fit(frames: "Sequence[Axes]", dots: "Sequence[float]" = ()) -> None:
    """Let the axes show all that was drawn, and lay their ticks; `dots` are the places of single points.

    Where all of these are whole numbers, as those of power cycles are, so are the ticks.
    """
    for axes in frames:
        axes.autoscale_view()
        _cut_decades(axes)
    _reach_ticks(frames[-1])
    _keep_clear(frames[-1], dots)
    counted = bool(dots) and all(float(one).is_integer() for one in dots)
    for axes in frames:
        for axis in (axes.xaxis, axes.yaxis):
            _lay_ticks(axis, counted=counted and axis is axes.xaxis)
            _rule(axes, axis)


def write_y_label(axes: "Axes", label: str) -> None:
    """Write what the y axis shows, at the paper's edge."""
    edge = blended_transform_factory(axes.figure.dpi_scale_trans, axes.transAxes)
    axes.yaxis.set_label_coords(_LABEL_LEFT / POINTS, 0.5, transform=edge)
    axes.set_ylabel(_scaled(axes.yaxis, label), va="center")


def write_x_label(axes: "Axes", label: str) -> None:
    """Write what the shared x axis shows."""
    axes.set_xlabel(_scaled(axes.xaxis, label))


def log_label(value: float, _: object = None) -> str:
    """The number at a tick of a logarithmic axis."""
    power = math.floor(math.log10(value) + 1e-9)
    if -4 < power <= 5:
        return plain(float(value), digits=6)
    digits = plain(float(value / 10.0**power), digits=3)
    return times_ten(power) if digits == "1" else f"{digits}·{times_ten(power)}"


def times_ten(exponent: int) -> str:
    """A power of ten in print."""
    return f"10{str(exponent).translate(_SUPERSCRIPTS)}"


def _cut_decades(axes: "Axes") -> None:
    """Keep a value of nearly nothing from taking all of a logarithmic axis."""
    if axes.get_xscale() == "log":
        axes.set_xlim(_cut(axes.get_xlim(), axes.dataLim.x1))
    if axes.get_yscale() == "log":
        axes.set_ylim(_cut(axes.get_ylim(), axes.dataLim.y1))


def _cut(limits: tuple[float, float], largest: float) -> tuple[float, float]:
    deepest = largest / _DEEPEST
    return limits if limits[0] >= deepest else (deepest, 2 * largest)


def _reach_ticks(axes: "Axes") -> None:
    """Let a linear x axis that nearly reaches a tick end with it."""
    if axes.get_xscale() != "linear":
        return
    ends = np.asarray(axes.get_xlim())
    ticks = np.asarray(axes.xaxis.get_major_locator().tick_values(*ends))
    nearest = ticks[np.abs(ticks[:, None] - ends).argmin(axis=0)]
    near = np.abs(nearest - ends) < _NEARLY * np.ptp(ends)
    axes.set_xlim(*np.where(near, nearest, ends))


def _keep_clear(axes: "Axes", dots: "Sequence[float]") -> None:
    """Let single points stand off from the frame's sides."""
    if not dots or axes.get_xscale() != "linear":
        return
    low, high = axes.get_xlim()
    aside = _CLEAR * (high - low)
    axes.set_xlim(min(low, min(dots) - aside), max(high, max(dots) + aside))


def _lay_ticks(axis: "Axis", *, counted: bool) -> None:
    if axis.get_scale() == "log":
        _lay_log_ticks(axis)
    else:
        axis.set_major_locator(_whole_numbers() if counted else AutoLocator())
        formatter = ScalarFormatter(useOffset=False)
        formatter.set_powerlimits(_POWERS)
        axis.set_major_formatter(formatter)
        axis.offsetText.set_visible(False)  # the label says the factor


def _whole_numbers() -> MaxNLocator:
    return MaxNLocator(nbins="auto", integer=True, steps=[1, 2, 5, 10], min_n_ticks=1)


def _lay_log_ticks(axis: "Axis") -> None:
    low, high = axis.get_view_interval()
    numbered = (1, 2, 5) if math.log10(high / low) <= _FEW_DECADES else (1,)
    axis.set_major_locator(LogLocator(subs=numbered))
    axis.set_major_formatter(log_label)
    axis.set_minor_locator(NullLocator())


def _rule(axes: "Axes", axis: "Axis") -> None:
    """Draw the grid, as two shapes: a tick of its own for each line of it would be slow."""
    if axis.get_scale() == "log":
        fine = LogLocator(subs=range(2, 10))
        fine.set_axis(axis)
        _rule_at(axes, axis, fine(), MINOR_GRID)
    _rule_at(axes, axis, axis.get_majorticklocs(), GRID)


def _rule_at(axes: "Axes", axis: "Axis", places: ArrayLike, colour: str) -> None:
    low, high = axis.get_view_interval()
    kept = [place for place in np.asarray(places) if low <= place <= high]
    upright = axis is axes.xaxis
    along, across = np.repeat(kept, 3), np.tile((0.0, 1.0, np.nan), len(kept))
    line = Line2D(
        *((along, across) if upright else (across, along)),
        transform=axes.get_xaxis_transform() if upright else axes.get_yaxis_transform(),
        color=colour,
        linewidth=_GRID_WIDTH,
        zorder=_GRID_LAYER,
    )
    axes.add_artist(line)


def _scaled(axis: "Axis", label: str) -> str:
    """The label of an axis whose numbers are to be read with a factor."""
    formatter = axis.get_major_formatter()
    if not isinstance(formatter, ScalarFormatter):
        return label
    formatter.set_locs(axis.get_majorticklocs().tolist())
    factor = formatter.get_offset().replace(MINUS, "-").partition("e")[2]
    return f"{label}, × {times_ten(int(factor))}" if factor else label
