"""A simulated unit with the dice thrown: what it is for good, and what each power-on makes of it."""

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gyrotest.simulation.dynamics import Dynamics
from gyrotest.simulation.noise import NoiseDensities
from gyrotest.simulation.peer import Powered
from gyrotest.simulation.response import Response
from gyrotest.simulation.streams import generator


@dataclass(frozen=True, slots=True, kw_only=True)
class GyroParameters:
    """A gyro model's true figures; what varies from unit to unit is a spread here.

    `turn_on_bias_dps` is a standard deviation over power cycles; `scale_factor_error`, `nonlinearity`,
    `asymmetry`, `bandwidth_error`, `misalignment_deg` and the sensitivities are half-widths of rectangular
    distributions over units. With a `damping` the response is of second order, its −3 dB point at the
    bandwidth, after a delay; without it the bandwidth shapes the noise alone.
    `scale_factor` and `zero_rate` are nominal, in output units per deg/s and output units. `axes` has
    one empty name for a gyro of a single axis.
    """

    axes: tuple[str, ...]
    voltage: bool
    scale_factor: float
    zero_rate: float
    noise: NoiseDensities
    turn_on_bias_dps: float
    scale_factor_error: float
    warm_up_drift_dps: float
    warm_up_time_constant_s: float
    input_rate_dps: float
    full_scale_dps: float
    nonlinearity: float
    asymmetry: float
    saturation_dps: float
    dead_zone_dps: float
    temperature_sensitivity_dps_per_c: float
    scale_factor_sensitivity_per_c: float
    clock_error: float
    damping: float = 0.0
    bandwidth_error: float = 0.0
    delay_s: float = 0.0
    g_sensitivity_dps_per_g: float = 0.0
    misalignment_deg: float = 0.0


@dataclass(frozen=True, slots=True, kw_only=True)
class Axis:
    """One axis of a unit, whatever its power-on.

    `g_sensitivity_dps_per_g` is what the specific force along each of the unit's own x, y and z makes of
    its bias; it leans by `misalignment_deg` towards the shaft of a stage that turns it.
    """

    name: str
    response: Response
    temperature_sensitivity_dps_per_c: float
    scale_factor_sensitivity_per_c: float
    g_sensitivity_dps_per_g: Mapping[str, float]
    misalignment_deg: float
    dynamics: Dynamics


@dataclass(frozen=True, slots=True, kw_only=True)
class Dice:
    """What a unit's figures are drawn by: the seed and its serial number."""

    seed: int
    serial_number: str

    def uniform(self, purpose: str, axis: str) -> float:
        """A number of this unit's axis, -1 … 1."""
        return float(self._of(purpose, axis).uniform(-1.0, 1.0))

    def turn_on(self, axis: str, power_cycle: int) -> float:
        """A standard normal number of one power-on."""
        return float(self._of("turn-on bias", axis, power_cycle).standard_normal())

    def _of(self, purpose: str, axis: str, *more: int) -> np.random.Generator:
        names: tuple[str | int, ...] = (
            (self.serial_number, *more, axis) if axis else (self.serial_number, *more)
        )
        return generator(self.seed, purpose, *names)


def draw_axis(name: str, gyro: GyroParameters, dice: Dice, *, inverted: bool) -> Axis:
    """Throw the dice for one axis."""
    factor = gyro.scale_factor * (1.0 + gyro.scale_factor_error * dice.uniform("scale factor", name))
    return Axis(
        name=name,
        response=Response(
            scale_factor=-factor if inverted else factor,
            zero_rate=gyro.zero_rate,
            full_scale_dps=gyro.full_scale_dps,
            nonlinearity=gyro.nonlinearity * dice.uniform("nonlinearity", name),
            asymmetry=gyro.asymmetry * dice.uniform("asymmetry", name),
            saturation_dps=gyro.saturation_dps,
        ),
        temperature_sensitivity_dps_per_c=gyro.temperature_sensitivity_dps_per_c
        * dice.uniform("temperature sensitivity", name),
        scale_factor_sensitivity_per_c=gyro.scale_factor_sensitivity_per_c
        * dice.uniform("scale factor temperature sensitivity", name),
        g_sensitivity_dps_per_g={
            own: gyro.g_sensitivity_dps_per_g * dice.uniform(f"g sensitivity {own}", name)
            for own in "xyz"
        },
        misalignment_deg=misalignment_deg(name, gyro, dice),
        dynamics=_dynamics(name, gyro, dice),
    )


def _dynamics(name: str, gyro: GyroParameters, dice: Dice) -> Dynamics:
    """How an axis follows its rate; a bandwidth that shapes nothing but the noise is the model's own."""
    error = gyro.bandwidth_error * dice.uniform("bandwidth", name) if gyro.damping else 0.0
    return Dynamics(
        bandwidth_hz=gyro.noise.bandwidth_hz * (1.0 + error),
        damping=gyro.damping,
        delay_s=gyro.delay_s,
    )


def misalignment_deg(name: str, gyro: GyroParameters, dice: Dice) -> float:
    """By how much an axis leans, °."""
    return gyro.misalignment_deg * dice.uniform("misalignment", name)


@dataclass(frozen=True, slots=True, kw_only=True)
class PowerOn:
    """One power-on of a unit: which one it is, and when it was."""

    cycle: int
    on_s: float


class PowerOns:
    """A unit's power-ons, counted on from the planned one whenever its supply is switched on again."""

    def __init__(self, planned: PowerOn, power: Powered | None) -> None:
        self._last = planned
        self._seen_s = power.on_since_s if power is not None else None

    def current(self, power: Powered | None) -> PowerOn | None:
        """The power-on that lasts; None while the unit is off."""
        if power is None:
            return self._last
        since_s = power.on_since_s
        if since_s is not None and since_s != self._seen_s:
            # Off when it was planned: this is the planned one.
            follows = self._seen_s is not None
            self._last = PowerOn(cycle=self._last.cycle + follows, on_s=since_s)
            self._seen_s = since_s
        return self._last if since_s is not None else None


def drift_dps(gyro: GyroParameters, since_s: float, duration_s: float) -> float:
    """Mean of the warm-up drift `amplitude · e^(−t/τ)` over an interval that long after power-on."""
    tau_s = gyro.warm_up_time_constant_s
    share = -math.expm1(-duration_s / tau_s) * tau_s / duration_s
    return gyro.warm_up_drift_dps * math.exp(-since_s / tau_s) * share


def drifts_dps(
    gyro: GyroParameters, since_s: NDArray[np.float64], duration_s: float
) -> NDArray[np.float64]:
    """`drift_dps` for many intervals of one duration, (n,)."""
    tau_s = gyro.warm_up_time_constant_s
    share = -math.expm1(-duration_s / tau_s) * tau_s / duration_s
    return np.asarray(gyro.warm_up_drift_dps * share * np.exp(-since_s / tau_s))
