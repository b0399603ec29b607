"""What a station says of a board that prints its readings line by line."""

import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Annotated, Any, ClassVar

from gyrotest.instruments.transport.channel import Parity
from gyrotest.records.described import Described
from gyrotest.units import Dimension, OfDimension, Quantity, same_dimension

_OUTPUTS = (Dimension.RATE, Dimension.VOLTAGE, Dimension.COUNT)
# A counter that begins anew sooner than this says no more than the jitter of a host does.
_SHORTEST_PERIOD_S = 0.125

_Output = Annotated[Quantity, OfDimension(*_OUTPUTS)]
_Any = Annotated[Quantity, OfDimension()]


@dataclass(frozen=True, slots=True, kw_only=True)
class LineStreamSettings:
    """How the lines are built, and what the numbers in them mean."""

    __pydantic_config__: ClassVar[Mapping[str, Any]] = {"extra": "forbid", "strict": True}

    sample_rate: Annotated[
        Quantity, OfDimension(Dimension.FREQUENCY), Described("Lines per second.", "100 Hz")
    ]
    channels: Annotated[
        Mapping[str, _Output],
        Described(
            "The outputs, by the name of their column or group: what a number 1 there stands for. "
            "Rates, voltages or counts, all of one kind.",
            "{gx: 1 deg/s, gy: 1 deg/s, gz: 0.061 deg/s}",
        ),
    ]
    columns: Annotated[
        tuple[str, ...],
        Described("Names of a line's fields, in order; fields that are not used need a name too."),
    ] = ()
    separator: Annotated[
        str, Described("What separates the fields; without it, spaces and tabs.", "';'")
    ] = ","
    pattern: Annotated[
        str | None,
        Described(
            "In place of columns: a regular expression for the whole line, a named group for each number.",
            r"'G (?P<gx>\S+) (?P<gy>\S+) T (?P<t>\S+)'",
        ),
    ] = None
    auxiliary: Annotated[
        Mapping[str, _Any],
        Described(
            "What is recorded beside, by its column or group: what a number 1 there stands for.",
            "{temperature: 0.01 degC}",
        ),
    ] = field(default_factory=dict)
    counter: Annotated[
        str | None,
        Described("The column or group that counts the lines. With it, every loss is found.", "n"),
    ] = None
    counter_modulus: Annotated[
        int | None, Described("The number at which the counter begins at 0 again.", "256")
    ] = None
    counter_step: Annotated[int, Described("By how much it grows from line to line.", "1")] = 1
    range: Annotated[
        Quantity | None,
        OfDimension(*_OUTPUTS),
        Described("Full scale of the outputs; a value at it or beyond is an overload.", "250 deg/s"),
    ] = None
    baud_rate: Annotated[int, Described("Bits per second, of a serial line.", "921600")] = 115200
    parity: Annotated[Parity, Described("Parity bit, of a serial line.", "even")] = Parity.NONE
    start: Annotated[
        str, Described("Text that makes the board send, with its line end.", r'"start\r\n"')
    ] = ""
    stop: Annotated[
        str, Described("Text that makes the board stop, with its line end.", r'"stop\r\n"')
    ] = ""
    ask_serial_number: Annotated[
        str, Described("Text that asks for the unit's serial number, with its line end.", r'"id?\n"')
    ] = ""
    serial_number_pattern: Annotated[
        str | None,
        Described(
            "A regular expression that finds the serial number in a line: its first group.",
            r"'SN (\S+)'",
        ),
    ] = None

    def __post_init__(self) -> None:
        _check_rate(self)
        _check_outputs(self)
        _check_fields(self)
        _check_counter(self)
        _check_question(self)

    @property
    def unit(self) -> str:
        """The unit of the outputs, in the words of a sampling."""
        first = next(iter(self.channels.values()))
        return next(one.value for one in _OUTPUTS if same_dimension(one.value, first.unit))


def _check_rate(settings: LineStreamSettings) -> None:
    if settings.sample_rate.to("Hz") <= 0.0:
        raise ValueError(
            f"sample_rate {settings.sample_rate} is not more than zero; write e.g. '100 Hz'"
        )


def _check_outputs(settings: LineStreamSettings) -> None:
    if not settings.channels:
        raise ValueError("channels is empty: name the outputs and what a number 1 stands for")
    values = [*settings.channels.items(), *((("range", settings.range),) if settings.range else ())]
    first = values[0]
    for name, value in values[1:]:
        if not same_dimension(value.unit, first[1].unit):
            raise ValueError(
                f"{name} is in {value.unit}, {first[0]} in {first[1].unit}: give one kind of unit"
            )
    for name, value in (*values, *settings.auxiliary.items()):
        if value.value == 0.0:
            raise ValueError(f"{name} {value}: a number 1 cannot stand for zero")


def _check_fields(settings: LineStreamSettings) -> None:
    if (settings.pattern is None) == (not settings.columns):
        raise ValueError("give either columns or pattern")
    names = settings.columns if settings.pattern is None else _groups(settings.pattern)
    counter = () if settings.counter is None else (settings.counter,)
    wanted = (*settings.channels, *settings.auxiliary, *counter)
    unknown = [name for name in wanted if name not in names]
    if unknown:
        raise ValueError(
            f"{', '.join(unknown)}: no such column or group; there are {', '.join(names) or 'none'}"
        )
    if len(set(wanted)) < len(wanted) or len(set(names)) < len(names):
        raise ValueError("a column or group is named twice; each is one channel, auxiliary or counter")


def _groups(pattern: str) -> tuple[str, ...]:
    try:
        return tuple(re.compile(pattern.encode()).groupindex)
    except re.error as error:
        raise ValueError(f"pattern {pattern!r} is no regular expression: {error}") from None


def _check_counter(settings: LineStreamSettings) -> None:
    if (settings.counter is None) != (settings.counter_modulus is None):
        raise ValueError("counter and counter_modulus belong together: give both or none")
    modulus, step = settings.counter_modulus, settings.counter_step
    if modulus is None:
        return
    if step < 1 or modulus < 2 * step or modulus % step:
        raise ValueError(
            f"counter_modulus {modulus} must be a multiple of counter_step {step}, twice at least"
        )
    period_s = modulus / step / settings.sample_rate.to("Hz")
    if period_s < _SHORTEST_PERIOD_S:
        raise ValueError(
            f"the counter begins anew after {period_s:g} s; below {_SHORTEST_PERIOD_S:g} s it does not help:"
            " leave counter out"
        )


def _check_question(settings: LineStreamSettings) -> None:
    asked, pattern = bool(settings.ask_serial_number), settings.serial_number_pattern
    if asked != (pattern is not None):
        raise ValueError(
            "ask_serial_number and serial_number_pattern belong together: give both or none"
        )
    if pattern is None:
        return
    try:
        groups = re.compile(pattern).groups
    except re.error as error:
        raise ValueError(f"serial_number_pattern is no regular expression: {error}") from None
    if not groups:
        raise ValueError("serial_number_pattern has no group; put the serial number in parentheses")
