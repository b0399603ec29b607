"""The figures of a run as images with their captions and tables, laid out in rows."""

from collections.abc import Iterator
from dataclasses import dataclass, replace

from gyrotest.certificate.figures import svg
from gyrotest.certificate.gauge import image_source
from gyrotest.certificate.procedure_table import TableView, table_view
from gyrotest.certificate.style import POINTS, WIDTHS
from gyrotest.records.figure import Figure, Width
from gyrotest.records.run import ItemRecord, RunRecord

_MM = 25.4 / POINTS  # a point of paper
_BESIDE = {Width.HALF: Width.HALF, Width.WIDE: Width.NARROW, Width.NARROW: Width.WIDE}


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
    """The figures of one acquisition; each row holds one figure, or two side by side."""

    heading: str
    rows: tuple[tuple[Picture, ...], ...]


def picture_groups(record: RunRecord) -> tuple[PictureGroup, ...]:
    """Draw the figures of every item that counts."""
    return tuple(_groups(record))


def _groups(record: RunRecord) -> Iterator[PictureGroup]:
    number = 0
    for item in record.items:
        if item.last is None or not item.last.figures:
            continue
        rows = []
        for row in _in_rows(item.last.figures):
            rows.append(tuple(_picture(figure, number + n) for n, figure in enumerate(row, start=1)))
            number += len(row)
        yield PictureGroup(heading=_heading(record, item), rows=tuple(rows))


def _heading(record: RunRecord, item: ItemRecord) -> str:
    repeats = [
        one.plan.repeat for one in record.items if one.plan.case == item.plan.case and one.plan.repeat
    ]
    if item.plan.repeat is None:
        return f"{item.plan.case}, over the repeats"
    if len(repeats) < 2:
        return item.plan.case
    return f"{item.plan.case}, repeat {item.plan.repeat} of {max(repeats)}"


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
    """Put parts of a width that follow one another side by side; one alone takes the whole width."""
    waiting: Figure | None = None
    for figure in figures:
        if waiting is not None and _BESIDE[waiting.width] is figure.width:
            yield (waiting, figure)
            waiting = None
            continue
        if waiting is not None:
            yield (replace(waiting, width=Width.FULL),)
            waiting = None
        if figure.width in _BESIDE:
            waiting = figure
        else:
            yield (figure,)
    if waiting is not None:
        yield (replace(waiting, width=Width.FULL),)
