"""What a measurement-range case may be told, and what it measures."""

import math
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise
from typing import Annotated

from gyrotest.procedures.table_steps import TableParameters, table_complaints
from gyrotest.records.described import Described
from gyrotest.records.result import Measurand
from gyrotest.records.spec import Case, Output
from gyrotest.units import Dimension, OfDimension, Quantity

_STEPS = 12
_MOST_STEPS = 200
_WHOLE = 1e-9


@dataclass(frozen=True, slots=True, kw_only=True)
class FullScaleParameters(TableParameters):
    """Parameters of a measurement-range case; its `duration` is that of each step."""

    linearity: Annotated[
        Quantity,
        OfDimension(Dimension.NUMBER),
        Described("how far from the line the output may be, in proportion to full scale", "0.1 %"),
    ]
    rates: Annotated[
        tuple[Annotated[Quantity, OfDimension(Dimension.RATE)], ...],
        Described("magnitudes that rise, each turned both ways", "[25 deg/s, 50 deg/s, 100 deg/s]"),
    ] = ()
    up_to: Annotated[
        Quantity | None,
        OfDimension(Dimension.RATE),
        Described("largest rate, where no rates are given: reached in equal steps", "120 deg/s"),
    ] = None
    steps: Annotated[int, Described("how many steps lead to `up_to`", "12")] = _STEPS
    line_to: Annotated[
        Quantity | None,
        OfDimension(Dimension.RATE),
        Described(
            "the line is fitted to the steps up to this rate; half of full scale by default", "50 deg/s"
        ),
    ] = None

    @property
    def magnitudes_dps(self) -> tuple[float, ...]:
        """The magnitudes that are turned both ways, °/s."""
        if self.rates or self.up_to is None:
            return tuple(one.to("deg/s") for one in self.rates)
        largest = self.up_to.to("deg/s")
        return tuple(largest * step / self.steps for step in range(1, self.steps + 1))

    def line_to_dps(self, output: Output) -> float:
        """Return the rate up to which steps make the line; infinite where nothing is known of it."""
        if self.line_to is not None:
            return self.line_to.to("deg/s")
        return math.inf if output.full_scale is None else 0.5 * output.full_scale.to("deg/s")


def range_measurands() -> tuple[Measurand, ...]:
    """Return all that a measurement-range case measures."""
    return tuple(
        Measurand(name=name, label=label, dimension=Dimension.RATE, unit="deg/s")
        for name, label in RANGE_LABELS.items()
    )


RANGE_LABELS = {
    "measurement_range": "Measurement range, both ways",
    "measurement_range_forward": "Measurement range, forward",
    "measurement_range_backward": "Measurement range, backward",
}


def range_complaints(
    case: Case, parameters: FullScaleParameters, output: Output
) -> Iterator[tuple[str, str]]:
    """Give what is wrong with a measurement-range case beyond its types: key and message."""
    yield from table_complaints(case, parameters, output)
    if parameters.linearity.value <= 0.0:
        yield "parameters.linearity", f"'{parameters.linearity}' is not more than zero"
    faults = tuple(_rate_complaints(parameters))
    yield from faults
    if output.full_scale is None:
        yield "procedure", "needs 'output.full_scale', to which the linearity is in proportion"
    elif not faults:
        yield from _reach_complaints(parameters, output, output.full_scale)


def _rate_complaints(parameters: FullScaleParameters) -> Iterator[tuple[str, str]]:
    if not parameters.rates and parameters.up_to is None:
        yield "parameters", "gives neither 'up_to' nor 'rates'; write e.g. 'up_to: 120 deg/s'"
    elif parameters.rates and parameters.up_to is not None:
        yield "parameters.up_to", "stands beside 'rates'; remove one of the two"
    elif parameters.up_to is not None and parameters.up_to.value <= 0.0:
        yield "parameters.up_to", f"'{parameters.up_to}' is not more than zero"
    elif not 2 <= parameters.steps <= _MOST_STEPS:
        yield "parameters.steps", f"{parameters.steps} is not between 2 and {_MOST_STEPS}"
    else:
        magnitudes = (0.0, *parameters.magnitudes_dps)
        if any(later <= one for one, later in pairwise(magnitudes)):
            yield (
                "parameters.rates",
                "do not rise from above zero; they are magnitudes, turned both ways",
            )


def _reach_complaints(
    parameters: FullScaleParameters, output: Output, full_scale: Quantity
) -> Iterator[tuple[str, str]]:
    magnitudes, place = parameters.magnitudes_dps, "rates" if parameters.rates else "up_to"
    if magnitudes[-1] < full_scale.to("deg/s") * (1.0 - _WHOLE):
        yield f"parameters.{place}", f"does not reach full scale, '{full_scale}'"
    line_to = parameters.line_to_dps(output)
    if sum(one <= line_to * (1.0 + _WHOLE) for one in magnitudes) < 2:
        message = f"leaves fewer than two steps for the line, up to {line_to:g} deg/s; see 'line_to'"
        yield f"parameters.{place}", message
