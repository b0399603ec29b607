"""One axis of a unit in front of a simulated acquisition system: its output at each sample's own instant."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gyrotest.simulation.dynamics import Follower
from gyrotest.simulation.element import Element
from gyrotest.simulation.housed import Housed
from gyrotest.simulation.motion import KEPT, Kept, Knots
from gyrotest.simulation.stream_noise import StreamNoise
from gyrotest.simulation.streams import generator
from gyrotest.simulation.surroundings import Acting


@dataclass(frozen=True, slots=True, kw_only=True)
class Grid:
    """When samples are taken: from `origin_s` on, `step` knots from one to the next; `knot_s` between knots."""

    origin_s: float
    step: int
    knot_s: float

    @property
    def interval_s(self) -> float:
        """From sample to sample."""
        return self.step * self.knot_s

    def knots_s(self, first: int, count: int) -> NDArray[np.float64]:
        """The times of knots, (count,)."""
        return self.origin_s + self.knot_s * np.arange(first, first + count, dtype=np.float64)

    def samples_s(self, first: int, count: int) -> NDArray[np.float64]:
        """The times of samples, (count,)."""
        return self.origin_s + self.interval_s * np.arange(first, first + count, dtype=np.float64)


class _Noise:
    """The unit's noise, from acquisition to acquisition in real time; at another interval another one."""

    def __init__(self, housed: Housed, axis: str, *, seed: int) -> None:
        self._housed = housed
        self._names = (*housed.occasion.stream, axis) if axis else housed.occasion.stream
        self._seed = seed
        self._stream: StreamNoise | None = None
        self._interval_s = 0.0
        self._until_s = 0.0
        self._made = 0

    def begin(self, grid: Grid) -> None:
        """A sample every interval from the grid's origin on."""
        if self._stream is None or self._interval_s != grid.interval_s:
            self._stream = self._new(grid)
        else:
            self._stream.skip(max(0, round((grid.origin_s - self._until_s) / grid.interval_s)))
        self._interval_s = grid.interval_s
        self._until_s = grid.origin_s

    def take(self, count: int) -> NDArray[np.float64]:
        """The noise of the next samples, (count,), deg/s."""
        if self._stream is None:
            raise ValueError("the noise is taken before it begins")
        self._until_s += count * self._interval_s
        return self._stream.take(count)

    def _new(self, grid: Grid) -> StreamNoise:
        housed = self._housed
        again = (self._made,) if self._made else ()
        self._made += 1
        return StreamNoise(
            housed.gyro.noise,
            generator(self._seed, "gyro noise", *self._names, *again),
            interval_s=grid.interval_s,
            since_power_on_s=max(0.0, housed.occasion.elapsed_s + grid.origin_s - housed.begun_s),
        )


class AxisOutput:
    """Follows its rate by its own dynamics; its noise beside that; until it saturates."""

    def __init__(self, element: Element, housed: Housed, *, seed: int) -> None:
        self._element = element
        self._housed = housed
        self._noise = _Noise(housed, element.axis.name, seed=seed)
        self._grid = Grid(origin_s=0.0, step=1, knot_s=1.0)
        self._ahead = 0
        self._follower: Follower | None = None
        self._answers = Kept(0)

    def begin(self, grid: Grid, first: int, *, shift_s: float) -> None:
        """Knots from `first` on come next; the samples lie `shift_s` after theirs."""
        follower = Follower(self._element.axis.dynamics, interval_s=grid.knot_s, shift_s=shift_s)
        self._grid, self._follower, self._ahead = grid, follower, follower.ahead
        self._answers = Kept(first, KEPT + max(0, -follower.ahead))
        self._noise.begin(grid)

    def extend(self, knots: Knots, first: int, temperature_degc: NDArray[np.float64]) -> None:
        """Take the next knots, from `first` on."""
        if self._follower is None:
            raise ValueError("knots are taken before the acquisition begins")
        # Rates at a knot are those of a turn as long as a knot, about it.
        half_s = 0.5 * self._grid.knot_s
        half_deg = half_s * knots.rate_dps
        acting = Acting(
            aperture_s=2.0 * half_s,
            from_deg=knots.angle_deg - half_deg,
            to_deg=knots.angle_deg + half_deg,
            temperature_degc=temperature_degc,
        )
        times_s = self._grid.knots_s(first, len(half_deg)) - half_s
        power_on = self._housed.power_on or self._housed.planned
        rates_dps = self._element.rates_dps(power_on, times_s, acting)
        self._answers.extend(self._follower.follow(rates_dps))

    def take(self, first: int, count: int, temperature_degc: NDArray[np.float64]) -> NDArray[np.float64]:
        """The output at the next samples, (count,), in its unit."""
        element, grid = self._element, self._grid
        if self._housed.power_on is None:
            self._noise.take(count)
            return np.zeros(count)
        answers = self._answers.every(grid.step, first * grid.step + self._ahead, count)
        rates_dps = element.clipped(answers + self._noise.take(count))
        acting = Acting(
            aperture_s=grid.interval_s,
            from_deg=None,
            to_deg=None,
            temperature_degc=temperature_degc,
        )
        return np.asarray(element.scale_factors(acting) * rates_dps + element.zero_rate)
