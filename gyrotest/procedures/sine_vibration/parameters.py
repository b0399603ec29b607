"""What a sine-vibration case may be told."""

import math
from dataclasses import dataclass
from typing import Annotated, ClassVar

from gyrotest.procedures.wording import plain
from gyrotest.records.described import Described
from gyrotest.records.plan import Excitation, Vibrating
from gyrotest.units import Dimension, OfDimension, Quantity

_FREQUENCIES = tuple(Quantity(one, "Hz") for one in (5.0, 10.0, 20.0, 40.0, 60.0, 80.0, 100.0))
_SETTLE = Quantity(2.0, "s")


@dataclass(frozen=True, slots=True, kw_only=True)
class SineVibrationParameters:
    """Parameters of a sine-vibration case; its `duration` is that of each frequency, or of the whole sweep."""

    __pydantic_config__: ClassVar = {"extra": "forbid", "strict": True}

    level: Annotated[
        Quantity,
        OfDimension(Dimension.RATE),
        Described("root mean square of the table's rate, the same at every frequency", "8 deg/s"),
    ]
    frequencies: Annotated[
        tuple[Annotated[Quantity, OfDimension(Dimension.FREQUENCY)], ...],
        Described(
            "frequencies that are measured, in the order in which they are driven",
            "[5 Hz, 10 Hz, 20 Hz, 40 Hz, 60 Hz, 80 Hz, 100 Hz]",
        ),
    ] = _FREQUENCIES
    settle: Annotated[
        Quantity,
        OfDimension(Dimension.TIME),
        Described("time for which the table has moved before the first sample of a step", "2 s"),
    ] = _SETTLE
    sweep_from: Annotated[
        Quantity | None,
        OfDimension(Dimension.FREQUENCY),
        Described(
            "where a logarithmic sweep begins; with `sweep_to` the table is swept once, and the frequencies"
            " are read from that",
            "4.5 Hz",
        ),
    ] = None
    sweep_to: Annotated[
        Quantity | None,
        OfDimension(Dimension.FREQUENCY),
        Described("where the sweep ends", "110 Hz"),
    ] = None
    reference_frequency: Annotated[
        Quantity | None,
        OfDimension(Dimension.FREQUENCY),
        Described(
            "the one of the frequencies to whose sensitivity flatness and bandwidth refer; the lowest by default",
            "10 Hz",
        ),
    ] = None
    flat_to: Annotated[
        Quantity | None,
        OfDimension(Dimension.FREQUENCY),
        Described("frequency up to which the flatness is reported; the highest by default", "20 Hz"),
    ] = None

    @property
    def frequencies_hz(self) -> tuple[float, ...]:
        """The frequencies in the order in which they are driven, Hz."""
        return tuple(one.to("Hz") for one in self.frequencies)

    @property
    def highest_hz(self) -> float:
        """The highest frequency at which the table is driven, Hz."""
        return max(self.frequencies_hz) if self.sweep_to is None else self.sweep_to.to("Hz")

    @property
    def reference_hz(self) -> float:
        """The frequency to which flatness and bandwidth refer, Hz."""
        given = self.reference_frequency
        return min(self.frequencies_hz) if given is None else given.to("Hz")

    @property
    def flat_to_hz(self) -> float:
        """The frequency up to which the flatness is reported, Hz."""
        return max(self.frequencies_hz) if self.flat_to is None else self.flat_to.to("Hz")

    @property
    def sweep(self) -> "Sweep | None":
        """The sweep; None where the frequencies are driven one by one."""
        if self.sweep_from is None or self.sweep_to is None:
            return None
        return Sweep(low_hz=self.sweep_from.to("Hz"), high_hz=self.sweep_to.to("Hz"))

    def steady(self, frequency_hz: float) -> Vibrating:
        """Return the table in a sine of a frequency."""
        return Vibrating(
            excitation=Excitation.SINE,
            rms_dps=self.level.to("deg/s"),
            low_hz=frequency_hz,
            high_hz=frequency_hz,
            settle_s=self.settle.to("s"),
        )

    def swept(self, sweep: "Sweep") -> Vibrating:
        """Return the table in a sweep."""
        return Vibrating(
            excitation=Excitation.SWEEP,
            rms_dps=self.level.to("deg/s"),
            low_hz=sweep.low_hz,
            high_hz=sweep.high_hz,
            settle_s=self.settle.to("s"),
        )


@dataclass(frozen=True, slots=True, kw_only=True)
class Sweep:
    """A sweep that is even on a logarithmic scale."""

    low_hz: float
    high_hz: float

    def growth_per_s(self, duration_s: float) -> float:
        """Return by how much of itself the frequency grows in a second."""
        return math.log(self.high_hz / self.low_hz) / duration_s


def step_name(frequency_hz: float) -> str:
    """Return the name of a frequency's step: `20 Hz`."""
    return f"{plain(frequency_hz, 9)} Hz"
