"""A simulated unit in its slot, for one record."""

import math

from gyrotest.simulation.carriage import Carriage
from gyrotest.simulation.element import Element
from gyrotest.simulation.occasion import Occasion
from gyrotest.simulation.surroundings import Surroundings
from gyrotest.simulation.unit import Dice, GyroParameters, PowerOn, PowerOns, draw_axis

_RUNS_S = 60.0


class Housed:
    """A unit's axes and what acts on them, from the moment on at which a record begins."""

    def __init__(
        self,
        gyro: GyroParameters,
        carriages: tuple[Carriage, ...],
        surroundings: Surroundings,
        occasion: Occasion,
        *,
        seed: int,
        inverted: bool,
        now_s: float,
    ) -> None:
        dice = Dice(seed=seed, serial_number=occasion.serial_number)
        self.gyro = gyro
        self.surroundings = surroundings
        self.occasion = occasion
        self.begun_s = now_s
        power = surroundings.power
        on_s = now_s - occasion.elapsed_s
        if occasion.duration_s == 0.0:
            # Put into its place: it runs for a while already, or since its supply was switched on.
            since_s = power.on_since_s if power is not None else None
            on_s = now_s - _RUNS_S if since_s is None else since_s
        self.planned = PowerOn(cycle=occasion.power_cycle, on_s=on_s)
        self._power_ons = PowerOns(self.planned, power)
        self.elements = tuple(
            Element(draw_axis(name, gyro, dice, inverted=inverted), gyro, carriage, dice)
            for name, carriage in zip(gyro.axes, carriages, strict=True)
        )

    @property
    def power_on(self) -> PowerOn | None:
        """The power-on that lasts; None while the unit is off."""
        return self._power_ons.current(self.surroundings.power)

    def truth(self, duration_s: float) -> dict[str, float]:
        """The true figures of every axis for the record: `x.bias_dps`, or `bias_dps` of a single axis."""
        found: dict[str, float] = {}
        for element in self.elements:
            prefix = f"{element.axis.name}." if element.axis.name else ""
            figures = element.truth(self.planned, self.begun_s, duration_s)
            # What is without limit is left out: a model of which no full scale is stated.
            found |= {
                f"{prefix}{name}": value for name, value in figures.items() if math.isfinite(value)
            }
        return found
