"""Results that both ways of recording have: the scale factor, and its spread over repeats."""

import math
from collections.abc import Iterator

from gyrotest.analysis.repeatability import repeatability
from gyrotest.errors import InsufficientDataError
from gyrotest.procedures.meter import meter_contributions
from gyrotest.procedures.scale_factor_recorded.outputs import REPORTED, Outputs
from gyrotest.procedures.scaling import SCALE_FACTORS, Scaling
from gyrotest.procedures.uncertainty import budgeted_result, rectangular
from gyrotest.procedures.wording import plain
from gyrotest.records.plan import Context
from gyrotest.records.recording import Sampling
from gyrotest.records.result import Contribution, Measurand, Result
from gyrotest.records.spec import Case, Output, OutputKind, Over
from gyrotest.units import Dimension, Quantity, conversion_factor, printed_unit

_PPM = 1e6
_MINUS = "\N{MINUS SIGN}"


def scale_factor_measurands(case: Case, output: Output) -> Iterator[Measurand]:
    """Give the scale factor, the bias, and with repeats the scale factor's spread."""
    yield Measurand(
        name="scale_factor",
        label="Scale factor",
        dimension=SCALE_FACTORS[output.kind],
        unit=REPORTED[output.kind],
    )
    yield Measurand(name="bias", label="Bias", dimension=Dimension.RATE, unit="deg/s")
    if case.repeats > 1:
        yield Measurand(
            name="scale_factor_repeatability",
            label="Scale-factor repeatability",
            dimension=Dimension.NUMBER,
            unit="ppm",
            over=Over.REPEATS,
        )


def scale_factor_result(
    slope: float,
    budget: tuple[Contribution, ...],
    outputs: Outputs,
    *,
    condition: str,
    not_included: tuple[str, ...],
) -> Result:
    """Return a scale factor with its budget, in the unit in which it was computed."""
    return budgeted_result(
        budget,
        name="scale_factor",
        label="Scale factor",
        value=slope,
        unit=outputs.slope_unit,
        condition=condition,
        not_included=not_included,
    )


def of_meter_gain(slope: float, context: Context) -> Iterator[Contribution]:
    """Give the error of the meter in proportion to its reading, which all outputs have in common."""
    if context.accuracy is not None:
        share = context.accuracy.of_reading
        yield in_proportion(f"meter, {share} of reading", share, slope)


def of_meter_at_zero(
    outputs: Outputs, sampling: Sampling, slope: float, context: Context
) -> Iterator[Contribution]:
    """Give the meter's shares of a bias, °/s.

    Its gain makes slope and output at rest too large in the same proportion; what it makes of the nominal
    output at rest remains, and its constant error.
    """
    zero = context.output.zero_rate
    scaling = Scaling(
        to_canonical=conversion_factor(sampling.unit, outputs.unit),
        zero=0.0 if zero is None else zero.to(outputs.unit),
        scale_factor=slope,
        unit=outputs.unit,
    )
    yield from meter_contributions(context, sampling, scaling, slope=slope, indication=scaling.zero)


def in_proportion(source: str, share: Quantity, slope: float) -> Contribution:
    """Return what a relative error of something makes of a slope."""
    relative = share.to("")
    return rectangular(
        source, f"{plain(relative * 100.0, 3)} %", plain(abs(slope), 4), relative * abs(slope)
    )


def missing_of_gain(context: Context) -> Iterator[str]:
    """Give what is not known of the gain of a meter that read a voltage."""
    if context.output.kind is OutputKind.VOLTAGE and context.accuracy is None:
        yield "accuracy of the meter"


def sign_remarks(slope: float, context: Context, *, against: str) -> Iterator[str]:
    """Say that an output runs against what it is compared with, or against the spec's own sign."""
    if slope < 0.0:
        yield f"The output's sign is opposite to {against}: the scale factor is negative."
    nominal = context.output.scale_factor
    if nominal is not None and nominal.value * slope < 0.0:
        yield (
            f"The spec's scale factor of {printed_unit(str(nominal))} has the other sign: is the gyro, or"
            " the reference, the other way round?".replace("-", _MINUS)
        )


def repeatability_result(repeats: tuple[tuple[Result, ...], ...], context: Context) -> Result:
    """Return `std(SF)/|mean(SF)|` over the repeats (S3.4); raises `InsufficientDataError`."""
    found = [
        one
        for results in repeats
        for one in results
        if one.name == "scale_factor" and one.value is not None and math.isfinite(one.value)
    ]
    values = [(one.value or 0.0) * conversion_factor(one.unit, found[0].unit) for one in found]
    if len(values) < max(len(repeats), 2):
        raise InsufficientDataError(
            f"{context.case_name}: {len(values)} of {len(repeats)} repeats have a scale factor; its spread"
            " needs at least 2, and all of them"
        )
    if len(set(values)) == 1:
        raise InsufficientDataError(
            f"{context.case_name}: all {len(values)} repeats have the same scale factor to the last digit, as"
            " the same samples would give; was a recorded file played again?"
        )
    spread = repeatability(values)
    ppm = _PPM / abs(spread.mean)
    return Result(
        name="scale_factor_repeatability",
        label="Scale-factor repeatability",
        value=spread.deviation * ppm,
        unit="ppm",
        lower_95=spread.lower_95 * ppm,
        upper_95=spread.upper_95 * ppm,
        condition=f"{spread.count} repeats, standard deviation over the mean's magnitude",
    )
