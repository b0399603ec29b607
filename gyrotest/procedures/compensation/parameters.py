"""What a compensation case may be told, and what is wrong with it."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Annotated

from gyrotest.procedures.case_plan import plan_of_steps, step_samples
from gyrotest.procedures.table_steps import TableParameters, table_complaints
from gyrotest.records.described import Described, EarlierCase
from gyrotest.records.plan import Plan
from gyrotest.records.spec import Case, Output
from gyrotest.units import Dimension, OfDimension, Quantity

_RATES = tuple(Quantity(one, "deg/s") for one in (15.0, 30.0, 50.0, 70.0))


@dataclass(frozen=True, slots=True, kw_only=True)
class CompensationParameters(TableParameters):
    """Parameters of a compensation case; its `duration` is that of each step."""

    scale_factor_from: Annotated[
        str,
        EarlierCase("scale_factor"),
        Described(
            "the `scale_factor` case, which stands before this one, whose scale factor and bias are applied",
            "scale_factor",
        ),
    ]
    rates: Annotated[
        tuple[Annotated[Quantity, OfDimension(Dimension.RATE)], ...],
        Described(
            "rates of the verification, best others than those of the fit: magnitudes, each forward and "
            "then backward, or a list of which one is negative, as it is",
            "[15 deg/s, 30 deg/s, 50 deg/s, 70 deg/s]",
        ),
    ] = _RATES

    @property
    def signed_rates_dps(self) -> tuple[float, ...]:
        """The rates of all turns, °/s, in their order."""
        rates = tuple(one.to("deg/s") for one in self.rates)
        if any(one < 0.0 for one in rates):
            return rates
        return tuple(signed for one in rates for signed in (one, -one))


def compensation_plan(case: Case, parameters: CompensationParameters) -> Plan:
    """Return a step at rest, one at each rate, and one at rest again."""
    samples = step_samples(case)
    steps = (
        parameters.step("rest before", 0.0, samples),
        *(parameters.step("verification", one, samples) for one in parameters.signed_rates_dps),
        parameters.step("rest after", 0.0, samples),
    )
    return plan_of_steps(case, steps)


def compensation_complaints(
    case: Case, parameters: CompensationParameters, output: Output
) -> Iterator[tuple[str, str]]:
    """Give what is wrong with a compensation case beyond its types: key and message."""
    yield from table_complaints(case, parameters, output)
    if not parameters.scale_factor_from.strip():
        yield (
            "parameters.scale_factor_from",
            "is empty; name the case of procedure 'scale_factor' before this one",
        )
    if not parameters.rates:
        yield "parameters.rates", "is empty; give rates of the verification, e.g. [15 deg/s, 50 deg/s]"
    for place, one in enumerate(parameters.rates):
        if one.value == 0.0:
            message = "is no turn; the output at rest is recorded before and after in any case"
            yield f"parameters.rates[{place}]", message
