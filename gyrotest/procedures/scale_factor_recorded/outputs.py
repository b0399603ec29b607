"""The gyro's output as it was recorded: in the unit that its kind is computed in, no scale factor needed."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gyrotest.errors import InsufficientDataError
from gyrotest.procedures.scaling import OUTPUT_UNITS
from gyrotest.records.plan import Context
from gyrotest.records.recording import SampleFlag, Samples
from gyrotest.records.spec import OutputKind
from gyrotest.units import conversion_factor, printed_unit, same_dimension

REPORTED = {OutputKind.VOLTAGE: "mV/(deg/s)", OutputKind.RATE: "", OutputKind.COUNT: "count/(deg/s)"}
"""The unit in which a scale factor is reported, by the kind of output."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Outputs:
    """Outputs (n,) less the nominal one at rest, in `unit`, and their places on the grid.

    `missing` samples lack between them, in `gaps` gaps.
    """

    values: NDArray[np.float64]
    place: NDArray[np.int64]
    unit: str
    interval_s: float
    gaps: int
    missing: int

    @property
    def slope_unit(self) -> str:
        """Unit of the output per rate, in which slopes are computed."""
        return f"{self.unit}/(deg/s)" if self.unit != "deg/s" else ""

    def part(self, kept: NDArray[np.bool_]) -> "Outputs":
        """Some of the samples; the gaps told stay those of the record."""
        return Outputs(
            values=self.values[kept],
            place=self.place[kept],
            unit=self.unit,
            interval_s=self.interval_s,
            gaps=self.gaps,
            missing=self.missing,
        )


def recorded_outputs(samples: Samples, context: Context) -> Outputs:
    """Return the outputs of a recording; raises `InsufficientDataError` for a bad sample."""
    unit = OUTPUT_UNITS[context.output.kind]
    indicated = samples.sampling.unit
    if not same_dimension(indicated, unit):
        raise InsufficientDataError(
            f"the source gives '{printed_unit(indicated)}', and the spec's output is a"
            f" {context.output.kind.value}: correct 'output.kind', or the unit in the station"
        )
    raw = samples.values[:, 0]
    _refuse_bad(raw, samples.flags, context)
    zero = context.output.zero_rate
    place = _places(samples, context)
    steps = np.diff(place)
    return Outputs(
        values=raw * conversion_factor(indicated, unit) - (0.0 if zero is None else zero.to(unit)),
        place=place,
        unit=unit,
        interval_s=samples.sampling.interval_s,
        gaps=int(np.count_nonzero(steps != 1)),
        missing=int(steps.sum() - steps.size),
    )


def _refuse_bad(values: NDArray[np.float64], flags: NDArray[np.uint8], context: Context) -> None:
    bad = (flags != 0) | ~np.isfinite(values)
    if bad.any():
        first = int(np.flatnonzero(bad)[0])
        kind = SampleFlag(int(flags[first])).name or "not a number"
        raise InsufficientDataError(
            f"{context.case_name}: {int(bad.sum())} of {bad.size} samples are bad, the first of them sample"
            f" {first} ({kind.lower().replace('_', ' ')}); leave them out of what is played"
        )


def _places(samples: Samples, context: Context) -> NDArray[np.int64]:
    if samples.index is not None:
        return samples.index
    places = np.arange(samples.values.shape[0], dtype=np.int64)
    for gap in sorted(context.gaps, key=lambda one: one.after):
        places[places > gap.after] += gap.missing
    return places
