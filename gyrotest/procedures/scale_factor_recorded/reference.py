"""The procedure `scale_factor_reference`: the output over a reference rate recorded beside it (S3)."""

from collections.abc import Iterable, Iterator
from typing import Any

import numpy as np

from gyrotest.analysis.interval import deviation_bounds
from gyrotest.analysis.reference_fit import delay_s
from gyrotest.procedures.case_plan import single_step_plan
from gyrotest.procedures.earth import earth_share, earth_words, of_earth
from gyrotest.procedures.meter import missing_of_meter
from gyrotest.procedures.scale_factor_recorded.reference_figures import reference_figures
from gyrotest.procedures.scale_factor_recorded.reference_parameters import (
    ReferenceParameters,
    reference_complaints,
)
from gyrotest.procedures.scale_factor_recorded.reference_record import (
    ReferenceRecord,
    reference_record,
    told,
)
from gyrotest.procedures.scale_factor_recorded.results import (
    in_proportion,
    missing_of_gain,
    of_meter_at_zero,
    of_meter_gain,
    repeatability_result,
    scale_factor_measurands,
    scale_factor_result,
    sign_remarks,
)
from gyrotest.procedures.uncertainty import budgeted_result, by_statistics, rectangular
from gyrotest.procedures.wording import plain, rate_text
from gyrotest.records.plan import Context, Plan, Reduction
from gyrotest.records.recording import Samples
from gyrotest.records.result import Contribution, Measurand, Result
from gyrotest.records.spec import Case, Output
from gyrotest.units import Dimension, Quantity

_MATTERS = 1e-3
_DELAY_TOLD = 0.2  # of an interval


class ScaleFactorReference:
    """Scale factor and bias by a line through all samples, the reference being recorded beside them."""

    parameters: type[Any] = ReferenceParameters

    def measurands(
        self, case: Case, parameters: ReferenceParameters, output: Output
    ) -> tuple[Measurand, ...]:
        """Return everything that a case with these parameters measures."""
        del parameters
        rms = Measurand(
            name="residual_rms",
            label="Residual about the line, rms",
            dimension=Dimension.RATE,
            unit="deg/s",
        )
        return (*scale_factor_measurands(case, output), rms)

    def complaints(
        self, case: Case, parameters: ReferenceParameters, output: Output
    ) -> Iterable[tuple[str, str]]:
        """Give what is wrong with a case beyond its types."""
        del output  # the scale factor is what is measured: none is needed
        return reference_complaints(case, parameters)

    def plan(self, case: Case, parameters: ReferenceParameters) -> Plan:
        """Return the acquisition of one repeat: a single step, whatever moves the gyro."""
        return single_step_plan(case, auxiliary=(parameters.reference,))

    def reduce(self, samples: Samples, context: Context) -> Reduction:
        """Return results and figures of one acquisition; raises `InsufficientDataError`."""
        parameters: ReferenceParameters = context.parameters
        record = reference_record(samples, context, parameters)
        results = (
            _scale_factor(record, parameters, context),
            _bias(record, samples, parameters, context),
            _rms(record),
        )
        return Reduction(
            results=results,
            figures=reference_figures(record, results[0]),
            remarks=(
                *sign_remarks(record.fit.slope, context, against=f"that of '{parameters.reference}'"),
                *told(record, parameters),
                *_delay_remarks(record, parameters),
            ),
        )

    def reduce_repeats(self, repeats: tuple[tuple[Result, ...], ...], context: Context) -> Reduction:
        """Return the spread of the scale factor over the repeats; raises `InsufficientDataError`."""
        return Reduction(results=(repeatability_result(repeats, context),))


def _scale_factor(record: ReferenceRecord, parameters: ReferenceParameters, context: Context) -> Result:
    fit, share = record.fit, _reference_share(parameters, context)
    budget = (
        by_statistics(
            f"scatter about the line, {plain(fit.effective_samples, 3)} independent samples",
            fit.slope_uncertainty,
            fit.slope_freedom,
        ),
        # What all samples have in common joins after the fit.
        *(() if share is None else (in_proportion(f"reference, {share}", share, fit.slope),)),
        *of_meter_gain(fit.slope, context),
        *_of_reference_steps(record),
    )
    return scale_factor_result(
        fit.slope,
        budget,
        record.outputs,
        condition=f"{record.outputs.values.size} samples, reference {_range(record)} °/s",
        not_included=(
            *(("accuracy of the reference",) if share is None else ()),
            *missing_of_gain(context),
        ),
    )


def _range(record: ReferenceRecord) -> str:
    low, high = float(record.reference_dps.min()), float(record.reference_dps.max())
    return f"{plain(low, 4)} … {plain(high, 4)}".replace("-", "\N{MINUS SIGN}")


def _reference_share(parameters: ReferenceParameters, context: Context) -> Quantity | None:
    if parameters.reference_uncertainty is not None:
        return parameters.reference_uncertainty
    return None if context.table is None else context.table.of_reading


def _of_reference_steps(record: ReferenceRecord) -> Iterator[Contribution]:
    """Give how much the rounding of the reference flattens the line, where it matters.

    Errors of the abscissa of variance v lower a slope by v over the abscissa's variance.
    """
    step, fit = record.reference_step_dps, record.fit
    if step is None:
        return
    half = abs(fit.slope) * (step**2 / 12.0) / float(record.reference_dps.var())
    if half >= _MATTERS * fit.slope_uncertainty:
        yield rectangular(f"reference, steps of {rate_text(step)}", "", "", half)


def _bias(
    record: ReferenceRecord, samples: Samples, parameters: ReferenceParameters, context: Context
) -> Result:
    """Return `U0/SF` less the Earth's share (S3.3)."""
    fit, share_dps = record.fit, earth_share(context)
    share = _reference_share(parameters, context)
    level_dps = fit.intercept / fit.slope
    offset = parameters.reference_offset
    if offset is None and context.table is not None:
        offset = context.table.of_setting
    budget = (
        by_statistics(
            "scatter about the line", fit.intercept_uncertainty / abs(fit.slope), fit.intercept_freedom
        ),
        by_statistics(
            "scale factor, by the scatter",
            abs(level_dps / fit.slope) * fit.slope_uncertainty,
            fit.slope_freedom,
        ),
        *(
            ()
            if offset is None
            else (rectangular(f"reference at rest, {offset}", "", "1", offset.to("deg/s")),)
        ),
        *(() if share is None else (in_proportion(f"reference, {share}", share, level_dps),)),
        *of_meter_at_zero(record.outputs, samples.sampling, fit.slope, context),
        of_earth(share_dps),
    )
    return budgeted_result(
        budget,
        name="bias",
        label="Bias",
        value=level_dps - (share_dps or 0.0),
        unit="deg/s",
        condition=f"where the line is at rest; {earth_words(share_dps)}",
        not_included=(
            *(("offset of the reference at rest",) if offset is None else ()),
            *(("accuracy of the reference",) if share is None else ()),
            *missing_of_meter(context, samples.sampling),
        ),
    )


def _rms(record: ReferenceRecord) -> Result:
    rms_dps = record.fit.rms / abs(record.fit.slope)
    bounds = deviation_bounds(rms_dps, record.fit.rms_freedom, confidence=0.95)
    return Result(
        name="residual_rms",
        label="Residual about the line, rms",
        value=rms_dps,
        unit="deg/s",
        lower_95=float(bounds.lower),
        upper_95=float(bounds.upper),
        condition=f"largest {rate_text(float(np.abs(record.residual_dps).max()), 3)}",
    )


def _delay_remarks(record: ReferenceRecord, parameters: ReferenceParameters) -> Iterator[str]:
    interval_s = record.outputs.interval_s
    delay = delay_s(record.fit, record.reference_dps, record.outputs.place, interval_s=interval_s)
    if delay is not None and abs(delay) >= _DELAY_TOLD * interval_s:
        yield (
            f"The output {'lags' if delay > 0.0 else 'leads'} '{parameters.reference}' by about"
            f" {plain(abs(delay) * 1e3, 2)} ms, which the residuals contain."
        )
