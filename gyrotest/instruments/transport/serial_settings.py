"""What a station may say of an instrument's serial line."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Annotated, Any, ClassVar

from gyrotest.instruments.transport.channel import FlowControl, Parity, SerialLine
from gyrotest.records.described import Described


# Without slots: of two records with slots, one record cannot be made.
@dataclass(frozen=True, kw_only=True)
class SerialSettings:
    """The settings of a serial line, in a station beside the instrument's own."""

    __pydantic_config__: ClassVar[Mapping[str, Any]] = {"extra": "forbid", "strict": True}

    baud_rate: Annotated[int, Described("RS-232: bits per second.", "9600")] = 9600
    data_bits: Annotated[int, Described("RS-232: 7 or 8 bits.", "8")] = 8
    parity: Annotated[Parity, Described("RS-232: parity bit.", "none")] = Parity.NONE
    stop_bits: Annotated[int, Described("RS-232: 1 or 2 stop bits.", "1")] = 1
    flow_control: Annotated[FlowControl, Described("RS-232: handshake.", "none")] = FlowControl.NONE

    @property
    def line(self) -> SerialLine:
        """The serial line; raises `ValueError` of what none can be set to."""
        return SerialLine(
            baud_rate=self.baud_rate,
            data_bits=self.data_bits,
            parity=self.parity,
            stop_bits=self.stop_bits,
            flow_control=self.flow_control,
        )
