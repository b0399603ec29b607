"""A digital gyro's samples: its own grid, its noise, and what acts on it during each sample."""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gyrotest.simulation.housed import Housed
from gyrotest.simulation.stream_noise import StreamNoise
from gyrotest.simulation.streams import generator
from gyrotest.simulation.unit import PowerOn

# So long after power-on a unit sends nothing yet, and so long more it says that it is starting up.
BOOT_S = 0.1
START_UP_S = 0.5
_HASTE = 1e-7


@dataclass(frozen=True, slots=True, kw_only=True)
class Sampled:
    """Consecutive samples; `number` counts from the record's begin, `time_s` (n,) is the end of each.

    `outputs` (axes, n) in the output's unit; `over` (axes, n) where it saturates.
    """

    number: NDArray[np.int64]
    time_s: NDArray[np.float64]
    outputs: NDArray[np.float64]
    over: NDArray[np.bool_]
    temperature_degc: NDArray[np.float64]
    starting: NDArray[np.bool_]


class Sampler:
    """Takes a unit's samples one after the other, each the mean over its whole interval."""

    def __init__(self, housed: Housed, *, seed: int, rate_hz: float, silent: bool = False) -> None:
        self.housed = housed
        self.interval_s = 1.0 / rate_hz / (1.0 + housed.gyro.clock_error)
        self._begun_s = housed.begun_s
        self._next = 0
        self._silent = silent
        self._noise = [self._noise_of(element.axis.name, seed) for element in housed.elements]

    def _noise_of(self, axis: str, seed: int) -> StreamNoise:
        occasion = self.housed.occasion
        names = (*occasion.stream, axis) if axis else occasion.stream
        return StreamNoise(
            self.housed.gyro.noise,
            generator(seed, "gyro noise", *names),
            interval_s=self.interval_s,
            since_power_on_s=max(occasion.elapsed_s, 0.0),
        )

    def due(self, now_s: float) -> int:
        """How many samples have ended and are not taken yet."""
        ended = math.floor((now_s - self._begun_s) / self.interval_s + _HASTE)
        return max(0, ended - self._next)

    def skip(self, count: int) -> None:
        """Leave out the next samples."""
        for noise in self._noise:
            noise.skip(count)
        self._next += count

    def take(self, count: int, power_on: PowerOn) -> Sampled:
        """The next samples of a unit that has power."""
        number = np.arange(self._next, self._next + count)
        edges = np.arange(self._next, self._next + count + 1, dtype=np.float64)
        edges_s: NDArray[np.float64] = self._begun_s + self.interval_s * edges
        self._next += count
        starts_s, ends_s = edges_s[:-1], edges_s[1:]
        housed = self.housed
        quiet = housed.surroundings.still
        acting = None if quiet else housed.surroundings.acting_through(edges_s, self.interval_s)
        outputs = np.empty((len(housed.elements), count))
        over = np.empty(outputs.shape, dtype=np.bool_)
        for row, (element, noise) in enumerate(zip(housed.elements, self._noise, strict=True)):
            if acting is None:
                rates = element.still_rates_dps(power_on, starts_s, self.interval_s)
                factors: NDArray[np.float64] | float = element.scale_factor
            else:
                rates = element.rates_dps(power_on, starts_s, acting)
                factors = element.scale_factors(acting)
            rates += noise.take(count)
            over[row] = np.abs(rates) >= element.saturation_dps
            outputs[row] = factors * element.clipped(rates) + element.zero_rate
        if self._silent:
            outputs[:] = housed.gyro.zero_rate
        temperature = housed.surroundings.temperatures_degc(ends_s)
        return Sampled(
            number=number,
            time_s=ends_s,
            outputs=outputs,
            over=over,
            temperature_degc=temperature if acting is None else acting.temperature_degc,
            starting=ends_s < power_on.on_s + BOOT_S + START_UP_S,
        )
