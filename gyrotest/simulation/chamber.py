"""A simulated temperature chamber: first-order lag, its own error, its commands."""

import functools
import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gyrotest.ports import Clock
from gyrotest.simulation.interpreter import Interpreter, common_commands, getter, setter
from gyrotest.simulation.scpi import ErrorQueue, Table, boolean, one

AMBIENT_DEGC = 23.0
_COLDEST_DEGC, _HOTTEST_DEGC = -75.0, 180.0
_STEP_C = 0.01


@dataclass(frozen=True, slots=True, kw_only=True)
class ChamberFigures:
    """Time constant of its air, heated or cooled, and of its drift back to the room; `stuck`: it stands still."""

    lag_s: float = 240.0
    idle_lag_s: float = 1800.0
    stuck: bool = False


@dataclass(frozen=True, slots=True, kw_only=True)
class _Phase:
    since_s: float
    from_degc: float
    to_degc: float
    lag_s: float

    def at(self, times_s: NDArray[np.float64]) -> NDArray[np.float64]:
        decay = np.exp(-np.maximum(times_s - self.since_s, 0.0) / self.lag_s)
        return np.asarray(self.to_degc + (self.from_degc - self.to_degc) * decay)


class SimulatedChamber:
    """What it was told when is remembered, so that its temperature at any past time is exact.

    `error_c` is how much warmer the chamber is than it shows.
    """

    def __init__(
        self,
        *,
        clock: Clock,
        figures: ChamberFigures | None = None,
        error_c: float = 0.0,
        identity: str = "Example,TC-1,SIM00004,1.0",
    ) -> None:
        self.identity = identity
        self.errors = ErrorQueue()
        self.now_s = clock.now_s()
        self.error_c = error_c
        self.running = False
        self.set_degc = AMBIENT_DEGC
        self._figures = figures or ChamberFigures()
        begin = _Phase(since_s=-math.inf, from_degc=AMBIENT_DEGC, to_degc=AMBIENT_DEGC, lag_s=1.0)
        self._phases: tuple[_Phase, ...] = (begin,)

    def reset(self) -> None:
        """`*RST`: at rest."""
        self.switch(on=False)

    def set_temperature(self, temperature_degc: float) -> None:
        """Ask for a temperature."""
        self.set_degc = temperature_degc
        self._turn()

    def switch(self, *, on: bool) -> None:
        """Start or stop heating and cooling."""
        self.running = on
        self._turn()

    def shown_degc(self, times_s: NDArray[np.float64]) -> NDArray[np.float64]:
        """What the chamber shows at these times, (n,)."""
        phases = self._phases
        begins = np.array([one.since_s for one in phases])
        which = np.searchsorted(begins, times_s, side="right") - 1
        shown = np.empty(times_s.shape)
        for number in np.unique(which):
            mine = which == number
            shown[mine] = phases[number].at(times_s[mine])
        return shown

    def temperature_degc(self, times_s: NDArray[np.float64]) -> NDArray[np.float64]:
        """The true temperature at these times, (n,); of later ones as if nothing more were asked for."""
        return self.shown_degc(times_s) + self.error_c

    def _turn(self) -> None:
        """Begin a new phase towards what is asked for now."""
        if self._figures.stuck:
            return
        here = float(self.shown_degc(np.array([self.now_s]))[0])
        phase = _Phase(
            since_s=self.now_s,
            from_degc=here,
            to_degc=self.set_degc if self.running else AMBIENT_DEGC,
            lag_s=self._figures.lag_s if self.running else self._figures.idle_lag_s,
        )
        self._phases = (*self._phases, phase)


def speaker_of(chamber: SimulatedChamber, clock: Clock) -> Interpreter[SimulatedChamber]:
    """The chamber's front end."""
    return Interpreter(chamber, command_table(), clock)


def _shown(chamber: SimulatedChamber) -> str:
    shown = float(chamber.shown_degc(np.array([chamber.now_s]))[0])
    return f"{round(shown / _STEP_C) * _STEP_C:.2f}"


@functools.cache
def command_table() -> Table[SimulatedChamber]:
    """The chamber's commands."""
    return Table(
        {
            **common_commands(),
            "[SOURce:]TEMPerature[:SETPoint]": setter(
                SimulatedChamber.set_temperature, least=_COLDEST_DEGC, most=_HOTTEST_DEGC
            ),
            "[SOURce:]TEMPerature[:SETPoint]?": getter(lambda chamber: f"{chamber.set_degc:.2f}"),
            "MEASure:TEMPerature?": getter(_shown),
            "OUTPut[:STATe]": lambda chamber, given: chamber.switch(on=boolean(one(given))),
            "OUTPut[:STATe]?": getter(lambda chamber: str(int(chamber.running))),
        }
    )
