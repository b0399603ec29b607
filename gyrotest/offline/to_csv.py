"""Analyses as CSV: one row an averaging time and record, full digits."""

import csv
import io
from collections.abc import Iterator, Sequence

from gyrotest.offline.analysis import Analysis
from gyrotest.offline.to_json import noise_names
from gyrotest.procedures.static.terms import TERMS

COLUMNS = (
    "file",
    "array",
    "column",
    "averaging_factor",
    "tau_s",
    "deviation_dps",
    "lower_68_dps",
    "upper_68_dps",
    "edf",
    "noise_type",
    "n_differences",
    "fitted_dps",
    *(f"{term.name}_dps" for term in TERMS),
)


def csv_text(analyses: Sequence[Analysis]) -> str:
    """Return a header line and the curves, one behind another; the fit and each of its terms beside."""
    out = io.StringIO()
    writer = csv.writer(out, lineterminator="\r\n")
    writer.writerow(COLUMNS)
    for analysis in analyses:
        writer.writerows(_rows(analysis))
    return out.getvalue()


def _rows(analysis: Analysis) -> Iterator[tuple[object, ...]]:
    curve, model, source = analysis.curve, analysis.model, analysis.source
    factors = curve.averaging_factor
    named = (str(source.path), source.array or "", "" if source.column is None else source.column)
    columns = (
        factors.tolist(),
        curve.tau_s.tolist(),
        curve.deviation_dps.tolist(),
        curve.lower_dps.tolist(),
        curve.upper_dps.tolist(),
        curve.edf.tolist(),
        noise_names(analysis),
        curve.n_differences.tolist(),
        model.allan_deviation_dps(factors).tolist(),
        *model.components_dps(factors).tolist(),
    )
    for row in zip(*columns, strict=True):
        yield (*named, *row)
