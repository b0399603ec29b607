"""The coefficients as files: for the gyro's memory, or for the user's own code."""

import csv
import io
import json
from collections.abc import Iterator, Mapping
from typing import Any

from gyrotest.procedures.compensation.coefficients import Coefficient, Coefficients
from gyrotest.records.plan import Context, Export
from gyrotest.records.result import Result

_FORMAT = "gyrotest.coefficients/1"
_EQUATION = "rate = (output - zero_rate) / scale_factor - bias"


def coefficient_exports(
    coefficients: Coefficients, results: tuple[Result, ...], context: Context
) -> tuple[Export, ...]:
    """Return the coefficients as JSON and as CSV, the residuals of the verification with them."""
    content = _content(coefficients, results, context)
    return (
        Export(name="coefficients.json", text=json.dumps(content, indent=2, ensure_ascii=False) + "\n"),
        Export(name="coefficients.csv", text=_csv(content)),
    )


def _content(
    coefficients: Coefficients, results: tuple[Result, ...], context: Context
) -> dict[str, Any]:
    return {
        "format": _FORMAT,
        "case": context.case_name,
        "axis": context.axis,
        "output_kind": context.output.kind.value,
        "equation": _EQUATION,
        "equation_in_words": (
            "The rate about the axis is the output less the nominal output at rest (zero_rate), divided by"
            " the scale factor, less the bias."
            + ("" if coefficients.holds_earth else " The Earth's rate about the axis is part of it.")
        ),
        "coefficients": {
            "scale_factor": _entry(coefficients.scale_factor),
            "bias": _entry(coefficients.bias),
            "zero_rate": {"value": coefficients.zero, "unit": coefficients.zero_unit},
        },
        "earth_rate_in_bias": coefficients.holds_earth,
        "fitted_from": {"case": coefficients.from_case, "fits": coefficients.fits},
        "verification": {
            one.name: {
                "value": one.value,
                "unit": one.unit,
                "lower_95": one.lower_95,
                "upper_95": one.upper_95,
            }
            for one in results
        },
    }


def _entry(coefficient: Coefficient) -> dict[str, Any]:
    return {
        "value": coefficient.value,
        "unit": coefficient.unit,
        "expanded_uncertainty": coefficient.expanded_uncertainty,
        "coverage_factor": coefficient.coverage_factor,
    }


def _csv(content: Mapping[str, Any]) -> str:
    """Return one row a quantity; empty where a column does not apply."""
    file = io.StringIO()
    columns = (
        "axis",
        "quantity",
        "value",
        "unit",
        "expanded_uncertainty",
        "coverage_factor",
        "lower_95",
        "upper_95",
    )
    writer = csv.DictWriter(file, columns, lineterminator="\n")
    writer.writeheader()
    writer.writerows(_rows(content))
    return file.getvalue()


def _rows(content: Mapping[str, Any]) -> Iterator[dict[str, Any]]:
    for section in ("coefficients", "verification"):
        for name, entry in content[section].items():
            yield {"axis": content["axis"], "quantity": name, **entry}
