"""A gyro with several axes: each is in the tables, the files and the figures by its name."""

import csv
import dataclasses
import io
import re
from collections.abc import Callable

import pytest

from gyrotest.certificate.budgets import budgets
from gyrotest.certificate.case_tables import case_tables
from gyrotest.certificate.csv import results_csv
from gyrotest.certificate.datasheet import datasheet_tables
from gyrotest.certificate.order import in_order
from gyrotest.certificate.pictures import picture_groups
from gyrotest.certificate.record import read_record, record_bytes
from gyrotest.certificate.rows import outcome
from gyrotest.records.run import RunRecord
from tests.unit.certificate import bench_records, records

Pages = Callable[[str], tuple[str, ...]]


def flat(text: str) -> str:
    return re.sub(r"\s+", " ", text)


def with_datasheet(record: RunRecord, **figures: str) -> RunRecord:
    document = record.header.spec
    stated = {name: records.quantity(text) for name, text in figures.items()}
    spec = dataclasses.replace(document, spec=dataclasses.replace(document.spec, datasheet=stated))
    return dataclasses.replace(record, header=dataclasses.replace(record.header, spec=spec))


def test_results_come_in_the_order_of_cases_and_axes_of_the_spec() -> None:
    record = bench_records.rate_table()
    shuffled = dataclasses.replace(record, results=tuple(reversed(record.results)))
    found = [(one.case, one.axis, one.repeat) for one in in_order(shuffled)]
    assert found[:4] == [("scale_factor", "z", 1)] * 4
    bias = [one for one in found if one[0] == "bias_repeatability" and one[2] is not None]
    assert bias == [("bias_repeatability", axis, n) for axis in "xyz" for n in range(1, 8)]
    assert found.index(("bias_repeatability", "x", None)) < found.index(
        ("bias_repeatability", "z", None)
    )


def test_axes_of_a_measurement_stand_beneath_one_another_with_their_limits_said_once() -> None:
    (table,) = case_tables(bench_records.three_axes())
    assert table.axial
    assert not table.repeated
    assert len(table.groups) == 10
    for group in table.groups:
        assert [(block.axis, len(block.rows)) for block in group.blocks] == [
            ("x", 1),
            ("y", 1),
            ("z", 1),
        ]
        assert not group.tall


def test_what_holds_for_one_axis_only_is_said_with_its_name() -> None:
    (table,) = case_tables(bench_records.three_axes())
    minimum = next(group for group in table.groups if group.label == "Allan minimum")
    assert minimum.condition == "x: at τ = 900 s; y: at τ = 1030 s; z: at τ = 1160 s"
    (table,) = case_tables(bench_records.three_repeats())
    minimum = next(group for group in table.groups if group.label == "Allan minimum")
    assert minimum.condition == "x: at τ = 900 s; y: at τ = 1030 s; z: at τ = 1160 s"


def test_conditions_of_each_repeat_name_axis_and_repeat() -> None:
    record = bench_records.three_repeats()
    results = tuple(
        dataclasses.replace(one, condition=f"at {one.repeat}{one.axis}")
        for one in record.results
        if one.name == "allan_minimum" and one.repeat != 3
    )
    (table,) = case_tables(dataclasses.replace(record, results=results))
    told = table.groups[0].condition
    assert told == "x 1: at 1x; x 2: at 2x; y 1: at 1y; y 2: at 2y; z 1: at 1z; z 2: at 2z"


def test_many_rows_may_break_between_axes_only() -> None:
    tables = case_tables(bench_records.rate_table())
    bias, over = tables[1].groups
    assert bias.tall
    assert [(block.axis, len(block.rows), block.tall) for block in bias.blocks] == [
        (axis, 7, False) for axis in "xyz"
    ]
    assert [row.repeat for row in over.rows] == ["all"] * 3


def test_note_of_a_case_tells_its_steps() -> None:
    turned, cycled = case_tables(bench_records.rate_table())
    assert "24 steps of 30 s" in turned.note
    assert "7 × 10 min" in cycled.note


def test_three_axes_of_ten_results_are_read_on_the_first_page(pages: Pages) -> None:
    text = flat(pages("three_axes")[0])
    assert "21 of 21 limits met" in text
    assert (
        "Bias mean of 20 h, after 2 h warm-up, Earth's share removed x 11.96 ± 0.62 k = 2.05 −250 250"
        in text
    )
    assert "y −12.43 ± 0.62 k = 2.05 ✓ PASS" in text
    assert re.search(r"Rate ramp x ≤ 0.0202 .* y ≤ 0.0210 .* z ≤ 0.0218", text)


def test_failing_axis_is_named(pages: Pages) -> None:
    text = flat(pages("one_axis_fails")[0])
    assert "Not conforming: Bias, axis y, repeat 1: 300.00 ± 0.62 °/h, limit −250 … 250 °/h;" in text
    assert "Allan minimum, axis y, repeat 1: 300 [280, 330] °/h, limit ≤ 1 °/h." in text


def test_names_of_axes_are_not_broken(pages: Pages) -> None:
    text = flat(pages("named_axes")[0])
    assert "roll 11.96" in text
    assert "pitch 300.00" in text
    assert "yaw_redundant 12.91" in text


def test_results_of_a_later_case_are_not_torn_apart(pages: Pages) -> None:
    (page,) = (flat(text) for text in pages("two_cases") if "Results – again" in text)
    assert all(label in page for label in ("Bias stability, 1 s", "Allan minimum", "z ≤ 0.0218"))


def test_outcome_of_a_single_axis_names_none() -> None:
    one = bench_records.three_axes().results[0]
    assert outcome(one).startswith("Bias, axis x, repeat 1: ")
    assert outcome(dataclasses.replace(one, axis="")).startswith("Bias, repeat 1: ")


def test_csv_has_a_column_for_the_axis() -> None:
    rows = list(csv.DictReader(io.StringIO(results_csv(bench_records.three_axes()))))
    assert [row["axis"] for row in rows if row["name"] == "bias"] == ["x", "y", "z"]
    rows = list(csv.DictReader(io.StringIO(results_csv(records.passing()))))
    assert {row["axis"] for row in rows} == {""}


def test_budget_of_the_first_axis_stands_for_all_with_the_sums_of_the_others() -> None:
    scale, bias = budgets(bench_records.rate_table())
    assert scale.label == "scale factor (scale_factor), axis z"
    assert scale.others == ""
    assert bias.label == "bias (bias_repeatability), axis x, repeat 1"
    assert bias.others.startswith(
        "Combined standard uncertainty of the others: axis x repeats 2 … 7: 0.0023, 0.0024, "
    )
    assert bias.others.endswith(" °/s.")
    (single,) = budgets(bench_records.three_axes())
    assert single.label == "bias, axis x"
    assert single.others == "Combined standard uncertainty of the others: axis y: 7.1; axis z: 7.4 °/h."


def test_budgets_of_repeats_alone_name_no_axis() -> None:
    (found,) = budgets(records.passing())
    assert found.label == "bias, repeat 1"
    assert found.others == (
        "Combined standard uncertainty of the others: repeats 2, 3: 0.0019, 0.0019 °/s."
    )


def test_datasheet_stands_beside_what_each_axis_gave() -> None:
    (table,) = datasheet_tables(bench_records.three_axes())
    assert [column.heading for column in table.columns] == [
        *("Parameter", "Datasheet", "Unit"),
        *("Axis x", "Ratio", "Axis y", "Ratio", "Axis z", "Ratio"),
    ]
    assert table.rows[0] == (
        *("Allan minimum", "0.5", "°/h"),
        *("0.475 [0.441, 0.513]", "0.949"),
        *("0.494 [0.459, 0.533]", "0.987"),
        *("0.512 [0.476, 0.553]", "1.02"),
    )
    assert table.rows[2][3:5] == ("≤ 0.909 [0.845, 0.982]", "≤ 0.909")


def test_datasheets_figure_is_converted_to_the_unit_of_the_result() -> None:
    record = with_datasheet(bench_records.three_axes(), allan_minimum="0.0001 deg/s")
    (table,) = datasheet_tables(record)
    assert table.rows[0][1:3] == ("0.36", "°/h")


def test_repeats_of_a_datasheets_figure_stand_in_rows_of_their_own() -> None:
    (table,) = datasheet_tables(records.passing())
    rows = [row for row in table.rows if len(row) == 6]
    assert [row[:4] for row in rows[:3]] == [
        ("Allan minimum", "1", "10", "°/h"),
        ("", "2", "", ""),
        ("", "3", "", ""),
    ]


def test_axis_without_a_value_has_a_dash_beside_the_datasheet() -> None:
    record = bench_records.three_axes()
    results = tuple(
        dataclasses.replace(one, value=None) if one.axis == "y" else one for one in record.results
    )
    (table,) = datasheet_tables(dataclasses.replace(record, results=results))
    assert table.rows[0][5:7] == ("–", "–")


def test_datasheets_figure_of_nothing_measured_or_of_another_kind_is_left_out() -> None:
    assert datasheet_tables(with_datasheet(bench_records.three_axes(), noise="1 deg/h")) == ()
    assert datasheet_tables(with_datasheet(bench_records.three_axes(), allan_minimum="1 V")) == ()


def test_a_datasheets_zero_has_no_ratio() -> None:
    (table,) = datasheet_tables(with_datasheet(bench_records.three_axes(), bias="0 deg/h"))
    assert table.rows[0][4] == "–"


def test_figures_are_grouped_by_item_and_then_by_axis() -> None:
    record = bench_records.three_repeats()
    headings = [group.heading for group in picture_groups(record)]
    assert headings[:4] == [
        "noise, repeat 1 of 3, axis x",
        "noise, repeat 1 of 3, axis y",
        "noise, repeat 1 of 3, axis z",
        "noise, repeat 2 of 3, axis x",
    ]
    single = [group.heading for group in picture_groups(bench_records.rate_table())]
    assert single[:2] == ["scale_factor, axis z", "bias_repeatability, over the repeats, axis x"]


def test_what_belongs_to_no_axis_comes_before_them() -> None:
    record = bench_records.three_axes()
    item = record.items[0]
    figures = item.attempts[0].figures
    common = dataclasses.replace(figures[0], axis="", title="temperature")
    attempt = dataclasses.replace(item.attempts[0], figures=(*figures, common))
    changed = dataclasses.replace(record, items=(dataclasses.replace(item, attempts=(attempt,)),))
    groups = picture_groups(changed)
    assert [group.heading for group in groups] == ["noise", *(f"noise, axis {one}" for one in "xyz")]
    assert groups[0].rows[0][0].number == 1


@pytest.mark.parametrize("name", ["three_axes", "rate_table"])
def test_records_of_several_axes_come_back_from_json(name: str) -> None:
    record = getattr(bench_records, name)()
    assert read_record(record_bytes(record)) == record


def test_results_that_differ_in_a_setting_share_a_budget() -> None:
    record = records.passing()
    like = next(one for one in record.results if one.budget)
    at_frequencies = tuple(
        dataclasses.replace(
            like, repeat=1, name=f"sensitivity_{hertz}Hz", label=f"Sensitivity, {hertz} Hz"
        )
        for hertz in (5, 20, 100)
    )
    (found,) = budgets(dataclasses.replace(record, results=at_frequencies))
    assert found.label == "sensitivity, 5 Hz"
    assert found.others == (
        "Combined standard uncertainty of the others: 20 Hz: 0.0018; 100 Hz: 0.0018 °/s."
    )
