"""Figures: what a procedure wants drawn, without saying with what."""

from dataclasses import dataclass
from enum import StrEnum


class Role(StrEnum):
    """What a curve stands for; the certificate decides how that looks."""

    DATA = "data"
    MEAN = "mean"
    MODEL = "model"
    GUIDE = "guide"
    LIMIT = "limit"
    DATASHEET = "datasheet"
    FLOOR = "floor"


class Scale(StrEnum):
    """An axis's scale."""

    LINEAR = "linear"
    LOG = "log"


class Width(StrEnum):
    """Whether a figure takes the page's width or half of it."""

    FULL = "full"
    HALF = "half"


@dataclass(frozen=True, slots=True, kw_only=True)
class Curve:
    """Points joined by a line; `label` is written beside the curve (empty: none)."""

    x: tuple[float, ...]
    y: tuple[float, ...]
    role: Role = Role.DATA
    label: str = ""


@dataclass(frozen=True, slots=True, kw_only=True)
class Band:
    """A shaded band between two curves."""

    x: tuple[float, ...]
    lower: tuple[float, ...]
    upper: tuple[float, ...]
    label: str = ""


@dataclass(frozen=True, slots=True, kw_only=True)
class Mark:
    """A read-off point with its text."""

    x: float
    y: float
    label: str


@dataclass(frozen=True, slots=True, kw_only=True)
class Bars:
    """A histogram: `edges` has one more entry than `heights`."""

    edges: tuple[float, ...]
    heights: tuple[float, ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class Panel:
    """One pair of axes."""

    y_label: str
    x_label: str = ""
    x_scale: Scale = Scale.LINEAR
    y_scale: Scale = Scale.LINEAR
    height: float = 1.0
    curves: tuple[Curve, ...] = ()
    bands: tuple[Band, ...] = ()
    bars: Bars | None = None
    marks: tuple[Mark, ...] = ()
    note: str = ""


@dataclass(frozen=True, slots=True, kw_only=True)
class Figure:
    """Panels above one another that share their x axis, with a title, a note beside it and a caption."""

    name: str
    title: str
    panels: tuple[Panel, ...]
    note: str = ""
    caption: str = ""
    alt: str = ""
    width: Width = Width.FULL
