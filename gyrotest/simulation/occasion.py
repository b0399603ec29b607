"""Which record of which unit is next on the simulated bench."""

from collections.abc import Mapping
from dataclasses import dataclass, field

from gyrotest.records.plan import Placement


@dataclass(frozen=True, slots=True, kw_only=True)
class Occasion:
    """Which record of which unit is next: what the random streams depend on.

    `elapsed_s` is the time since power-on at the record's begin. A `duration_s` of 0: no record yet, the
    unit was only put into its place. `mountings` has the direction (up, north, east) of each axis that is
    known, by its name (empty for a gyro of one axis). `placement` is how the unit is turned from the
    mounting that its slot describes (None: the case does not care).
    """

    serial_number: str
    case: str = ""
    power_cycle: int = 1
    repeat: int = 0
    elapsed_s: float = 0.0
    duration_s: float = 0.0
    mountings: Mapping[str, tuple[float, float, float]] = field(default_factory=dict)
    placement: Placement | None = None

    @property
    def stream(self) -> tuple[str | int, ...]:
        """What names the random streams of this record."""
        return (self.serial_number, self.case, self.power_cycle, self.repeat)
