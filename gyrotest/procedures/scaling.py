"""From what a source indicates to the gyro's output and to a rate."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gyrotest.errors import InsufficientDataError
from gyrotest.records.spec import Output, OutputKind
from gyrotest.units import Dimension, conversion_factor, printed_unit, same_dimension

OUTPUT_UNITS = {OutputKind.VOLTAGE: "V", OutputKind.RATE: "deg/s", OutputKind.COUNT: "count"}
"""The unit in which an output of a kind is computed."""

SCALE_FACTORS = {
    OutputKind.VOLTAGE: Dimension.SCALE_FACTOR_VOLTAGE,
    OutputKind.RATE: Dimension.NUMBER,
    OutputKind.COUNT: Dimension.SCALE_FACTOR_COUNT,
}
"""What a scale factor is of, by the kind of output; the value is the unit in which it is computed."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Scaling:
    """From an indication to a rate: `(indication·to_canonical − zero)/scale_factor`.

    `zero` is in `unit` (V, °/s or counts), `scale_factor`, the nominal one, in `unit` per °/s.
    """

    to_canonical: float
    zero: float
    scale_factor: float
    unit: str

    @property
    def slope_unit(self) -> str:
        """The unit of an output over a rate: `unit` per °/s, a number where both are rates."""
        return "" if self.unit == "deg/s" else f"{self.unit}*s/deg"

    def spread_dps(self, indication: float) -> float:
        """Return a spread (always positive) of the indication as a rate, °/s."""
        return abs(indication * self.to_canonical / self.scale_factor)

    def rates_dps(self, values: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return indications as rates, in one new array, or as they are where that is the same."""
        factor = self.to_canonical / self.scale_factor
        return _scaled(values, factor, self.zero / self.scale_factor)

    def outputs(self, values: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return indications as the output less the nominal one at rest, in `unit`."""
        return _scaled(values, self.to_canonical, self.zero)


def _scaled(values: NDArray[np.float64], factor: float, offset: float) -> NDArray[np.float64]:
    if factor == 1.0 and offset == 0.0:
        return values
    scaled = values * factor
    scaled -= offset
    scaled.setflags(write=False)
    return scaled


def nominal_complaints(output: Output) -> Iterator[tuple[str, str]]:
    """Give what a procedure that turns outputs into rates by the nominal scale factor has to complain of."""
    if output.kind is OutputKind.COUNT and output.scale_factor is None:
        yield (
            "procedure",
            "turns counts into rates and needs 'output.scale_factor' for it, e.g. '131 count/(deg/s)'",
        )


def output_scaling(output: Output, unit: str) -> Scaling:
    """Return how an indication in a unit becomes a rate; raises `InsufficientDataError`."""
    kind, canonical = output.kind, OUTPUT_UNITS[output.kind]
    if output.scale_factor is None and kind is not OutputKind.RATE:
        what = "a voltage is" if kind is OutputKind.VOLTAGE else "counts are"
        raise InsufficientDataError(f"output.scale_factor is not given; {what} no rate without it")
    if not same_dimension(unit, canonical):
        raise InsufficientDataError(
            f"the source gives '{printed_unit(unit)}', and the spec's output is a {kind.value}:"
            " correct 'output.kind', or the unit in the station"
        )
    scale_factor = output.scale_factor
    return Scaling(
        to_canonical=conversion_factor(unit, canonical),
        zero=0.0 if output.zero_rate is None else output.zero_rate.to(canonical),
        scale_factor=1.0 if scale_factor is None else scale_factor.to(SCALE_FACTORS[kind]),
        unit=canonical,
    )
