"""The record is written without loss, read back strictly, and given as CSV."""

import csv
import dataclasses
import io
import json
import math
from typing import Any

import pytest

from gyrotest.certificate.csv import COLUMNS, results_csv
from gyrotest.certificate.record import read_record, record_bytes
from gyrotest.errors import CertificateError
from gyrotest.records.run import RunRecord
from tests.unit.certificate import records

TOP = {"schema_version", "run_id", "model", "serial_number", "verdict", "simulated", "results"}
RESULT = {
    "case",
    "repeat",
    "name",
    "value",
    "unit",
    "expanded_uncertainty",
    "coverage_factor",
    "lower_95",
    "upper_95",
    "limit",
    "verdict",
}


def with_value(value: Any, **changes: Any) -> RunRecord:
    record = records.passing()
    first = dataclasses.replace(record.results[0], value=value, **changes)
    return dataclasses.replace(record, results=(first, *record.results[1:]))


@pytest.mark.parametrize("name", ["passing", "failing", "incomplete", "empty", "long_texts"])
def test_record_survives_the_way_to_json_and_back(name: str) -> None:
    record = getattr(records, name)()
    data = record_bytes(record)
    assert read_record(data) == record
    assert record_bytes(read_record(data)) == data


def test_record_is_readable_utf8_with_the_promised_keys() -> None:
    data = record_bytes(records.passing())
    assert data.endswith(b"}\n")
    assert "Göteborg".encode() in data
    found = json.loads(data)
    assert found.keys() >= TOP
    assert all(result.keys() >= RESULT for result in found["results"])
    assert max(map(len, data.splitlines())) < 20_000
    assert b'\n "run_id"' in data


def test_quantities_are_written_as_text() -> None:
    found = json.loads(record_bytes(records.passing()))
    assert found["header"]["spec"]["spec"]["output"]["scale_factor"] == "50 mV/(deg/s)"


@pytest.mark.parametrize("value", [math.nan, math.inf, -math.inf])
def test_record_with_what_is_no_number_is_refused(value: float) -> None:
    with pytest.raises(CertificateError, match="cannot be written as JSON"):
        record_bytes(with_value(value))


def test_text_that_is_no_unicode_is_refused() -> None:
    with pytest.raises(CertificateError, match="cannot be written as JSON"):
        record_bytes(with_value(1.0, condition="\ud800"))


@pytest.mark.parametrize(
    ("data", "message"),
    [
        (b"", "is not JSON"),
        (b"\xff\xfe", "is not JSON"),
        (b"[]", "schema_version None, this gyrotest reads 1"),
        (b'{"schema_version": 2}', "schema_version 2, this gyrotest reads 1"),
        (b'{"schema_version": 1}', "is broken in"),
        (b'{"schema_version": NaN}', "NaN is not a number"),
    ],
)
def test_what_is_no_record_is_refused_in_one_line(data: bytes, message: str) -> None:
    with pytest.raises(CertificateError, match=message) as caught:
        read_record(data)
    assert "\n" not in str(caught.value)


def test_csv_has_a_line_for_each_result_with_all_digits() -> None:
    record = records.passing()
    rows = list(csv.DictReader(io.StringIO(results_csv(record))))
    assert len(rows) == len(record.results)
    assert tuple(rows[0]) == COLUMNS
    assert float(rows[0]["value"]) == record.results[0].value
    assert rows[0]["limit_min"] == "-2.0"
    assert rows[-1]["repeat"] == ""
    assert rows[7]["verdict"] == ""


def test_text_in_csv_is_never_a_formula() -> None:
    text = results_csv(with_value(1.0, label="=HYPERLINK(1)", condition="+1"))
    row = next(csv.DictReader(io.StringIO(text)))
    assert row["label"] == "'=HYPERLINK(1)"
    assert row["condition"] == "'+1"
