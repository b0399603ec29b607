"""What a scale-factor case may be told, and what it measures."""

from collections.abc import Iterator
from dataclasses import dataclass
from enum import StrEnum
from typing import Annotated

from gyrotest.analysis.step_noise import SHORTEST_STEP
from gyrotest.procedures.scaling import SCALE_FACTORS
from gyrotest.procedures.table_steps import TableParameters, table_complaints
from gyrotest.records.described import Described
from gyrotest.records.result import Measurand
from gyrotest.records.spec import Case, Output, OutputKind, Over
from gyrotest.units import Dimension, OfDimension, Quantity

FEWEST_RATES = 5
"""Rates of a sign below which the certificate says that there are few."""

REPORTED = {OutputKind.VOLTAGE: "mV/(deg/s)", OutputKind.RATE: "", OutputKind.COUNT: "count/(deg/s)"}
"""The unit in which the scale factor of an output is reported."""

TWO_SIDED = ("asymmetry", "scale_factor_forward", "scale_factor_backward")

_WHOLE = 1e-6


class Directions(StrEnum):
    """Whether rates are magnitudes, each turned both ways, or signed."""

    BOTH = "both"
    AS_GIVEN = "as_given"


@dataclass(frozen=True, slots=True, kw_only=True)
class ScaleFactorParameters(TableParameters):
    """Parameters of a scale-factor case; its `duration` is that of each step."""

    rates: Annotated[
        tuple[Annotated[Quantity, OfDimension(Dimension.RATE)], ...],
        Described(
            "rates in the order in which they are turned: magnitudes, each forward and then backward,"
            " or a list of which one is negative, as it is",
            "[10 deg/s, 20 deg/s, 40 deg/s, 60 deg/s, 80 deg/s]",
        ),
    ] = tuple(Quantity(one, "deg/s") for one in (10.0, 20.0, 40.0, 60.0, 80.0))
    directions: Annotated[
        Directions,
        Described("`as_given` takes the rates as they are, though none of them is negative"),
    ] = Directions.BOTH
    rest: Annotated[
        Quantity | None,
        OfDimension(Dimension.TIME),
        Described("length of the records at rest before and after; that of a step by default", "30 s"),
    ] = None

    @property
    def signed_rates_dps(self) -> tuple[float, ...]:
        """The rates of all turns, °/s, in their order."""
        rates = tuple(one.to("deg/s") for one in self.rates)
        if self.directions is Directions.AS_GIVEN or any(one < 0.0 for one in rates):
            return rates
        return tuple(signed for one in rates for signed in (one, -one))


def rates_of_sign(rates_dps: tuple[float, ...], sign: int) -> int:
    """Return how many different rates of a sign there are."""
    return len({one for one in rates_dps if one * sign > 0.0})


def scale_factor_measurands(case: Case, output: Output) -> tuple[Measurand, ...]:
    """Return all that a scale-factor case measures."""
    slope, unit = SCALE_FACTORS[output.kind], REPORTED[output.kind]
    ratio = Dimension.NUMBER
    once = (
        Measurand(name="scale_factor", label="Scale factor", dimension=slope, unit=unit),
        Measurand(
            name="scale_factor_error", label="Scale factor, error to nominal", dimension=ratio, unit="%"
        ),
        Measurand(name="bias", label="Bias", dimension=Dimension.RATE, unit="deg/s"),
        Measurand(name="nonlinearity", label="Nonlinearity, of full scale", dimension=ratio, unit="ppm"),
        Measurand(
            name="nonlinearity_of_tested",
            label="Nonlinearity, of the largest rate tested",
            dimension=ratio,
            unit="ppm",
        ),
        Measurand(name="asymmetry", label="Scale-factor asymmetry", dimension=ratio, unit="ppm"),
        Measurand(
            name="scale_factor_forward", label="Scale factor, forward", dimension=slope, unit=unit
        ),
        Measurand(
            name="scale_factor_backward", label="Scale factor, backward", dimension=slope, unit=unit
        ),
        Measurand(
            name="rest_difference",
            label="Output at rest, after less before",
            dimension=Dimension.RATE,
            unit="deg/h",
        ),
    )
    if case.repeats < 2:
        return once
    return (
        *once,
        Measurand(
            name="scale_factor_repeatability",
            label="Scale-factor repeatability",
            dimension=ratio,
            unit="ppm",
            over=Over.REPEATS,
        ),
    )


def scale_factor_complaints(
    case: Case, parameters: ScaleFactorParameters, output: Output
) -> Iterator[tuple[str, str]]:
    """Give what is wrong with a scale-factor case beyond its types: key and message."""
    yield from table_complaints(case, parameters, output)
    yield from _rate_complaints(case, parameters)
    if output.full_scale is None and "nonlinearity" in case.limits:
        message = "is in proportion to full scale; write 'output.full_scale', or limit 'nonlinearity_of_tested'"
        yield "limits.nonlinearity", message
    if parameters.rest is not None:
        yield from _rest_complaints(case, parameters.rest)


def _rate_complaints(case: Case, parameters: ScaleFactorParameters) -> Iterator[tuple[str, str]]:
    rates = parameters.signed_rates_dps
    zeros = [place for place, one in enumerate(parameters.rates) if one.value == 0.0]
    for place in zeros:
        message = "is no turn; the output at rest is recorded before and after in any case"
        yield f"parameters.rates[{place}]", message
    if len(parameters.rates) < 2 or len(set(rates)) < 2:
        given = len(set(parameters.rates))
        message = f"{given} rate is too few for a scale factor; two at least, e.g. [10 deg/s, 20 deg/s]"
        yield "parameters.rates", message
        return
    if not zeros and min(rates_of_sign(rates, 1), rates_of_sign(rates, -1)) < 2:
        for name in TWO_SIDED:
            if name in case.limits:
                yield f"limits.{name}", "needs two rates of each sign; see 'parameters.rates'"


def _rest_complaints(case: Case, rest: Quantity) -> Iterator[tuple[str, str]]:
    intervals = rest.to("s") / case.interval.to("s")
    if rest.value <= 0.0 or abs(intervals - round(intervals)) > _WHOLE * intervals:
        yield "parameters.rest", f"'{rest}' is no whole number of intervals of '{case.interval}'"
    elif round(intervals) < SHORTEST_STEP:
        shortest = SHORTEST_STEP * case.interval.to("s")
        yield (
            "parameters.rest",
            f"'{rest}' is too short for its mean's uncertainty; at least {shortest:g} s",
        )
