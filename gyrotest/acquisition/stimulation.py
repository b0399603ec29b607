"""What acts on the unit in a plan's steps: what turns or vibrates it, the chamber around it."""

from dataclasses import dataclass
from typing import Protocol

from gyrotest.errors import AcquisitionError
from gyrotest.records.plan import (
    Excitation,
    Pointing,
    Rotating,
    Soaking,
    Step,
    Stimulus,
    Turning,
    Vibrating,
)


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


class Vibrates(Protocol):
    """A table that is brought to vibrate and watched."""

    def reach(self, vibrating: Vibrating, *, sampled_s: float) -> None:
        """Return when it vibrates and has settled; it is sampled for so long then."""

    def watch(self) -> None:
        """Look at it in the middle of a dwell; raises `InstrumentError` where it does so no more."""

    def rest(self) -> None:
        """Bring it to rest; never raises."""


class Rotates(Protocol):
    """A stage that is turned within one turn, or held at angles, and watched."""

    def reach(self, stimulus: Rotating | Pointing, *, sampled_s: float) -> None:
        """Return when the first sample may be taken; it is sampled for so long then."""

    def watch(self) -> None:
        """Look at it in the middle of a dwell; raises `InstrumentError` where it does otherwise."""

    def allow_pause(self, pause_s: float) -> None:
        """Raise `InstrumentError`, stopped, where it cannot be left alone for so long."""

    def leave(self) -> None:
        """The last sample is taken; raises `InstrumentError`."""

    def read_back(self) -> "ReadBack":
        """What the step asked for, and the mean of what was read back in the dwell."""

    def rest(self) -> None:
        """Bring it to rest and back to its start; never raises."""


@dataclass(frozen=True, slots=True, kw_only=True)
class ReadBack:
    """What a step asked for, and what was read back while it was sampled."""

    demanded_rate_dps: float | None = None
    rate_dps: float | None = None
    demanded_temperature_degc: float | None = None
    temperature_degc: float | None = None
    demanded_position_deg: float | None = None
    position_deg: float | None = None
    vibration_dps: float | None = None
    frequency_hz: float | None = None
    band_hz: tuple[float, float] | None = None


@dataclass
class Stimulation:
    """What a slot has for the steps of a plan; nothing where the plan leaves the bench as it is.

    `interval_s` is the plan's: a sweep, and a turn, lasts as long as it is sampled.
    """

    table: Turns | None = None
    chamber: Soaks | None = None
    vibration: Vibrates | None = None
    stage: Rotates | None = None
    interval_s: float = 0.0
    _now: Stimulus | None = None

    def reach(self, step: Step) -> None:
        """Bring a step's stimulus about and wait until it has settled; raises `InstrumentError`."""
        self._now = step.stimulus
        if isinstance(step.stimulus, Turning):
            self._turns(step).reach(step.stimulus)
        elif isinstance(step.stimulus, Soaking):
            self._soaks(step).reach(step.stimulus)
        elif isinstance(step.stimulus, Vibrating):
            self._vibrates(step).reach(step.stimulus, sampled_s=step.samples * self.interval_s)
        elif isinstance(step.stimulus, Rotating | Pointing):
            self._rotates(step).reach(step.stimulus, sampled_s=step.samples * self.interval_s)

    def watch(self) -> None:
        """See in the middle of a dwell that the stimulus still holds; raises `InstrumentError`."""
        if self.table is not None and isinstance(self._now, Turning):
            self.table.watch()
        elif self.chamber is not None and isinstance(self._now, Soaking):
            self.chamber.watch()
        elif self.vibration is not None and isinstance(self._now, Vibrating):
            self.vibration.watch()
        elif self.stage is not None and isinstance(self._now, Rotating | Pointing):
            self.stage.watch()

    def allow_pause(self, pause_s: float) -> None:
        """Raise `InstrumentError` where what moves, and is stopped then, cannot be left alone for so long."""
        if self.stage is not None and isinstance(self._now, Rotating | Pointing):
            self.stage.allow_pause(pause_s)

    def leave(self) -> None:
        """A step's last sample is taken: what must not go on is stopped; raises `InstrumentError`."""
        if self.stage is not None and isinstance(self._now, Rotating | Pointing):
            self.stage.leave()

    def read_back(self) -> ReadBack:
        """What the step asked for and what was read back since it was reached."""
        if self.table is not None and isinstance(self._now, Turning):
            return ReadBack(demanded_rate_dps=self._now.rate_dps, rate_dps=self.table.read_back())
        if self.chamber is not None and isinstance(self._now, Soaking):
            return ReadBack(
                demanded_temperature_degc=self._now.temperature_degc,
                temperature_degc=self.chamber.read_back(),
            )
        if self.stage is not None and isinstance(self._now, Rotating | Pointing):
            return self.stage.read_back()
        if isinstance(self._now, Vibrating):
            return _vibration(self._now)
        return ReadBack()

    def rest(self) -> None:
        """Leave everything at rest; never raises."""
        if self.stage is not None:
            self.stage.rest()
        if self.table is not None:
            self.table.rest()
        if self.vibration is not None:
            self.vibration.rest()

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

    def _rotates(self, step: Step) -> Rotates:
        if self.stage is None:
            raise AcquisitionError(
                f"step '{step.name}' turns the unit in gravity, and its slot has no rotation stage; give it a"
                " 'table' with a 'shaft'"
            )
        return self.stage

    def _vibrates(self, step: Step) -> Vibrates:
        if self.vibration is None:
            raise AcquisitionError(
                f"step '{step.name}' vibrates the unit, and the slot has nothing that drives a vibration table;"
                " give it a 'vibration'"
            )
        return self.vibration


def _vibration(asked: Vibrating) -> ReadBack:
    if asked.excitation is Excitation.SINE:
        return ReadBack(vibration_dps=asked.rms_dps, frequency_hz=asked.low_hz)
    at_rest = asked.excitation is Excitation.NONE
    band_hz = None if at_rest else (asked.low_hz, asked.high_hz)
    return ReadBack(vibration_dps=asked.rms_dps, band_hz=band_hz)
