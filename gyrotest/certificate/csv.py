"""The results as CSV: full digits, one line a result."""

import csv
import io

from gyrotest.records.result import JudgedResult
from gyrotest.records.run import RunRecord

COLUMNS = (
    "run_id",
    "model",
    "serial_number",
    "case",
    "repeat",
    "axis",
    "name",
    "label",
    "value",
    "at_most",
    "at_least",
    "unit",
    "expanded_uncertainty",
    "coverage_factor",
    "lower_95",
    "upper_95",
    "limit_min",
    "limit_max",
    "decision",
    "verdict",
    "condition",
    "reason",
)
_FORMULA_STARTS = ("=", "+", "-", "@", "\t", "\r")


def results_csv(record: RunRecord) -> str:
    """Return a header line and one line a result; what was not evaluated is empty."""
    out = io.StringIO()
    writer = csv.writer(out, lineterminator="\r\n")
    writer.writerow(COLUMNS)
    for result in record.results:
        unit = (record.run_id, record.model, record.serial_number)
        writer.writerow([_cell(value) for value in (*unit, *_fields(result))])
    return out.getvalue()


def _fields(result: JudgedResult) -> tuple[object, ...]:
    limit = result.limit
    return (
        result.case,
        result.repeat,
        result.axis,
        result.name,
        result.label,
        result.value,
        str(result.at_most).lower(),
        str(result.at_least).lower(),
        result.unit,
        result.expanded_uncertainty,
        result.coverage_factor,
        result.lower_95,
        result.upper_95,
        limit.min if limit else None,
        limit.max if limit else None,
        limit.decision.value if limit else None,
        result.verdict.value if result.verdict else None,
        result.condition,
        result.reason,
    )


def _cell(value: object) -> str:
    if value is None:
        return ""
    if isinstance(value, float):
        return repr(value)
    text = str(value)
    # A spreadsheet would run a text that looks like a formula.
    return f"'{text}" if isinstance(value, str) and text.startswith(_FORMULA_STARTS) else text
