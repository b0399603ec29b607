"""Results that are spreads: a 95 % interval which the scale factor's uncertainty joins."""

import math
from dataclasses import dataclass

from gyrotest.analysis.interval import NORMAL_95
from gyrotest.records.plan import Context
from gyrotest.records.result import Result
from gyrotest.records.spec import OutputKind


@dataclass(frozen=True, slots=True, kw_only=True)
class Spread:
    """A spread and its 95 % interval; `at_most`: only an upper bound is known."""

    value: float
    lower: float
    upper: float
    at_most: bool = False

    @classmethod
    def bound(cls, upper: float) -> "Spread":
        """Return what is known to be no more than an upper limit."""
        return cls(value=upper, lower=0.0, upper=upper, at_most=True)

    def times(self, factor: float) -> "Spread":
        """Return the spread in another unit."""
        return Spread(
            value=self.value * factor,
            lower=self.lower * factor,
            upper=self.upper * factor,
            at_most=self.at_most,
        )

    def widened(self, relative: float) -> "Spread":
        """Return the spread with a relative standard uncertainty in its interval, added in squares."""
        more = NORMAL_95 * relative * self.value
        if self.at_most and self.value == self.upper:
            return Spread.bound(self.upper + more)
        return Spread(
            value=self.value,
            lower=max(self.value - math.hypot(self.value - self.lower, more), 0.0),
            upper=self.value + math.hypot(self.upper - self.value, more),
            at_most=self.at_most,
        )


def spread_result(
    spread: Spread,
    *,
    name: str,
    label: str,
    unit: str,
    condition: str,
    context: Context,
    missing: tuple[str, ...] = (),
) -> Result:
    """Return a spread as a result, its interval widened by the scale's uncertainty.

    `missing` names what could not be had of its uncertainty beside what the context lacks.
    """
    widened = spread.widened(relative_scale_uncertainty(context))
    return Result(
        name=name,
        label=label,
        value=widened.value,
        unit=unit,
        lower_95=0.0 if widened.at_most else widened.lower,
        upper_95=widened.upper,
        at_most=widened.at_most,
        condition=condition,
        not_included=(*_not_included(context), *missing),
    )


def relative_scale_uncertainty(context: Context) -> float:
    """Return the relative standard uncertainty of every rate: of the scale factor and the meter's gain.

    Their half-widths (rectangular) are combined.
    """
    half_widths = []
    if context.output.scale_factor_uncertainty is not None:
        half_widths.append(context.output.scale_factor_uncertainty.to(""))
    if context.accuracy is not None:
        half_widths.append(context.accuracy.of_reading.to(""))
    return math.sqrt(sum(one**2 for one in half_widths) / 3.0)


def _not_included(context: Context) -> tuple[str, ...]:
    missing = []
    if context.output.kind is OutputKind.VOLTAGE and context.accuracy is None:
        missing.append("accuracy of the meter")
    if context.output.scale_factor_uncertainty is None:
        missing.append("uncertainty of the scale factor")
    return tuple(missing)
