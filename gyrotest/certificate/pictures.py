"""The figures of a run as images with their captions and tables, laid out in rows."""

from collections.abc import Iterator
from dataclasses import dataclass, replace

from gyrotest.certificate.figures import svg
from gyrotest.certificate.gauge import image_source
from gyrotest.certificate.order import axes_of
from gyrotest.certificate.procedure_table import TableView, table_view
from gyrotest.certificate.style import POINTS, WIDTHS
from gyrotest.records.figure import Figure, Width
from gyrotest.records.run import ItemRecord, RunRecord

_MM = 25.4 / POINTS  # a point of paper
_SHARES = {Width.FULL: 6, Width.WIDE: 4, Width.HALF: 3, Width.NARROW: 2}
_WHOLE = 6


@dataclass(frozen=True, slots=True, kw_only=True)
class Picture:
    """A figure that is drawn (no source: a table alone); `width` in mm."""

    number: int
    width: float
    title: str
    note: str
    caption: str
    alt: str
    source: str
    table: TableView | None


@dataclass(frozen=True, slots=True, kw_only=True)
class PictureGroup:
    """The figures of one acquisition and axis; each row holds one figure, or those that fill it side by side."""

    heading: str
    rows: tuple[tuple[Picture, ...], ...]


def picture_groups(record: RunRecord) -> tuple[PictureGroup, ...]:
    """Draw the figures of every item that counts."""
    return tuple(_groups(record))


def _groups(record: RunRecord) -> Iterator[PictureGroup]:
    number = 0
    axes = axes_of(record)
    for item in record.items:
        figures = item.last.figures if item.last else ()
        for axis in axes:
            rows: list[tuple[Picture, ...]] = []
            for row in _in_rows(tuple(one for one in figures if one.axis == axis)):
                pictures = []
                for figure in row:
                    number += bool(figure.panels)  # a table alone is no figure
                    pictures.append(_picture(figure, number))
                rows.append(tuple(pictures))
            if rows:
                yield PictureGroup(heading=_heading(record, item, axis), rows=tuple(rows))


def _heading(record: RunRecord, item: ItemRecord, axis: str) -> str:
    repeats = [
        one.plan.repeat for one in record.items if one.plan.case == item.plan.case and one.plan.repeat
    ]
    parts = [item.plan.case]
    if item.plan.repeat is None:
        parts.append("over the repeats")
    elif len(repeats) > 1:
        parts.append(f"repeat {item.plan.repeat} of {max(repeats)}")
    return ", ".join((*parts, f"axis {axis}") if axis else parts)


def _picture(figure: Figure, number: int) -> Picture:
    return Picture(
        number=number,
        width=WIDTHS[figure.width] * _MM,
        title=figure.title,
        note=figure.note,
        caption=figure.caption,
        alt=figure.alt or figure.title,
        source=image_source(svg(figure)) if figure.panels else "",
        table=None if figure.table is None else table_view(figure.table),
    )


def _in_rows(figures: tuple[Figure, ...]) -> Iterator[tuple[Figure, ...]]:
    """Put parts of a width that follow one another side by side, in rows that they fill."""
    waiting: list[Figure] = []
    for figure in figures:
        if sum(_SHARES[one.width] for one in (*waiting, figure)) > _WHOLE:
            yield from _stretched(waiting)
            waiting = []
        waiting.append(figure)
        if sum(_SHARES[one.width] for one in waiting) == _WHOLE:
            yield tuple(waiting)
            waiting = []
    yield from _stretched(waiting)


def _stretched(waiting: list[Figure]) -> Iterator[tuple[Figure, ...]]:
    """Let figures that do not fill a row take a half each where they are two alike, else the whole."""
    if len(waiting) == 2 and waiting[0].width is waiting[1].width:
        yield tuple(replace(one, width=Width.HALF) for one in waiting)
    else:
        yield from ((replace(one, width=Width.FULL),) for one in waiting)
