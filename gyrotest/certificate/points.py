"""Single points with their uncertainties as bars: told apart by shape and filling, in grey print too."""

from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.lines import Line2D
from numpy.typing import NDArray

from gyrotest.certificate.style import Marker, marker_of
from gyrotest.records.figure import Points

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_BAR_WIDTH, _EDGE = 0.8, 0.9
_BARS, _MARKERS = 2.6, 2.7  # layers: above the curves


def draw_points(axes: "Axes", points: Points) -> None:
    """Draw markers, each with its expanded uncertainty up and down."""
    marker = marker_of(points.series)
    if points.u:
        axes.add_line(Line2D(*bars(points), color=marker.colour, linewidth=_BAR_WIDTH, zorder=_BARS))
    axes.add_line(marker_line(points.x, points.y, marker, zorder=_MARKERS))


def marker_line(
    x: tuple[float, ...], y: tuple[float, ...], marker: Marker, *, zorder: float, **more: Any
) -> Line2D:
    """Return markers without a line between them."""
    return Line2D(
        x,
        y,
        linestyle="none",
        marker=marker.shape,
        markersize=marker.size,
        markerfacecolor=marker.colour if marker.filled else "none",
        markeredgecolor=marker.colour,
        markeredgewidth=_EDGE,
        zorder=zorder,
        **more,
    )


def bars(points: Points) -> NDArray[np.float64]:
    """Return the bars of uncertainty as one broken line (2, 3n): x and y of each bar's ends and a break."""
    x, y, u = (np.asarray(one, dtype=float) for one in (points.x, points.y, points.u))
    broken = np.column_stack((y - u, y + u, np.full(len(y), np.nan)))
    return np.stack((np.repeat(x, 3), broken.ravel()))
