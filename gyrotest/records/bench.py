"""What instruments of the bench say of themselves and of the unit under test."""

from dataclasses import dataclass

from gyrotest.records.spec import OutputMode

_NO_PART = "00000-000000"


@dataclass(frozen=True, slots=True, kw_only=True)
class Device:
    """A digital gyro by its own words; None where it cannot be asked."""

    serial_number: str | None = None
    part_number: str | None = None
    mode: OutputMode | None = None
    range_dps: float | None = None
    bandwidth_hz: float | None = None
    sample_rate_hz: float | None = None

    @property
    def simulated(self) -> bool:
        """Whether it says that it is simulated: a serial number of digits cannot, a part number of zeros does."""
        return self.part_number is not None and self.part_number.startswith(_NO_PART)


@dataclass(frozen=True, slots=True, kw_only=True)
class Supplied:
    """What a power supply's output gives."""

    voltage_v: float
    current_a: float
    limiting: bool = False
    tripped: bool = False


@dataclass(frozen=True, slots=True, kw_only=True)
class DaqChannel:
    """A channel of a synchronous source: its values are `scale` times what is transferred, in `unit`.

    It is sampled `skew_s` later than the source's own instant.
    """

    name: str
    unit: str
    scale: float = 1.0
    skew_s: float = 0.0
