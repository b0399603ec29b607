"""A simulated power supply: outputs with capacitance, load, current limit and over-voltage protection."""

import math
import threading
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from enum import Enum, auto

from gyrotest.ports import Clock
from gyrotest.simulation.scpi import ErrorQueue

# The unit runs from this share of the voltage that is set.
_WORKS_FROM = 0.8
# What a short leaves of the voltage.
_SHORTED = 0.1
# Below this the unit's load is a resistance, V.
_LOAD_FROM_V = 1.0
MOST_V = 32.0
MOST_A = 6.0
_PROTECTION_AT_RESET_V = 35.0
MOST_PROTECTION_V = 35.0


class OutputFault(Enum):
    """What can be wrong with an output, or with what it feeds."""

    NO_VOLTAGE = auto()
    SHORTED = auto()


@dataclass(frozen=True, slots=True, kw_only=True)
class OutputFigures:
    """An output and its load: current of the unit, capacitance across it, times of rise and fall, errors.

    `rise_s` and `fall_s` are time constants; `gain` is the output's own error of the voltage that is set,
    `reading_gain` that of the voltage that is read back; both ratios.
    """

    load_a: float = 0.04
    capacitance_f: float = 100e-6
    rise_s: float = 0.02
    fall_s: float = 0.4
    gain: float = 0.0
    reading_gain: float = 0.0
    fault: OutputFault | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class _Phase:
    """The voltage goes from one value to another from a moment on; `runs_from_s`: the unit runs since."""

    since_s: float = 0.0
    from_v: float = 0.0
    to_v: float = 0.0
    tau_s: float = 1.0
    works_v: float = math.inf
    runs_from_s: float = math.inf

    def voltage_v(self, now_s: float) -> float:
        elapsed_s = max(0.0, now_s - self.since_s)
        return self.to_v + (self.from_v - self.to_v) * math.exp(-elapsed_s / self.tau_s)

    def reaches_s(self, voltage_v: float) -> float:
        """When a voltage is reached; infinity if it never is."""
        ratio = (self.to_v - voltage_v) / (self.to_v - self.from_v) if self.to_v != self.from_v else 0.0
        return self.since_s - self.tau_s * math.log(ratio) if 0.0 < ratio <= 1.0 else math.inf

    def running(self, now_s: float) -> bool:
        return now_s >= self.runs_from_s and self.voltage_v(now_s) >= self.works_v


class SimulatedOutput:
    """One output. Its state follows from the moments at which it was set, so that any thread may look."""

    def __init__(self, figures: OutputFigures, clock: Clock) -> None:
        self.figures = figures
        self._clock = clock
        self.voltage_set_v = 0.0
        self.limit_a = MOST_A
        self.protection_v = _PROTECTION_AT_RESET_V
        self.on = False
        self.tripped = False
        self._phase = _Phase()
        self._lock = threading.RLock()

    @property
    def on_since_s(self) -> float | None:
        """Since when the output's voltage is high enough for the unit to run; None while it is not."""
        now_s = self._clock.now_s()
        self._protect(now_s)
        phase = self._phase
        return phase.runs_from_s if phase.running(now_s) else None

    def reset(self, now_s: float) -> None:
        """Off, nothing set."""
        self.switch(now_s, on=False)
        self.voltage_set_v, self.limit_a = 0.0, MOST_A
        self.protection_v, self.tripped = _PROTECTION_AT_RESET_V, False

    def switch(self, now_s: float, *, on: bool) -> None:
        """Switch on or off; an output that has tripped stays off."""
        self._protect(now_s)
        self.on = on and not self.tripped
        self._turn(now_s)

    def set_voltage(self, now_s: float, voltage_v: float) -> None:
        """Set the voltage."""
        self._protect(now_s)
        self.voltage_set_v = voltage_v
        self._turn(now_s)

    def set_limit(self, now_s: float, limit_a: float) -> None:
        """Set the current limit."""
        self._protect(now_s)
        self.limit_a = limit_a
        self._turn(now_s)

    def set_protection(self, now_s: float, protection_v: float) -> None:
        """Set the over-voltage protection; it trips where the voltage is above it already."""
        self.protection_v = protection_v
        self._protect(now_s)

    def clear_protection(self) -> None:
        """Forget that it tripped; the output stays off."""
        self.tripped = False

    def voltage_v(self, now_s: float) -> float:
        """The true voltage."""
        self._protect(now_s)
        return self._phase.voltage_v(now_s)

    def current_a(self, now_s: float) -> float:
        """The true current: that of the unit and that which charges the capacitance, within the limit."""
        voltage_v = self.voltage_v(now_s)
        if not self.on or self.figures.fault is OutputFault.NO_VOLTAGE:
            return 0.0
        if self.figures.fault is OutputFault.SHORTED:
            return self.limit_a
        charging_a = self.figures.capacitance_f * (self._phase.to_v - voltage_v) / self._phase.tau_s
        load_a = self.figures.load_a * min(1.0, voltage_v / _LOAD_FROM_V)
        return min(self.limit_a, max(0.0, load_a + charging_a))

    def limiting(self, now_s: float) -> bool:
        """Whether the current limit holds the output."""
        return self.on and self.current_a(now_s) >= self.limit_a

    def _turn(self, now_s: float) -> None:
        """Begin a new phase towards what is set now."""
        before = self._phase
        from_v = before.voltage_v(now_s)
        to_v = self._steady_v()
        works_v = _WORKS_FROM * self.voltage_set_v if self.on and self.voltage_set_v else before.works_v
        tau_s = self.figures.rise_s if self.on else self.figures.fall_s
        phase = _Phase(since_s=now_s, from_v=from_v, to_v=to_v, tau_s=tau_s, works_v=works_v)
        if before.running(now_s):
            runs_from_s = before.runs_from_s
        else:
            runs_from_s = phase.reaches_s(works_v) if self.on else math.inf
        self._phase = replace(phase, runs_from_s=runs_from_s)
        self._protect(now_s)

    def _steady_v(self) -> float:
        if not self.on or self.figures.fault is OutputFault.NO_VOLTAGE:
            return 0.0
        voltage_v = self.voltage_set_v * (1.0 + self.figures.gain)
        if self.figures.fault is OutputFault.SHORTED:
            return _SHORTED * voltage_v
        if self.figures.load_a > self.limit_a:
            return min(voltage_v, _LOAD_FROM_V * self.limit_a / self.figures.load_a)
        return voltage_v

    def _protect(self, now_s: float) -> None:
        """Trip where the voltage has gone above the protection since the last look."""
        with self._lock:
            if not self.on or self._phase.voltage_v(now_s) <= self.protection_v:
                return
            self.tripped, self.on = True, False
            phase, most_v = self._phase, self.protection_v
            at_s = phase.since_s if phase.from_v > most_v else phase.reaches_s(most_v)
            self._turn(min(now_s, at_s))


class SimulatedSupply:
    """A power supply with one or several outputs; what it is told comes through the commands."""

    def __init__(
        self,
        *,
        outputs: Sequence[OutputFigures],
        clock: Clock,
        identity: str = "Example,PS-3,SIM00003,1.0",
    ) -> None:
        self.identity = identity
        self.errors = ErrorQueue()
        self.now_s = clock.now_s()
        self.chosen = 1
        self.outputs: Mapping[int, SimulatedOutput] = {
            number: SimulatedOutput(figures, clock) for number, figures in enumerate(outputs, start=1)
        }

    def output(self, number: int) -> SimulatedOutput:
        """One of its outputs, counted from 1."""
        return self.outputs[number]

    def reset(self) -> None:
        """`*RST`: everything off."""
        self.chosen = 1
        for output in self.outputs.values():
            output.reset(self.now_s)
