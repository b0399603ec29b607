"""The simulated gyro: an output voltage for any averaging interval."""

import math
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from gyrotest.simulation.noise import NoiseDensities, RateNoise


class Signal(Protocol):
    """What a meter reads: the mean voltage over apertures, asked for in the order of time."""

    def mean_voltage(self, start_s: float, aperture_s: float) -> float:
        """The mean over one aperture, V."""

    def mean_voltages(
        self, start_s: float, aperture_s: float, spacing_s: float, count: int
    ) -> NDArray[np.float64]:
        """The means over `count` apertures that begin every `spacing_s`, (count,), V."""


@dataclass(frozen=True, slots=True, kw_only=True)
class GyroParameters:
    """A gyro model's true figures; what varies from unit to unit is a spread here.

    `turn_on_bias_dps` is a standard deviation over power cycles, `scale_factor_error` the
    half-width of a rectangular distribution over units.
    """

    scale_factor_v_per_dps: float
    zero_rate_v: float
    noise: NoiseDensities
    turn_on_bias_dps: float
    scale_factor_error: float
    warm_up_drift_dps: float
    warm_up_time_constant_s: float
    input_rate_dps: float


@dataclass(frozen=True, slots=True, kw_only=True)
class Unit:
    """One gyro after one power-on: its parameters with the dice thrown."""

    parameters: GyroParameters
    scale_factor_v_per_dps: float
    turn_on_bias_dps: float
    power_on_s: float

    def drift_dps(self, start_s: float, duration_s: float) -> float:
        """Mean of the warm-up drift `amplitude · e^(−t/τ)` over an interval, deg/s."""
        tau_s = self.parameters.warm_up_time_constant_s
        since = (start_s - self.power_on_s) / tau_s
        share = -math.expm1(-duration_s / tau_s) * tau_s / duration_s
        return self.parameters.warm_up_drift_dps * math.exp(-since) * share

    def drifts_dps(self, starts_s: NDArray[np.float64], duration_s: float) -> NDArray[np.float64]:
        """`drift_dps` for many intervals of one duration, (n,)."""
        tau_s = self.parameters.warm_up_time_constant_s
        share = -math.expm1(-duration_s / tau_s) * tau_s / duration_s
        amplitude = self.parameters.warm_up_drift_dps * share
        return np.asarray(amplitude * np.exp((self.power_on_s - starts_s) / tau_s))


class GyroOutput:
    """A unit at rest (or at a constant input rate), as a signal: `U = SF·(ω + B + noise) + U_z`."""

    def __init__(self, unit: Unit, noise: RateNoise) -> None:
        self._unit = unit
        self._noise = noise
        self._constant_dps = unit.turn_on_bias_dps + unit.parameters.input_rate_dps

    def mean_voltage(self, start_s: float, aperture_s: float) -> float:
        """The mean output over one aperture, V."""
        rate = self._noise.mean(start_s, aperture_s) + self._unit.drift_dps(start_s, aperture_s)
        unit = self._unit
        return unit.scale_factor_v_per_dps * (self._constant_dps + rate) + unit.parameters.zero_rate_v

    def mean_voltages(
        self, start_s: float, aperture_s: float, spacing_s: float, count: int
    ) -> NDArray[np.float64]:
        """Mean outputs over `count` apertures that begin every `spacing_s`, (count,), V."""
        rate = self._noise.means(start_s, aperture_s, spacing_s, count)
        starts_s = start_s + spacing_s * np.arange(count, dtype=np.float64)
        rate += self._unit.drifts_dps(starts_s, aperture_s)
        unit = self._unit
        return unit.scale_factor_v_per_dps * (self._constant_dps + rate) + unit.parameters.zero_rate_v


class SteadyOutput:
    """A constant voltage: a dead output, or nothing connected."""

    def __init__(self, voltage_v: float) -> None:
        self._voltage_v = voltage_v

    def mean_voltage(self, start_s: float, aperture_s: float) -> float:  # noqa: ARG002 - constant
        """The voltage, V."""
        return self._voltage_v

    def mean_voltages(
        self,
        start_s: float,  # noqa: ARG002 - constant
        aperture_s: float,  # noqa: ARG002 - constant
        spacing_s: float,  # noqa: ARG002 - constant
        count: int,
    ) -> NDArray[np.float64]:
        """The voltage `count` times, (count,), V."""
        return np.full(count, self._voltage_v)


class RailedOutput:
    """A signal that sits at a supply rail during a stretch of time."""

    def __init__(self, signal: Signal, *, from_s: float, to_s: float, rail_v: float) -> None:
        self._signal = signal
        self._from_s = from_s
        self._to_s = to_s
        self._rail_v = rail_v

    def mean_voltage(self, start_s: float, aperture_s: float) -> float:
        """The mean over one aperture, V; the rail if the aperture touches the stretch."""
        voltage = self._signal.mean_voltage(start_s, aperture_s)
        railed = start_s < self._to_s and start_s + aperture_s > self._from_s
        return self._rail_v if railed else voltage

    def mean_voltages(
        self, start_s: float, aperture_s: float, spacing_s: float, count: int
    ) -> NDArray[np.float64]:
        """The means over `count` apertures, (count,), V."""
        voltages = self._signal.mean_voltages(start_s, aperture_s, spacing_s, count)
        starts = start_s + spacing_s * np.arange(count)
        railed = (starts < self._to_s) & (starts + aperture_s > self._from_s)
        voltages[railed] = self._rail_v
        return voltages
