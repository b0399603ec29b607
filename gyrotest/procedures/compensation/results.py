"""The residuals as results: rms and largest, before and after."""

from collections.abc import Iterator

from gyrotest.analysis.extremes import Magnitude, largest_magnitude
from gyrotest.analysis.residuals import RootMeanSquare, root_mean_square
from gyrotest.procedures.compensation.coefficients import Coefficients
from gyrotest.procedures.compensation.verification import Residuals, Verification
from gyrotest.procedures.earth import earth_words
from gyrotest.procedures.table_steps import missing_of_table
from gyrotest.procedures.wording import plain
from gyrotest.records.plan import Context
from gyrotest.records.result import Measurand, Result
from gyrotest.records.spec import OutputKind
from gyrotest.units import Dimension

_MINUS = "\N{MINUS SIGN}"
_LABELS = {
    "residual_rms_before": "Residual before compensation, rms",
    "residual_max_before": "Residual before compensation, largest",
    "residual_rms_after": "Residual after compensation, rms",
    "residual_max_after": "Residual after compensation, largest",
}


def compensation_measurands() -> tuple[Measurand, ...]:
    """Return all that a compensation case measures."""
    return tuple(
        Measurand(name=name, label=label, dimension=Dimension.RATE, unit="deg/s")
        for name, label in _LABELS.items()
    )


def compensation_results(
    found: Verification, coefficients: Coefficients, context: Context
) -> tuple[Result, ...]:
    """Return rms and largest residual with their 95 % intervals."""
    missing = tuple(_missing(context))
    own = {
        "before": f"nominal scale factor and zero; {earth_words(found.share_dps)}",
        "after": f"scale factor and bias of '{coefficients.from_case}'; {_earth_after(found, coefficients)}",
    }
    return tuple(
        result
        for when, residuals in (("before", found.before), ("after", found.after))
        for result in _pair(when, residuals, found, own[when], missing)
    )


def _earth_after(found: Verification, coefficients: Coefficients) -> str:
    return (
        "the bias holds the Earth's rate" if coefficients.holds_earth else earth_words(found.share_dps)
    )


def _pair(
    when: str, residuals: Residuals, found: Verification, condition: str, missing: tuple[str, ...]
) -> Iterator[Result]:
    rms = root_mean_square(residuals.values_dps, covariance=residuals.covariance)
    largest = largest_magnitude(
        residuals.values_dps, standard=residuals.standard_dps, freedom=residuals.freedom
    )
    place = int(abs(residuals.values_dps).argmax())
    at = plain(float(found.rates_dps[place]), 4).replace("-", _MINUS)
    sign = "positive" if residuals.values_dps[place] > 0.0 else "negative"
    names = (f"residual_rms_{when}", f"residual_max_{when}")
    conditions = (
        f"{found.rates_dps.size} steps, each known to ± {plain(rms.error, 2)} °/s (k = 1, rms); {condition}",
        f"at {at} °/s, where it is {sign}; {condition}",
    )
    sizes: tuple[RootMeanSquare | Magnitude, ...] = (rms, largest)
    for name, one, told in zip(names, sizes, conditions, strict=True):
        yield Result(
            name=name,
            label=_LABELS[name],
            value=one.value,
            unit="deg/s",
            lower_95=one.lower_95,
            upper_95=one.upper_95,
            condition=told,
            not_included=missing,
        )


def _missing(context: Context) -> Iterator[str]:
    yield from missing_of_table(context)
    if context.output.kind is OutputKind.VOLTAGE and context.accuracy is None:
        yield "accuracy of the meter"
