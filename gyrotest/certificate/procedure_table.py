"""A procedure's table as texts: its numbers rounded like those of the results."""

from dataclasses import dataclass

from gyrotest.certificate.numbers import bounded, printed, significant
from gyrotest.records.table import Cell, Column, Table

_LONG = 14


@dataclass(frozen=True, slots=True, kw_only=True)
class TableView:
    """A table whose cells are texts."""

    title: str
    note: str
    columns: tuple[Column, ...]
    rows: tuple[tuple[str, ...], ...]
    sentences: tuple[str, ...]

    @property
    def long(self) -> bool:
        """Whether there are too many rows to keep them on one page."""
        return len(self.rows) > _LONG


def table_view(table: Table) -> TableView:
    """Round the numbers of a table for print."""
    return TableView(
        title=table.title,
        note=table.note,
        columns=table.columns,
        rows=tuple(tuple(_text(cell) for cell in row) for row in table.rows),
        sentences=table.sentences,
    )


def _text(cell: Cell) -> str:
    if cell.value is None:
        return cell.text
    if cell.digits is not None:
        number = significant(cell.value, digits=cell.digits)
        return bounded(number, at_most=cell.at_most, at_least=cell.at_least)
    shown = printed(cell.value, lower=cell.lower_95, upper=cell.upper_95)
    if cell.interval:
        return f"[{shown.lower}, {shown.upper}]"
    return bounded(shown.value, at_most=cell.at_most, at_least=cell.at_least)
