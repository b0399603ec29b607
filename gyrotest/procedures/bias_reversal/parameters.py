"""What a bias-reversal case may be told, and what it measures."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Annotated

from gyrotest.procedures.table_steps import TableParameters, table_complaints
from gyrotest.records.described import Described, EarlierCase
from gyrotest.records.result import Measurand
from gyrotest.records.spec import Case, Output
from gyrotest.units import Dimension, OfDimension, Quantity

_RATE = Quantity(40.0, "deg/s")


@dataclass(frozen=True, slots=True, kw_only=True)
class BiasReversalParameters(TableParameters):
    """Parameters of a bias-reversal case; its `duration` is that of each of the two steps."""

    rate: Annotated[
        Quantity,
        OfDimension(Dimension.RATE),
        Described("the rate that is turned forward and then backward", "40 deg/s"),
    ] = _RATE
    scale_factor_from: Annotated[
        str | None,
        EarlierCase(),
        Described(
            "an earlier case of the spec whose scale factor and asymmetry are used; the nominal one by default",
            "scale_factor",
        ),
    ] = None
    asymmetry: Annotated[
        Quantity | None,
        OfDimension(Dimension.NUMBER),
        Described(
            "how far forward and backward scale factors may be apart, in proportion to them, where no case"
            " measured it; without it the bias cannot be judged with a guard band",
            "200 ppm",
        ),
    ] = None


def reversal_measurands() -> tuple[Measurand, ...]:
    """Return all that a bias-reversal case measures."""
    return (Measurand(name="bias", label="Bias, by reversal", dimension=Dimension.RATE, unit="deg/s"),)


def reversal_complaints(
    case: Case, parameters: BiasReversalParameters, output: Output
) -> Iterator[tuple[str, str]]:
    """Give what is wrong with a bias-reversal case beyond its types: key and message."""
    yield from table_complaints(case, parameters, output)
    if parameters.rate.value <= 0.0:
        yield "parameters.rate", f"'{parameters.rate}' is not more than zero; it is turned both ways"
    asymmetry = parameters.asymmetry
    if asymmetry is None:
        return
    if asymmetry.value < 0.0:
        yield "parameters.asymmetry", f"'{asymmetry}' is less than zero"
    elif parameters.scale_factor_from is not None:
        case_name = parameters.scale_factor_from
        yield "parameters.asymmetry", f"is measured by case '{case_name}'; remove one of the two"
