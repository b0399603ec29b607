"""What acts on the unit in a plan's steps: the table that turns it, the chamber around it."""

from dataclasses import dataclass
from typing import Protocol

from gyrotest.errors import AcquisitionError
from gyrotest.records.plan import Soaking, Step, Stimulus, Turning


class Turns(Protocol):
    """A table that is brought to rates and watched."""

    def reach(self, turning: Turning) -> None:
        """Return when the table turns at the rate and has settled."""

    def watch(self) -> None:
        """Look at it in the middle of a dwell; raises `InstrumentError` where it leaves the rate."""

    def read_back(self) -> float | None:
        """The mean of what was read back in the dwell, °/s."""

    def rest(self) -> None:
        """Bring it to rest (and back, where its cables ask for it); never raises."""


class Soaks(Protocol):
    """A chamber that is brought to temperatures and watched."""

    def reach(self, soaking: Soaking) -> None:
        """Return when the temperature has held for the soak time."""

    def watch(self) -> None:
        """Look at it in the middle of a dwell."""

    def read_back(self) -> float | None:
        """The mean of what was read back in the dwell, °C."""


@dataclass(frozen=True, slots=True, kw_only=True)
class ReadBack:
    """What a step asked for, and what was read back while it was sampled."""

    demanded_rate_dps: float | None = None
    rate_dps: float | None = None
    demanded_temperature_degc: float | None = None
    temperature_degc: float | None = None


@dataclass
class Stimulation:
    """What a slot has for the steps of a plan; nothing where the plan leaves the bench as it is."""

    table: Turns | None = None
    chamber: Soaks | None = None
    _now: Stimulus | None = None

    def reach(self, step: Step) -> None:
        """Bring a step's stimulus about and wait until it has settled; raises `InstrumentError`."""
        self._now = step.stimulus
        if isinstance(step.stimulus, Turning):
            self._turns(step).reach(step.stimulus)
        elif isinstance(step.stimulus, Soaking):
            self._soaks(step).reach(step.stimulus)

    def watch(self) -> None:
        """See in the middle of a dwell that the stimulus still holds; raises `InstrumentError`."""
        if self.table is not None and isinstance(self._now, Turning):
            self.table.watch()
        elif self.chamber is not None and isinstance(self._now, Soaking):
            self.chamber.watch()

    def read_back(self) -> ReadBack:
        """What the step asked for and what was read back since it was reached."""
        if self.table is not None and isinstance(self._now, Turning):
            return ReadBack(demanded_rate_dps=self._now.rate_dps, rate_dps=self.table.read_back())
        if self.chamber is not None and isinstance(self._now, Soaking):
            return ReadBack(
                demanded_temperature_degc=self._now.temperature_degc,
                temperature_degc=self.chamber.read_back(),
            )
        return ReadBack()

    def rest(self) -> None:
        """Leave everything at rest; never raises."""
        if self.table is not None:
            self.table.rest()

    def _turns(self, step: Step) -> Turns:
        if self.table is None:
            raise AcquisitionError(
                f"step '{step.name}' turns the unit, and its slot has no rate table; give the slot a 'table'"
            )
        return self.table

    def _soaks(self, step: Step) -> Soaks:
        if self.chamber is None:
            raise AcquisitionError(
                f"step '{step.name}' needs a temperature, and the slot has no chamber; give it a 'chamber'"
            )
        return self.chamber
