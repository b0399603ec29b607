"""Figures: what a procedure wants drawn, without saying with what."""

from dataclasses import dataclass
from enum import StrEnum

from gyrotest.records.table import Table


class Role(StrEnum):
    """What a curve stands for; the certificate decides how that looks."""

    DATA = "data"
    MEAN = "mean"
    MODEL = "model"
    COMPONENT = "component"
    GUIDE = "guide"
    LIMIT = "limit"
    DATASHEET = "datasheet"
    FLOOR = "floor"


class Scale(StrEnum):
    """An axis's scale."""

    LINEAR = "linear"
    LOG = "log"


class Width(StrEnum):
    """How much of the page's width a figure takes: all, half, two thirds or one third of it.

    Two that follow one another stand side by side if they make up the whole together.
    """

    FULL = "full"
    HALF = "half"
    WIDE = "wide"
    NARROW = "narrow"


@dataclass(frozen=True, slots=True, kw_only=True)
class Curve:
    """Points joined by a line; `label` is written beside the curve (empty: none).

    `series` tells the data of several records apart, from 0.
    """

    x: tuple[float, ...]
    y: tuple[float, ...]
    role: Role = Role.DATA
    label: str = ""
    series: int = 0


@dataclass(frozen=True, slots=True, kw_only=True)
class Band:
    """A shaded band between two curves; `series` as of the curve that it belongs to."""

    x: tuple[float, ...]
    lower: tuple[float, ...]
    upper: tuple[float, ...]
    label: str = ""
    series: int = 0


@dataclass(frozen=True, slots=True, kw_only=True)
class Mark:
    """A read-off point with its text."""

    x: float
    y: float
    label: str


@dataclass(frozen=True, slots=True, kw_only=True)
class Points:
    """Single points with their expanded uncertainties as bars (empty: none); `series` as of curves."""

    x: tuple[float, ...]
    y: tuple[float, ...]
    u: tuple[float, ...] = ()
    label: str = ""
    series: int = 0


@dataclass(frozen=True, slots=True, kw_only=True)
class Bars:
    """A histogram: `edges` has one more entry than `heights`."""

    edges: tuple[float, ...]
    heights: tuple[float, ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class Panel:
    """One pair of axes; with `legend` the names of data curves stand together, each with its line.

    `y_range` are the ends of the y axis, where panels are to be compared (None: as the data ask).
    """

    y_label: str
    x_label: str = ""
    x_scale: Scale = Scale.LINEAR
    y_scale: Scale = Scale.LINEAR
    y_range: tuple[float, float] | None = None
    height: float = 1.0
    curves: tuple[Curve, ...] = ()
    bands: tuple[Band, ...] = ()
    bars: Bars | None = None
    points: tuple[Points, ...] = ()
    marks: tuple[Mark, ...] = ()
    note: str = ""
    legend: bool = False


@dataclass(frozen=True, slots=True, kw_only=True)
class Figure:
    """Panels above one another that share their x axis, with a title, a note beside it and a caption.

    A `table` is printed beneath them; it may stand alone. `axis` is the axis that it shows (empty for
    a single-axis gyro).
    """

    name: str
    axis: str = ""
    title: str
    panels: tuple[Panel, ...]
    note: str = ""
    caption: str = ""
    alt: str = ""
    width: Width = Width.FULL
    table: Table | None = None
