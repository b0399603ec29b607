"""The table of results: what is common to the repeats is said once."""

import dataclasses

from gyrotest.certificate.case_tables import case_tables
from gyrotest.certificate.rows import outcome
from gyrotest.records.result import Verdict
from tests.unit.certificate import records


def with_conditions(*conditions: str) -> tuple[str, ...]:
    """The printed condition of the bias, and those of its rows."""
    record = records.passing()
    results = tuple(
        dataclasses.replace(records.results_of(1)[0], repeat=number, condition=condition)
        for number, condition in enumerate(conditions, start=1)
    )
    table = case_tables(dataclasses.replace(record, results=results))[0]
    return table.groups[0].condition, *(row.condition for row in table.groups[0].rows)


def test_common_part_of_the_conditions_is_said_once() -> None:
    assert (
        with_conditions("duty 0.4; at 126 s", "duty 0.4; at 398 s")[0]
        == "duty 0.4; 1: at 126 s; 2: at 398 s"
    )
    assert with_conditions("duty 0.4", "duty 0.4")[0] == "duty 0.4"


def test_conditions_of_many_repeats_stand_in_their_rows() -> None:
    own = [f"at {number} s" for number in range(20)]
    common, *rows = with_conditions(*own)
    assert common == ""
    assert rows == own


def test_repeats_follow_one_another_and_what_is_over_them_comes_last() -> None:
    record = records.passing()
    shuffled = dataclasses.replace(record, results=tuple(reversed(record.results)))
    groups = {group.label: group for group in case_tables(shuffled)[0].groups}
    assert [row.repeat for row in groups["Bias"].rows] == ["1", "2", "3"]
    assert [row.repeat for row in groups["Bias run to run"].rows] == ["all"]


def test_each_case_has_its_own_table() -> None:
    record = records.passing()
    other = tuple(dataclasses.replace(one, case="cold") for one in record.results)
    tables = case_tables(dataclasses.replace(record, results=record.results + other))
    assert [(table.case, len(table.groups)) for table in tables] == [("bias_stability", 9), ("cold", 9)]


def test_limits_are_repeated_beside_values_that_do_not_pass() -> None:
    rows = [row for group in case_tables(records.failing())[0].groups for row in group.rows]
    assert [row.telling for row in rows].count(True) == 3
    assert {row.look.style for row in rows if row.telling and row.look} == {"fail", "conditional"}


def test_outcome_names_what_was_measured_with_its_limit() -> None:
    result = records.results_of(1)[6]
    failed = dataclasses.replace(result, verdict=Verdict.FAIL, value=0.7, lower_95=0.68, upper_95=0.72)
    assert outcome(failed) == "Angle random walk, repeat 1: 0.700 [0.680, 0.720] °/√h, limit ≤ 0.6 °/√h"
