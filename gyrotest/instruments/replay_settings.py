"""What a station says of a file that is replayed."""

import math
import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Annotated, Any, ClassVar

from gyrotest.errors import UnitError
from gyrotest.recordings.foreign import Window
from gyrotest.recordings.formats.selection import Content, Selection
from gyrotest.records.described import Described
from gyrotest.units import Dimension, OfDimension, Quantity, conversion_factor, same_dimension

_UNITS_OUT = (Dimension.VOLTAGE.value, Dimension.RATE.value, Dimension.COUNT.value)
# The unit of a time column that numbers the samples; its step comes from the sampling rate.
_SAMPLE = "sample"
_NAME = re.compile("[A-Za-z][A-Za-z0-9_]{0,31}")
# Columns that every recording has.
_TAKEN = frozenset({"index", "time_s", "flags"})
_Time = Annotated[Quantity, OfDimension(Dimension.TIME)]


@dataclass(frozen=True, slots=True, kw_only=True)
class AuxiliaryColumn:
    """A column that is recorded beside the gyro's output, and what its numbers mean."""

    __pydantic_config__: ClassVar[Mapping[str, Any]] = {"extra": "forbid", "strict": True}

    column: Annotated[str | int, Described("The column, by name or by number from 1.", "3")]
    unit: Annotated[
        str | None,
        Described("Unit of its values, after `scale`; not needed for a recording of gyrotest.", "rpm"),
    ] = None
    scale: Annotated[float, Described("Factor on its values, before the unit.", "0.1")] = 1.0

    def __post_init__(self) -> None:
        _check_scale(self.scale)
        try:
            _resolved(self.unit)
        except UnitError as error:
            raise ValueError(str(error)) from error

    def unit_out(self, unit: str | None) -> str:
        """Return the unit that is given out: of a kind that gyrotest knows, the one it computes in."""
        known = self.unit or unit
        if known is None:
            raise UnitError(f"the unit of column '{self.column}' is not known; give its 'unit'")
        return next((one.value for one in Dimension if same_dimension(known, one.value)), known)

    def factor(self, unit: str | None) -> float:
        """Return what turns the file's numbers into that unit."""
        return self.scale * conversion_factor(self.unit or unit or "", self.unit_out(unit))


@dataclass(frozen=True, slots=True, kw_only=True)
class ReplaySettings:
    """What is played of a file, and what its numbers mean. Columns by name, or by number from 1."""

    __pydantic_config__: ClassVar[Mapping[str, Any]] = {"extra": "forbid", "strict": True}

    column: Annotated[str | int | None, Described("The column of the values.", "gz")] = None
    columns: Annotated[
        Mapping[str, str | int],
        Described(
            "Of a gyro with several axes: the column of each, in the place of `column`.",
            "{x: gx, y: gy, z: gz}",
        ),
    ] = field(default_factory=dict)
    auxiliary: Annotated[
        Mapping[str, AuxiliaryColumn],
        Described(
            "Columns that are recorded beside: a reference rate, a temperature. A name for each.",
            "{reference: {column: 3, unit: rpm}}",
        ),
    ] = field(default_factory=dict)
    array: Annotated[
        str | None, Described("The array, variable or data set with the column.", "gyro")
    ] = None
    sample_rate: Annotated[
        Quantity | None, OfDimension(Dimension.FREQUENCY), Described("Rows per second.", "100 Hz")
    ] = None
    time_column: Annotated[
        str | int | None, Described("The column (or other array) of the time stamps.", "time")
    ] = None
    time_unit: Annotated[
        str, Described("Unit of the time column; `sample` if it numbers the samples.", "ms")
    ] = "s"
    unit: Annotated[
        str | None,
        Described("Unit of the values, after `scale`: a voltage, a rate, or `count`.", "deg/s"),
    ] = None
    scale: Annotated[float, Described("Factor on the values, before the unit.", "0.05")] = 1.0
    scale_factor: Annotated[
        Quantity | None,
        OfDimension(Dimension.SCALE_FACTOR_COUNT),
        Described(
            "Counts for a rate, where the unit is `count` and rates are wanted; without it counts are given out.",
            "131 count/(deg/s)",
        ),
    ] = None
    start: Annotated[
        Quantity | None,
        OfDimension(Dimension.TIME),
        Described("First time, on the file's scale.", "60 s"),
    ] = None
    end: Annotated[
        Quantity | None, OfDimension(Dimension.TIME), Described("Time before which it ends.", "3660 s")
    ] = None
    first: Annotated[int, Described("First row of data, from 1.", "1")] = 1
    last: Annotated[int | None, Described("Last row of data.", "360000")] = None
    where: Annotated[
        Mapping[str, Content | tuple[Content, ...]],
        Described("Only rows with these contents of columns; one of several in a list.", "{part: z_a}"),
    ] = field(default_factory=dict)
    skip_rows: Annotated[int, Described("Lines left out at the top of a text file.", "3")] = 0
    rewind: Annotated[
        bool, Described("Every acquisition begins anew; else it goes on after the one before.")
    ] = False
    skew: Annotated[
        Mapping[str, _Time],
        Described(
            "How much later than the row's instant a column was sampled, by the name it plays under.",
            "{ua: 28 us, ub: 56 us}",
        ),
    ] = field(default_factory=dict)
    skew_uncertainty: Annotated[
        Quantity | None,
        OfDimension(Dimension.TIME),
        Described("Half-width of the error of the times between the columns.", "0.1 us"),
    ] = None
    filter: Annotated[
        Quantity | None,
        OfDimension(Dimension.FREQUENCY),
        Described("Cut-off of the analogue low-pass that was in front of the converter.", "4 kHz"),
    ] = None

    def __post_init__(self) -> None:
        _check_scale(self.scale)
        if self.sample_rate is not None and self.sample_rate.value <= 0.0:
            raise ValueError(f"sample_rate is {self.sample_rate}; it must be more than 0")
        if self.skip_rows < 0 or self.first < 1 or (self.last is not None and self.last < self.first):
            raise ValueError(
                "rows count from 1, 'last' is not before 'first', and 'skip_rows' not below 0"
            )
        if self.start is not None and self.end is not None and self.end.to("s") <= self.start.to("s"):
            raise ValueError(f"the window ends at {self.end}, not after its start at {self.start}")
        if self.time_unit == _SAMPLE and self.sample_rate is None:
            raise ValueError("time_unit 'sample' needs 'sample_rate'")
        self._check_units()
        self._check_names()
        self._check_timing()

    def _check_timing(self) -> None:
        if self.skew_uncertainty is not None and self.skew_uncertainty.value < 0.0:
            raise ValueError(
                f"skew_uncertainty {self.skew_uncertainty} is a half-width and cannot be negative"
            )
        if self.filter is not None and not self.filter.value > 0.0:
            raise ValueError(f"filter {self.filter} is not more than zero; write e.g. '4 kHz'")

    def _check_names(self) -> None:
        if self.column is not None and self.columns:
            raise ValueError(
                "'column' is for one output and 'columns' for several axes; give one of them"
            )
        for name in (*self.columns, *self.auxiliary):
            if not _NAME.fullmatch(name) or name in _TAKEN:
                raise ValueError(
                    f"'{name}' cannot name a column; write letters, digits and '_', e.g. 'reference'"
                )
        if twice := self.columns.keys() & self.auxiliary.keys():
            raise ValueError(f"'{min(twice)}' is an axis and an auxiliary column at once")

    def _check_units(self) -> None:
        try:
            if self.time_unit != _SAMPLE:
                conversion_factor(self.time_unit, "s")
            if self.unit is not None and not any(same_dimension(self.unit, one) for one in _UNITS_OUT):
                raise ValueError(f"unit '{self.unit}' is neither a voltage nor a rate nor 'count'")
            is_count = self.unit is not None and same_dimension(self.unit, "count")
        except UnitError as error:
            raise ValueError(str(error)) from error
        if self.scale_factor is not None and not is_count:
            raise ValueError(
                "'scale_factor' is for the unit 'count', e.g. '131 count/(deg/s)'; "
                "or give the rate of one count as 'scale' and its unit as 'unit'"
            )
        if self.scale_factor is not None and self.scale_factor.value == 0.0:
            raise ValueError("scale_factor is 0")

    def unit_out(self, unit: str | None) -> str:
        """Return volts, degrees per second or counts, for values in `unit` or in the file's own unit."""
        known = self.unit or unit
        if known is None:
            raise UnitError("the unit of its values is not known; give 'unit', e.g. 'deg/s'")
        if self.scale_factor is not None:
            return Dimension.RATE.value
        out = next((one for one in _UNITS_OUT if same_dimension(known, one)), None)
        if out is None:
            raise UnitError(
                f"its values are in '{known}', which is neither a voltage nor a rate nor 'count'"
            )
        return out

    def factor(self, unit: str | None) -> float:
        """Return what turns the file's numbers into volts, degrees per second or counts."""
        if self.scale_factor is not None:
            return self.scale / self.scale_factor.to(Dimension.SCALE_FACTOR_COUNT.value)
        return self.scale * conversion_factor(self.unit or unit or "", self.unit_out(unit))

    def time_factor_s(self) -> float:
        """Return what turns the numbers of the time column into seconds."""
        if self.time_unit == _SAMPLE and self.sample_rate is not None:
            return 1.0 / self.sample_rate.to("Hz")
        return conversion_factor(self.time_unit, "s")

    def selection(self) -> Selection:
        """Return what is read of the file: the outputs, then the auxiliary columns."""
        outputs: tuple[str | int | None, ...] = tuple(self.columns.values()) or (self.column,)
        return Selection(
            column=outputs[0],
            array=self.array,
            time_column=self.time_column,
            beside=(
                *(one for one in outputs[1:] if one is not None),
                *(one.column for one in self.auxiliary.values()),
            ),
            where=self.where,
            skip_rows=self.skip_rows,
        )

    def window(self) -> Window:
        """Return which rows of it count."""
        return Window(
            first=self.first,
            last=self.last,
            start_s=None if self.start is None else self.start.to("s"),
            end_s=None if self.end is None else self.end.to("s"),
        )


def _check_scale(scale: float) -> None:
    if not math.isfinite(scale) or scale == 0.0:
        raise ValueError(f"scale is {scale:g}; it must be a number other than 0")


def _resolved(unit: str | None) -> None:
    """Raise `UnitError` for what is no unit."""
    if unit is not None:
        same_dimension(unit, unit)
