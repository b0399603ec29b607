"""The samples of output and reference that a line is fitted to, and what was left out of them."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gyrotest.analysis.reference_fit import ReferenceFit, reference_fit
from gyrotest.analysis.resolution import digital_step
from gyrotest.errors import InsufficientDataError
from gyrotest.procedures.scale_factor_recorded.outputs import Outputs, recorded_outputs
from gyrotest.procedures.scale_factor_recorded.reference_parameters import (
    Outliers,
    ReferenceParameters,
)
from gyrotest.procedures.wording import plain
from gyrotest.records.plan import Context
from gyrotest.records.recording import Samples
from gyrotest.units import Dimension, conversion_factor, same_dimension

MOST_LEFT_OUT = 0.01
"""Share of the samples beyond which outliers are no outliers any more (S3.2)."""

_FOLLOWS = 3.0
_CLIPPED_FOR = 5
_CLIPPED_STEPS = 5.0


@dataclass(frozen=True, slots=True, kw_only=True)
class ReferenceRecord:
    """Outputs, the reference beside them (n,), the line through them, and what was left out.

    `outliers` lie far from the line; whether they were left out, `dropped` says.
    """

    outputs: Outputs
    reference_dps: NDArray[np.float64]
    fit: ReferenceFit
    reference_step_dps: float | None
    recorded: int
    first_left_out: int
    without_reference: int
    slow: int
    outliers: int
    dropped: bool

    @property
    def residual_dps(self) -> NDArray[np.float64]:
        """Residuals (n,) as rates: of the sign that the input would have had."""
        residual: NDArray[np.float64] = self.fit.residuals / self.fit.slope
        return residual


def reference_record(
    samples: Samples, context: Context, parameters: ReferenceParameters
) -> ReferenceRecord:
    """Fit what counts of a recording; raises `InsufficientDataError`."""
    everything = recorded_outputs(samples, context)
    reference = _reference_dps(samples, parameters.reference, context)
    begun = np.arange(reference.size) >= parameters.leave_out
    known = np.isfinite(reference)
    fast = np.abs(np.where(known, reference, 0.0)) >= _slowest_dps(parameters)
    counts = begun & known & fast
    outputs, kept = everything.part(counts), reference[counts]
    fit = reference_fit(outputs.values, kept)
    far = _far(fit, outputs, parameters)
    dropped = parameters.outliers is Outliers.LEAVE_OUT and bool(far.any())
    if dropped:
        _refuse_many(far, context)
        outputs, kept = outputs.part(~far), kept[~far]
        fit = reference_fit(outputs.values, kept)
    _refuse_lifeless(fit, context)
    _refuse_clipped(outputs, kept, fit, context)
    return ReferenceRecord(
        outputs=outputs,
        reference_dps=kept,
        fit=fit,
        reference_step_dps=digital_step(kept),
        recorded=reference.size,
        first_left_out=int(np.count_nonzero(~begun)),
        without_reference=int(np.count_nonzero(begun & ~known)),
        slow=int(np.count_nonzero(begun & known & ~fast)),
        outliers=int(far.sum()),
        dropped=dropped,
    )


def told(record: ReferenceRecord, parameters: ReferenceParameters) -> Iterator[str]:
    """Say what was used, what was left out, and what lacks."""
    yield f"The line is fitted to {record.outputs.values.size} of {record.recorded} samples."
    if record.outputs.gaps:
        yield (
            f"The record has {record.outputs.gaps} gap{'s' * (record.outputs.gaps > 1)} with room for"
            f" {record.outputs.missing} samples; the line needs none of them, and nothing is filled in."
        )
    for count, why in (
        (record.first_left_out, "at the begin, as the case says"),
        (record.without_reference, "without a value of the reference"),
        (record.slow, f"with the reference slower than {parameters.low_speed}"),
    ):
        if count:
            yield f"Left out: {count} {_noun(count)} {why}."
    verb = "left out" if record.dropped else "kept"
    yield (
        f"{record.outliers} {_noun(record.outliers)} farther than {parameters.outlier_mads:g} median absolute"
        f" deviations from the line{f', {verb}' if record.outliers else ''}."
    )


def _noun(count: int) -> str:
    return "sample" if count == 1 else "samples"


def _slowest_dps(parameters: ReferenceParameters) -> float:
    return 0.0 if parameters.low_speed is None else parameters.low_speed.to("deg/s")


def _reference_dps(samples: Samples, name: str, context: Context) -> NDArray[np.float64]:
    beside = samples.sampling.auxiliary
    names = [one.name for one in beside]
    if name not in names:
        instead = f", but {', '.join(names)}" if names else ""
        raise InsufficientDataError(
            f"{context.case_name}: no '{name}' is recorded beside the output{instead}; name it in the"
            " station, e.g. with the driver replay 'auxiliary: {" + name + ": {column: 3, unit: rpm}}'"
        )
    unit = beside[names.index(name)].unit
    if not same_dimension(unit, Dimension.RATE):
        raise InsufficientDataError(
            f"{context.case_name}: '{name}' is recorded in '{unit}', which is no rate; correct the unit in"
            " the station, e.g. 'rpm'"
        )
    column = len(samples.sampling.channels) + names.index(name)
    rate: NDArray[np.float64] = samples.values[:, column] * conversion_factor(unit, "deg/s")
    return rate


def _far(fit: ReferenceFit, outputs: Outputs, parameters: ReferenceParameters) -> NDArray[np.bool_]:
    """Return which samples lie far from the line; one step of a digitised output is never far."""
    away = np.abs(fit.residuals - np.median(fit.residuals))
    step = digital_step(outputs.values) or 0.0
    far: NDArray[np.bool_] = away > parameters.outlier_mads * max(float(np.median(away)), step)
    return far


def _refuse_many(far: NDArray[np.bool_], context: Context) -> None:
    if far.sum() > MOST_LEFT_OUT * far.size:
        raise InsufficientDataError(
            f"{context.case_name}: {int(far.sum())} of {far.size} samples are outliers, more than"
            f" {MOST_LEFT_OUT:.0%}: they belong to the record; keep them, or correct 'outlier_mads'"
        )


def _refuse_lifeless(fit: ReferenceFit, context: Context) -> None:
    if abs(fit.slope) <= _FOLLOWS * fit.slope_uncertainty:
        raise InsufficientDataError(
            f"{context.case_name}: the output does not follow the reference (slope {plain(fit.slope, 3)} ±"
            f" {plain(fit.slope_uncertainty, 2)} a °/s); are the columns right, and was the gyro powered?"
        )


def _refuse_clipped(
    outputs: Outputs, reference_dps: NDArray[np.float64], fit: ReferenceFit, context: Context
) -> None:
    """Refuse an output that stands at its greatest or least value while the reference goes on."""
    # Between neighbours, whose noise a clipped output leaves as it is.
    noise = float(np.median(np.abs(np.diff(outputs.values) - fit.slope * np.diff(reference_dps))))
    step = max(digital_step(outputs.values) or 0.0, noise)
    for extreme in (outputs.values.max(), outputs.values.min()):
        edges = np.flatnonzero(np.diff(np.concatenate(([0], outputs.values == extreme, [0]))))
        runs = edges.reshape(-1, 2)
        for begin, end in runs[runs[:, 1] - runs[:, 0] >= _CLIPPED_FOR].tolist():
            moved = abs(fit.slope) * float(np.ptp(reference_dps[begin:end]))
            if moved > _CLIPPED_STEPS * step:
                raise InsufficientDataError(
                    f"{context.case_name}: {end - begin} samples from sample {int(outputs.place[begin])} on"
                    f" all read {plain(float(extreme), 6)} {outputs.unit} while the reference moves: the"
                    " output stands at its limit; leave such rates out"
                )
