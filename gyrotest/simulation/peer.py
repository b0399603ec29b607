"""What a simulated instrument is to the bench, and what it is made from."""

import zlib
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Protocol, runtime_checkable

import numpy as np
from numpy.typing import NDArray

from gyrotest.ports import Clock
from gyrotest.records.station import Instrument, Station
from gyrotest.simulation.dialogue import Dialogue, Speaker
from gyrotest.simulation.faults import Faults
from gyrotest.simulation.meter_state import Interface
from gyrotest.simulation.occasion import Occasion
from gyrotest.simulation.scenarios import Scenario
from gyrotest.simulation.signal import Signal


@dataclass(frozen=True, slots=True, kw_only=True)
class Making:
    """What a simulated instrument is made from. `live`: on the real clock.

    `hurried`: nobody but the instrument itself moves the clock.
    """

    station: Station
    name: str
    clock: Clock
    seed: int
    scenario: Scenario
    live: bool = False
    hurried: bool = False

    @property
    def instrument(self) -> Instrument:
        """The station's entry."""
        return self.station.instruments[self.name]

    @property
    def serial_number(self) -> str:
        """What it says it is: begins with SIM, so that nobody takes it for a real instrument."""
        stated = self.instrument.serial_number
        if stated is not None and stated.upper().startswith("SIM"):
            return stated
        return f"SIM{zlib.crc32(self.name.encode()) % 100_000:05d}"


class Peer(Protocol):
    """A simulated instrument of any kind; its class is called with a `Making`.

    The class also has a static `check(station, name)` that raises `StationError` with all complaints
    about its entry in `simulation.instruments`.
    """

    def begin(self, occasion: Occasion) -> None:
        """Draw this unit's errors of the instrument and restart the random streams for its next record."""

    def truth(self) -> Mapping[str, float]:
        """The instrument's true errors, with names of their own (`table_gain_error`)."""


@runtime_checkable
class Talking(Protocol):
    """A peer that answers what it is told; every connection has a dialogue of its own."""

    def dialogue(self, interface: Interface) -> Dialogue:
        """The instrument's side of one connection."""


@runtime_checkable
class Addressed(Protocol):
    """A peer that takes program messages, and so can stand behind a GPIB adapter."""

    speaker: Speaker


@runtime_checkable
class Reading(Protocol):
    """A peer that reads the units' output voltages."""

    def connect(self, occasion: Occasion, signals: Mapping[str, Signal], faults: Faults) -> None:
        """Put a slot's voltages on the inputs, by the slot's channel (empty where there is but one)."""


@runtime_checkable
class Turning(Protocol):
    """A rate table."""

    def angle_deg(self, times_s: NDArray[np.float64]) -> NDArray[np.float64]:
        """The true angle at these times, as far as what was asked for till now settles it."""


class Powered(Protocol):
    """One output of a power supply; `on_since_s` is None while it is off (or gives no voltage)."""

    on_since_s: float | None


@runtime_checkable
class Powering(Protocol):
    """A power supply."""

    def output(self, number: int) -> Powered:
        """One of its outputs, counted from 1."""


@runtime_checkable
class Heating(Protocol):
    """A temperature chamber."""

    def temperature_degc(self, times_s: NDArray[np.float64]) -> NDArray[np.float64]:
        """The true temperature at these times."""


@runtime_checkable
class Exciting(Protocol):
    """What drives a vibration table."""

    def drive_v(
        self, first: int, count: int, *, origin_s: float, interval_s: float
    ) -> NDArray[np.float64]:
        """The drive voltage at `origin_s + (first … first + count - 1) · interval_s`, (count,), V.

        None of these times is in the future; `first` may be negative. Noise is the same however many
        are asked for at a time, and goes on from one origin to the next in real time.
        """
