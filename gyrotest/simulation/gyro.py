"""Voltages on the simulated bench: a mean for any averaging interval."""

import numpy as np
from numpy.typing import NDArray

from gyrotest.simulation.element import Element
from gyrotest.simulation.housed import Housed
from gyrotest.simulation.noise import RateNoise
from gyrotest.simulation.signal import Signal
from gyrotest.simulation.surroundings import Surroundings


class GyroOutput:
    """One axis's output voltage. It is 0 V while the unit has no power."""

    def __init__(self, housed: Housed, element: Element, noise: RateNoise) -> None:
        self._housed = housed
        self._element = element
        self._noise = noise

    def mean_voltage(self, start_s: float, aperture_s: float) -> float:
        """The mean output over one aperture, V."""
        housed, element = self._housed, self._element
        if not housed.surroundings.quiet:
            return float(self.mean_voltages(start_s, aperture_s, aperture_s, 1)[0])
        rate = self._noise.mean(start_s, aperture_s)
        rate += element.still_rate_dps(housed.planned, start_s, aperture_s)
        limit = element.saturation_dps
        return element.scale_factor * min(max(rate, -limit), limit) + element.zero_rate

    def mean_voltages(
        self, start_s: float, aperture_s: float, spacing_s: float, count: int
    ) -> NDArray[np.float64]:
        """Mean outputs over `count` apertures that begin every `spacing_s`, (count,), V."""
        housed, element = self._housed, self._element
        starts_s = start_s + spacing_s * np.arange(count, dtype=np.float64)
        rates = self._noise.means(start_s, aperture_s, spacing_s, count)
        if housed.surroundings.quiet:
            rates += element.still_rates_dps(housed.planned, starts_s, aperture_s)
            return element.scale_factor * element.clipped(rates) + element.zero_rate
        power_on = housed.power_on
        if power_on is None:
            return np.zeros(count)
        acting = housed.surroundings.acting(starts_s, aperture_s)
        rates += element.rates_dps(power_on, starts_s, acting)
        return element.scale_factors(acting) * element.clipped(rates) + element.zero_rate


class TemperatureOutput:
    """A temperature sensor beside the unit: 10 mV/°C."""

    def __init__(self, surroundings: Surroundings) -> None:
        self._surroundings = surroundings

    def mean_voltage(self, start_s: float, aperture_s: float) -> float:
        """The voltage, V."""
        return float(self.mean_voltages(start_s, aperture_s, aperture_s, 1)[0])

    def mean_voltages(
        self,
        start_s: float,
        aperture_s: float,  # noqa: ARG002 - slow
        spacing_s: float,
        count: int,
    ) -> NDArray[np.float64]:
        """The voltages, (count,), V."""
        starts_s = start_s + spacing_s * np.arange(count, dtype=np.float64)
        return 0.01 * self._surroundings.temperatures_degc(starts_s)


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
