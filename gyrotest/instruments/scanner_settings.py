"""The settings of a multimeter scanner: its gyro channels, and the channels recorded beside them."""

import math
import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import StrEnum
from typing import Annotated, Any, ClassVar

from gyrotest.instruments.transport.channel import FlowControl
from gyrotest.instruments.transport.serial_settings import SerialSettings
from gyrotest.instruments.voltage import MeterSettings, check_nplc
from gyrotest.records.described import Described
from gyrotest.units import Dimension, OfDimension, Quantity

_NPLC = (0.02, 0.2, 1.0, 2.0, 10.0, 20.0, 100.0, 200.0)
_RANGES_V = (0.1, 1.0, 10.0, 100.0, 300.0)
_CHANNEL = re.compile(r"[1-3]\d\d")


class Function(StrEnum):
    """What is measured on a channel beside the gyro's output."""

    VOLTAGE = "voltage"
    THERMOCOUPLE = "thermocouple"
    RTD = "rtd"
    FOUR_WIRE_RTD = "four_wire_rtd"
    THERMISTOR = "thermistor"


# How the instrument calls a probe, and the types of it that it knows; the first one is the usual.
PROBES: Mapping[Function, str] = {
    Function.THERMOCOUPLE: "TC",
    Function.RTD: "RTD",
    Function.FOUR_WIRE_RTD: "FRTD",
    Function.THERMISTOR: "THER",
}
_TYPES: Mapping[Function, tuple[str, ...]] = {
    Function.THERMOCOUPLE: ("K", "B", "E", "J", "N", "R", "S", "T"),
    Function.RTD: ("85", "91"),
    Function.FOUR_WIRE_RTD: ("85", "91"),
    Function.THERMISTOR: ("5000", "2252", "10000"),
}


@dataclass(frozen=True, slots=True, kw_only=True)
class BesideChannel:
    """A channel that is recorded beside the gyro's output: a temperature, or a voltage that stands for one."""

    __pydantic_config__: ClassVar[Mapping[str, Any]] = {"extra": "forbid", "strict": True}

    function: Annotated[Function, Described("What is connected there.", "thermocouple")]
    type: Annotated[
        str | None,
        Described(
            "The probe's type: a thermocouple's letter, 85 or 91 of an RTD, 2252, 5000 or 10000 of a"
            " thermistor; quoted where it is a number.",
            "K",
        ),
    ] = None
    nplc: Annotated[
        float | None, Described("Integration time in power-line cycles, where it is its own.", "1")
    ] = None
    range: Annotated[
        Quantity | None,
        OfDimension(Dimension.VOLTAGE),
        Described("Measuring range of a voltage, where it is its own.", "1 V"),
    ] = None
    unit: Annotated[str, Described("The unit of what a voltage stands for.", "degC")] = "V"
    per_volt: Annotated[float, Described("How much of that unit a volt is.", "100")] = 1.0
    at_zero_volt: Annotated[float, Described("What zero volts are, in that unit.", "-50")] = 0.0

    def __post_init__(self) -> None:
        types = _TYPES.get(self.function)
        if types is None:
            if self.type is not None:
                raise ValueError("a voltage has no type; leave 'type' out")
        elif self.probe_type not in types:
            raise ValueError(
                f"type {self.type} is none of a {self.function}'s: write one of {', '.join(types)}"
            )
        if types is not None and (self.range is not None or self.unit != "V"):
            raise ValueError(f"a {self.function} gives °C; leave 'range' and 'unit' out")
        if not (math.isfinite(self.per_volt) and self.per_volt and math.isfinite(self.at_zero_volt)):
            raise ValueError(f"per_volt {self.per_volt:g} is no scale; write e.g. 100 for 10 mV/°C")
        if self.nplc is not None:
            check_nplc(self.nplc, _NPLC, "34970A")
        if self.range is not None:
            check_scanner_range(self.range)

    @property
    def probe_type(self) -> str:
        """The type of a temperature probe, the usual one where none is given."""
        return _TYPES[self.function][0] if self.type is None else self.type.upper()

    @property
    def printed(self) -> str:
        """The unit of what is recorded."""
        return "degC" if self.is_temperature else self.unit

    @property
    def is_temperature(self) -> bool:
        """Whether the instrument itself gives °C."""
        return self.function is not Function.VOLTAGE


_PLAIN = BesideChannel(function=Function.VOLTAGE)


@dataclass(frozen=True, slots=True, kw_only=True)
class Keysight34970ASettings(SerialSettings, MeterSettings):
    """The station's settings of a 34970A, 34972A, DAQ970A or DAQ973A; the serial ones count on RS-232 only."""

    nplc: Annotated[float, Described("Integration time of a reading in power-line cycles.", "1")] = 1.0
    beside: Annotated[
        Mapping[str, BesideChannel],
        Described(
            "What is connected to the channels that slots name as 'auxiliary'; a plain voltage where"
            " nothing is said.",
            "{'102': {function: thermocouple, type: K}}",
        ),
    ] = field(default_factory=dict)
    baud_rate: Annotated[int, Described("RS-232: bits per second.", "57600")] = 57_600
    flow_control: Annotated[
        FlowControl, Described("RS-232: handshake; the scanner's own is `xon_xoff`.", "xon_xoff")
    ] = FlowControl.NONE

    def __post_init__(self) -> None:
        _ = self.line  # checks the serial settings
        check_scanner_range(self.range)
        check_nplc(self.nplc, _NPLC, "34970A")
        for channel in self.beside:
            if not is_channel(channel):
                raise ValueError(f"'{channel}' is no channel; write slot and channel, e.g. '102'")

    def at(self, channel: str) -> BesideChannel:
        """What is connected to an auxiliary channel."""
        return self.beside.get(channel, _PLAIN)


def is_channel(text: str) -> bool:
    """Whether this is a channel's number: a slot of 1 to 3 and two digits."""
    return _CHANNEL.fullmatch(text) is not None and not text.endswith("00")


def check_scanner_range(voltage: Quantity) -> None:
    """Refuse what is no range of the scanner; raises `ValueError`."""
    if not any(math.isclose(voltage.to("V"), known) for known in _RANGES_V):
        known = ", ".join(f"{one:g} V" for one in _RANGES_V)
        raise ValueError(f"range {voltage} is none of the scanner's: write one of {known}")
