"""Figures in rows side by side, and tables of procedures with numbers rounded like the results'."""

import dataclasses
import io
import re
from collections.abc import Callable

from pypdf import PdfReader

from gyrotest.certificate.pdf import certificate_bytes
from gyrotest.certificate.pictures import picture_groups
from gyrotest.certificate.procedure_table import table_view
from gyrotest.certificate.record import read_record, record_bytes
from gyrotest.records.figure import Curve, Figure, Panel, Width
from gyrotest.records.run import RunRecord
from gyrotest.records.table import Cell, Column, Table
from tests.unit.certificate import records

TABLE = Table(
    title="Noise terms",
    columns=(Column(heading="Term"), Column(heading="Value", numbers=True), Column(heading="Interval")),
    rows=(
        (
            Cell(text="N"),
            Cell(value=0.49873, lower_95=0.4621, upper_95=0.5312),
            Cell(value=0.49873, lower_95=0.4621, upper_95=0.5312, interval=True),
        ),
        (Cell(text="K"), Cell(value=31.84, upper_95=31.84, lower_95=0.0, at_most=True), Cell(text="–")),
        (Cell(text="ratio"), Cell(value=0.9974, digits=3), Cell(value=2.0, digits=3, at_most=True)),
        (Cell(text="band"), Cell(value=100.0, lower_95=99.8, at_least=True), Cell(text="–")),
    ),
    sentences=("A sentence beneath.",),
)


def figure(width: Width, table: Table | None = None) -> Figure:
    panel = Panel(y_label="y", curves=(Curve(x=(0.0, 1.0), y=(0.0, 1.0)),))
    return Figure(name=width.value, title=width.value, panels=(panel,), width=width, table=table)


def run_with(*figures: Figure) -> RunRecord:
    record = records.passing()
    first = record.items[0]
    attempt = dataclasses.replace(first.attempts[0], figures=figures)
    return dataclasses.replace(record, items=(dataclasses.replace(first, attempts=(attempt,)),))


def rows(*widths: Width) -> list[list[int]]:
    """How wide the figures stand in each row, mm."""
    (group,) = picture_groups(run_with(*(figure(one) for one in widths)))
    return [[round(picture.width) for picture in row] for row in group.rows]


def test_parts_of_the_width_that_make_up_a_whole_stand_side_by_side() -> None:
    assert rows(Width.WIDE, Width.NARROW, Width.FULL) == [[117, 56], [180]]
    assert rows(Width.NARROW, Width.WIDE) == [[56, 117]]
    assert rows(Width.HALF, Width.HALF) == [[87, 87]]


def test_three_narrow_figures_stand_side_by_side_and_two_take_a_half_each() -> None:
    narrow = Width.NARROW
    assert rows(narrow, narrow, narrow, Width.FULL) == [[56, 56, 56], [180]]
    assert rows(narrow, narrow, Width.FULL) == [[87, 87], [180]]


def test_a_part_without_its_other_part_takes_the_whole_width() -> None:
    assert rows(Width.HALF, Width.NARROW, Width.FULL, Width.WIDE) == [[180], [180], [180], [180]]


def test_numbers_of_a_table_end_where_their_interval_asks() -> None:
    shown = table_view(TABLE)
    assert shown.rows[0] == ("N", "0.499", "[0.462, 0.531]")
    assert shown.rows[1] == ("K", "≤ 32", "–")
    assert shown.rows[2] == ("ratio", "0.997", "≤ 2.00")
    assert shown.rows[3] == ("band", "≥ 100.00", "–")


def test_a_table_may_stand_without_a_plot() -> None:
    alone = Figure(name="terms", title="Terms", panels=(), table=TABLE)
    ((row,),) = (group.rows for group in picture_groups(run_with(alone)))
    (picture,) = row
    assert picture.source == ""
    assert picture.table is not None


def test_a_table_alone_takes_no_figure_number_and_no_second_heading() -> None:
    alone = Figure(name="terms", title="Alone", panels=(), table=TABLE)
    record = run_with(alone, figure(Width.FULL))
    (group,) = picture_groups(record)
    assert [one.number for row in group.rows for one in row] == [0, 1]
    pages = PdfReader(io.BytesIO(certificate_bytes(record))).pages
    page = " ".join(one.extract_text() for one in pages)
    assert TABLE.title in page
    assert "Alone" not in page
    assert "Fig. 0" not in page


def test_a_table_is_kept_in_the_record() -> None:
    record = run_with(figure(Width.FULL, TABLE))
    assert read_record(record_bytes(record)) == record


def test_a_table_of_many_rows_is_long() -> None:
    assert not table_view(TABLE).long
    assert table_view(dataclasses.replace(TABLE, rows=TABLE.rows * 4)).long


def test_head_of_a_long_table_is_repeated_and_no_row_is_lost(
    pages: Callable[[str], tuple[str, ...]],
) -> None:
    found = [text for text in pages("many_steps") if "Dropped" in text]
    assert len(found) == 3
    assert all("Residual / ppm" in text for text in found)
    assert sum(len(re.findall(r"(?<!\d)9\.936800", text)) for text in found) == 8
