"""How figures look: sizes, colours, the lines of the roles; the same whatever a user set matplotlib to."""

import functools
import logging
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from gyrotest.records.figure import Curve, Role, Width

POINTS = 72  # of an inch; matplotlib sizes paper in inches
FONT_SIZE = 6.6
WIDTHS = {Width.FULL: 510.0, Width.HALF: 246.0, Width.WIDE: 333.0, Width.NARROW: 159.0}
INK, FAINT, FRAME, GRID, MINOR_GRID = "#2b3440", "#5d6773", "#8a949e", "#d5dbe1", "#e9edf1"
BAND, BAR = "#bccddd", "#86a6c3"

_SETTINGS: dict[Any, Any] = {
    # Text stays text, in the certificate's own font; nothing in a file depends on chance.
    "svg.fonttype": "none",
    "svg.hashsalt": "gyrotest",
    "pdf.fonttype": 3,  # the glyphs that occur: cutting a font of type 42 to size takes half a second
    "font.family": ["Inter", "DejaVu Sans"],
    "font.size": FONT_SIZE,
    "text.parse_math": False,
    "text.color": INK,
    "figure.facecolor": "none",  # what lies behind a figure, as a watermark, shows through
    "axes.facecolor": "none",
    "axes.labelsize": FONT_SIZE,
    "axes.labelcolor": INK,
    "axes.labelpad": 2.5,
    "axes.edgecolor": FRAME,
    "axes.linewidth": 0.6,
    "lines.scale_dashes": False,
    "lines.dash_capstyle": "butt",
    "xtick.bottom": False,
    "ytick.left": False,
    **{f"{axis}tick.major.size": 0.0 for axis in "xy"},
    **{f"{axis}tick.labelsize": FONT_SIZE for axis in "xy"},
    **{f"{axis}tick.labelcolor": FAINT for axis in "xy"},
}


@dataclass(frozen=True, slots=True)
class Stroke:
    """How a curve is drawn; the dashes are lengths in points, ink and gap in turn."""

    colour: str
    width: float
    dashes: tuple[float, ...] = ()
    behind: bool = False


STROKES = {
    Role.DATA: Stroke("#1f4e79", 1.1),
    Role.MEAN: Stroke("#12304f", 0.8),
    Role.MODEL: Stroke("#946200", 1.1),
    Role.COMPONENT: Stroke("#946200", 0.55),
    Role.GUIDE: Stroke("#946200", 0.9, (1, 1.8)),
    Role.LIMIT: Stroke("#c1272d", 1.0, (4.5, 2.2), behind=True),
    Role.DATASHEET: Stroke("#6a4c93", 0.9, (6, 1.8, 1.2, 1.8), behind=True),
    Role.FLOOR: Stroke("#7d8791", 0.9, behind=True),
}

# Data of several records: told apart by colour and, in print, by dashes.
SERIES = (
    STROKES[Role.DATA],
    Stroke("#b3541e", 1.1, (5, 1.4)),
    Stroke("#2b7a55", 1.1, (2.4, 1.2)),
    Stroke("#8a3a76", 1.1, (7, 1.4, 1.6, 1.4)),
    Stroke("#3d8fb5", 1.1),
    Stroke("#7a6a1f", 1.1, (1.4, 1.2)),
)


@dataclass(frozen=True, slots=True)
class Marker:
    """How single points are drawn: a shape, full or hollow, so that they are told apart in grey."""

    shape: str
    size: float
    colour: str
    filled: bool = True


_SHAPES = (("o", 3.6, True), ("s", 5.0, False), ("^", 4.4, True), ("D", 4.6, False), ("v", 4.4, True))


def stroke_of(curve: Curve) -> Stroke:
    """Return how a curve is drawn."""
    return series_stroke(curve.series) if curve.role is Role.DATA else STROKES[curve.role]


def series_stroke(series: int) -> Stroke:
    """Return how the data of one of several records are drawn."""
    return SERIES[series % len(SERIES)]


def marker_of(series: int) -> Marker:
    """Return how the points of one of several series are drawn; their colours are those of the lines."""
    shape, size, filled = _SHAPES[series % len(_SHAPES)]
    return Marker(shape, size, series_stroke(series).colour, filled)


@contextmanager
def styled() -> Iterator[None]:
    """Let matplotlib draw in this style; what it was set to before comes back afterwards."""
    with _silent_log():
        import matplotlib

        _add_fonts()
    defaults: dict[Any, Any] = {
        name: value for name, value in matplotlib.rcParamsDefault.items() if name != "backend"
    }
    with matplotlib.rc_context(), warnings.catch_warnings():
        # A sign that the fonts lack, or nothing positive on a logarithmic axis, is no fault of a test.
        warnings.simplefilter("ignore", UserWarning)
        matplotlib.rcParams.update(defaults)
        matplotlib.rcParams.update(_SETTINGS)
        yield


@functools.cache
def _add_fonts() -> None:
    from matplotlib.font_manager import fontManager

    for place in sorted(Path(__file__).with_name("fonts").glob("*.ttf")):
        fontManager.addfont(place)


@contextmanager
def _silent_log() -> Iterator[None]:
    """Keep to itself what matplotlib has to say of a home folder that cannot be written."""
    log = logging.getLogger("matplotlib")
    level = log.level
    log.setLevel(logging.ERROR)
    try:
        yield
    finally:
        log.setLevel(level)
