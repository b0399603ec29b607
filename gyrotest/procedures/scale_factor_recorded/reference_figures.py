"""Figures of a fit to a moving reference: the line, its residuals, and both records over time."""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gyrotest.procedures.scale_factor_recorded.reference_record import ReferenceRecord
from gyrotest.procedures.scale_factor_recorded.thinning import stretches
from gyrotest.procedures.wording import plain
from gyrotest.records.figure import Band, Curve, Figure, Panel, Role
from gyrotest.records.result import Result
from gyrotest.units import printed_unit

_BINS = 60
_MOST_POINTS = 900
_MINUS = "\N{MINUS SIGN}"


@dataclass(frozen=True, slots=True, kw_only=True)
class _Binned:
    """Least, greatest and mean value of the samples in each bin that has some."""

    x: tuple[float, ...]
    lower: tuple[float, ...]
    upper: tuple[float, ...]
    mean: tuple[float, ...]


def reference_figures(record: ReferenceRecord, scale_factor: Result) -> tuple[Figure, ...]:
    """Return the figures, in the order of the certificate."""
    return (_response(record, scale_factor), _records(record))


def _response(record: ReferenceRecord, scale_factor: Result) -> Figure:
    reference, fit = record.reference_dps, record.fit
    low, high = float(reference.min()), float(reference.max())
    outputs, residuals = (
        _over(reference, values) for values in (record.outputs.values, record.residual_dps)
    )
    line = Curve(
        x=(low, high),
        y=(fit.slope * low + fit.intercept, fit.slope * high + fit.intercept),
        role=Role.MODEL,
    )
    unit = printed_unit(record.outputs.unit)
    said = _value_text(scale_factor)
    return Figure(
        name="response",
        title="Output over reference",
        panels=(
            Panel(
                y_label=f"Output / {_bracketed(unit)}",
                height=0.8,
                bands=(_band(outputs),),
                curves=(line,),
                note=said,
            ),
            Panel(
                y_label="Residual / (°/s)",
                x_label="Reference / (°/s)",
                height=0.7,
                bands=(_band(residuals),),
                curves=(
                    Curve(x=residuals.x, y=residuals.mean, role=Role.MEAN),
                    Curve(x=(low, high), y=(0.0, 0.0), role=Role.GUIDE),
                ),
            ),
        ),
        note=f"{record.outputs.values.size} samples",
        caption=f"Shaded: least to greatest of the samples in {_BINS} bins of the reference (none hidden)."
        " Top: line of least squares through all samples. Bottom: output less line, as a rate; line: mean of"
        " the bin.",
        alt=f"Output over reference from {plain(low, 4)} to {plain(high, 4)} °/s, {said}, residual"
        f" {plain(fit.rms / abs(fit.slope), 3)} °/s rms".replace("-", _MINUS),
    )


def _value_text(scale_factor: Result) -> str:
    value, unit = scale_factor.value or 0.0, printed_unit(scale_factor.unit)
    uncertainty = scale_factor.expanded_uncertainty or 0.0
    places = 4 if uncertainty <= 0.0 else max(1 - math.floor(math.log10(uncertainty)), 0)
    text = f"SF = {value:.{places}f} ± {uncertainty:.{places}f} {unit}".rstrip()
    return text.replace("-", _MINUS)


def _over(reference: NDArray[np.float64], values: NDArray[np.float64]) -> _Binned:
    """Gather values in equal bins of the reference."""
    low, high = float(reference.min()), float(reference.max())
    bins = np.minimum(((reference - low) / (high - low) * _BINS).astype(np.int64), _BINS - 1)
    order = np.argsort(bins, kind="stable")
    found, begins, counts = np.unique(bins[order], return_index=True, return_counts=True)
    return _reduced(low + (found + 0.5) * (high - low) / _BINS, values[order], begins, counts)


def _reduced(
    x: NDArray[np.float64],
    values: NDArray[np.float64],
    begins: NDArray[np.intp],
    counts: NDArray[np.intp],
) -> _Binned:
    return _Binned(
        x=tuple(x.tolist()),
        lower=tuple(np.minimum.reduceat(values, begins).tolist()),
        upper=tuple(np.maximum.reduceat(values, begins).tolist()),
        mean=tuple((np.add.reduceat(values, begins) / counts).tolist()),
    )


def _band(binned: _Binned) -> Band:
    return Band(x=binned.x, lower=binned.lower, upper=binned.upper)


def _records(record: ReferenceRecord) -> Figure:
    """Draw both records over time, with the gaps open."""
    outputs, fit = record.outputs, record.fit
    rate = (outputs.values - fit.intercept) / fit.slope
    gaps = f"{outputs.gaps} gap{'s' * (outputs.gaps > 1)}"
    missing = f", {outputs.missing} missing in {gaps}" if outputs.gaps else ""
    return Figure(
        name="record",
        title="Reference and output over time",
        panels=(
            Panel(
                y_label="Reference / (°/s)",
                height=0.6,
                curves=stretches(outputs, record.reference_dps, role=Role.DATA, most=_MOST_POINTS),
            ),
            Panel(
                y_label="Output / (°/s)",
                x_label="Time / s",
                height=0.6,
                curves=stretches(outputs, rate, role=Role.DATA, most=_MOST_POINTS),
            ),
        ),
        note=f"every {plain(outputs.interval_s * 1e3, 4)} ms{missing}",
        caption="Top: the reference. Bottom: the output less its level at rest, over the fitted scale factor.",
        alt=f"Reference and output over {plain(float(outputs.place[-1]) * outputs.interval_s, 4)} s{missing}",
    )


def _bracketed(unit: str) -> str:
    return f"({unit})" if "/" in unit else unit
