"""What is read of each file, what its numbers mean, and what they are compared with."""

from collections.abc import Mapping
from dataclasses import dataclass, field

from gyrotest.errors import RecordingError
from gyrotest.records.spec import Gaps
from gyrotest.units import Dimension, Quantity, conversion_factor, same_dimension


@dataclass(frozen=True, slots=True, kw_only=True)
class Window:
    """A part `[begin_s, end_s)` of a record, counted from its first sample."""

    begin_s: float
    end_s: float


@dataclass(frozen=True, slots=True, kw_only=True)
class Conversion:
    """From a file's numbers to a rate in °/s: `number · factor − offset_dps`."""

    factor: float
    offset_dps: float


@dataclass(frozen=True, slots=True, kw_only=True)
class Request:
    """What the user asks for; what is None is left to the file.

    `columns` by name, or by number from 1. `reading_s` is the aperture of one sample, or `duty` the
    part of each interval that it covers. `time_unit` None is s, unless the column's name says otherwise.
    `scale` stands before the unit.
    """

    columns: tuple[str | int, ...] = ()
    array: str | None = None
    where: Mapping[str, str | int | float] = field(default_factory=dict)
    skip_rows: int = 0
    interval_s: float | None = None
    time_column: str | int | None = None
    time_unit: str | None = None
    scale: float = 1.0
    unit: str | None = None
    scale_factor: Quantity | None = None
    zero_rate: Quantity | None = None
    reading_s: float | None = None
    duty: float | None = None
    bandwidth_hz: float | None = None
    window: Window | None = None
    gaps: Gaps = Gaps.REFUSE
    datasheet: Mapping[str, Quantity] = field(default_factory=dict)

    def conversion(self, own_unit: str | None) -> Conversion:
        """Return how numbers become rates; `own_unit` is the file's, where it says so.

        Raises `RecordingError` where that is not known.
        """
        unit = own_unit or self.unit
        if own_unit and self.unit and not _same(own_unit, self.unit):
            raise RecordingError(
                f"is a recording in '{own_unit}', not in '{self.unit}'; leave --unit out, or look at the spec's"
                " 'output.kind'"
            )
        if unit is None:
            raise RecordingError(
                "the unit of its values is not known; give e.g. --unit deg/s, or --unit V and --scale-factor,"
                " or --spec"
            )
        canonical, dimension = canonical_unit(unit)
        factor, scale_factor = self.scale * conversion_factor(unit, canonical), 1.0
        if self.scale_factor is not None:
            scale_factor = self.scale_factor.to(dimension.value)
        elif dimension is not Dimension.NUMBER:
            raise RecordingError(
                f"its values are in '{unit}'; give --scale-factor, e.g. '{dimension.example()}', or --spec"
            )
        zero = 0.0 if self.zero_rate is None else self.zero_rate.to(canonical)
        return Conversion(factor=factor / scale_factor, offset_dps=zero / scale_factor)


def _same(unit: str, other: str) -> bool:
    return same_dimension(unit, other) and conversion_factor(unit, other) == 1.0


def canonical_unit(unit: str) -> tuple[str, Dimension]:
    """Return V, °/s or count for a unit of values, and the dimension of the scale factor for it.

    Raises `RecordingError` for any other unit, and `UnitError` for what is none.
    """
    for canonical, dimension in _SCALE_FACTORS.items():
        if unit == canonical or same_dimension(unit, canonical):
            return canonical, dimension
    raise RecordingError(f"unit '{unit}' is neither a rate nor a voltage nor 'count'")


_SCALE_FACTORS = {
    "deg/s": Dimension.NUMBER,
    "V": Dimension.SCALE_FACTOR_VOLTAGE,
    "count": Dimension.SCALE_FACTOR_COUNT,
}
