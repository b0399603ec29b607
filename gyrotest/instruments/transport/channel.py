"""What carries the bytes to an instrument and back: the seam between a conversation and the wire."""

from collections.abc import Callable
from dataclasses import dataclass
from enum import StrEnum
from typing import Protocol


class Parity(StrEnum):
    """Parity bit of a serial line."""

    NONE = "none"
    EVEN = "even"
    ODD = "odd"


class FlowControl(StrEnum):
    """Handshake of a serial line."""

    NONE = "none"
    XON_XOFF = "xon_xoff"
    RTS_CTS = "rts_cts"
    DTR_DSR = "dtr_dsr"


@dataclass(frozen=True, slots=True, kw_only=True)
class SerialLine:
    """How a serial line is set; of no effect on other interfaces."""

    baud_rate: int = 9600
    data_bits: int = 8
    parity: Parity = Parity.NONE
    stop_bits: int = 1
    flow_control: FlowControl = FlowControl.NONE

    def __post_init__(self) -> None:
        for name, accepted in (("data_bits", (7, 8)), ("stop_bits", (1, 2))):
            if getattr(self, name) not in accepted:
                raise ValueError(
                    f"{name} {getattr(self, name)} is none of {accepted[0]} and {accepted[1]}"
                )
        if self.baud_rate <= 0:
            raise ValueError(f"baud_rate {self.baud_rate} is not more than zero; write e.g. 9600")

    @property
    def seconds_per_byte(self) -> float:
        """Time that one byte takes, start, parity and stop bits included."""
        bits = 1 + self.data_bits + (self.parity is not Parity.NONE) + self.stop_bits
        return bits / self.baud_rate


class Channel(Protocol):
    """Bytes to and from one instrument.

    `seconds_per_byte` is 0 where the transfer takes no time worth counting. `longest_wait_s` is the
    longest time that the way to the instrument waits for the first byte of a reply (None: any time).
    `remote_by_command` says that remote and local are commands here and no interface messages.
    Every method but `close` raises `TimeoutError` after a time-out and `OSError` for all else.
    """

    seconds_per_byte: float
    longest_wait_s: float | None
    remote_by_command: bool

    def unread(self) -> bytes:
        """What has arrived without being asked for; raises at once if the peer has gone."""

    def send(self, data: bytes) -> None:
        """Send all the bytes."""

    def receive_line(self, timeout_s: float) -> bytes:
        """The bytes up to and including the next line feed (or the message's end)."""

    def receive_exactly(self, count: int, timeout_s: float) -> bytes:
        """That many bytes, whatever they are."""

    def clear(self) -> None:
        """Device clear where the interface has one; forget what has arrived."""

    def go_to_local(self) -> None:
        """Give the front panel back where the interface has a message for it."""

    def close(self) -> None:
        """Disconnect; never raises."""


Connect = Callable[[str, SerialLine, float], Channel]
