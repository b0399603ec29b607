"""What a simulated meter consists of: its model, settings, registers, readings under way."""

import math
from collections.abc import Iterator
from dataclasses import dataclass
from enum import Enum, auto


class Interface(Enum):
    """Over what a message came."""

    SOCKET = auto()
    SERIAL = auto()
    GPIB = auto()


class HangUp(Exception):  # noqa: N818 - an event, not an error
    """The meter closes the connection."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Model:
    """A multimeter model: what distinguishes one personality from another."""

    name: str
    manufacturer: str
    firmware: str
    scpi_version: str
    nplc: tuple[float, ...]
    memory: int
    keeps_newest: bool
    most_samples: int
    delay_each_sample: bool
    serial_needs_remote: bool


@dataclass(slots=True, kw_only=True)
class Settings:
    """What `*RST` resets."""

    range_v: float | None = None
    nplc: float = 10.0
    autozero: bool = True
    high_impedance: bool = False
    trigger_source: str = "IMM"
    trigger_count: float = 1.0
    trigger_delay_s: float | None = None
    samples: int = 1
    timed: bool = False
    timer_s: float = 1.0
    binary: bool = False
    swapped: bool = False
    display: bool = True
    text: str = ""


@dataclass(slots=True, kw_only=True)
class Acquisition:
    """Readings under way: `done` of `count`, the first begun at `start_s`, one every `spacing_s`."""

    start_s: float
    aperture_s: float
    spacing_s: float
    busy_s: float
    count: float
    done: int = 0

    @property
    def end_s(self) -> float:
        """When the last reading is ready, s."""
        return self.start_s + (self.count - 1) * self.spacing_s + self.busy_s

    def ready(self, now_s: float) -> int:
        """How many readings are there by now."""
        if now_s >= self.end_s - 1e-9:
            return int(self.count)
        since_first_s = now_s - self.start_s - self.busy_s
        return max(0, math.floor((since_first_s + 1e-9) / self.spacing_s) + 1)


@dataclass(slots=True, kw_only=True)
class Status:
    """The registers of IEEE 488.2 and SCPI that programs ask for."""

    event: int = 0
    event_enable: int = 0
    service_enable: int = 0
    questionable_event: int = 0
    questionable_enable: int = 0


@dataclass(slots=True, kw_only=True)
class Reply:
    """A reply on its way: parts of it and when each is ready, s."""

    parts: Iterator[tuple[float, bytes]] | tuple[tuple[float, bytes], ...]
