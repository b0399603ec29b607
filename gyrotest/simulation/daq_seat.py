"""A slot in front of a simulated acquisition system: what its unit and its encoder give at each instant."""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gyrotest.records.station import Encoder, Slot
from gyrotest.simulation.daq_axis import AxisOutput, Grid
from gyrotest.simulation.daq_converter import ChannelConverter
from gyrotest.simulation.daq_faults import DaqFaults
from gyrotest.simulation.daq_settings import output_channels
from gyrotest.simulation.grating import AngleError, Grating
from gyrotest.simulation.gyro import TemperatureOutput
from gyrotest.simulation.housed import Housed
from gyrotest.simulation.motion import Motion, Path
from gyrotest.simulation.scenarios import Misbehaviour

# What a rail does to an output: more than any range.
_RAIL_V = 1e3


@dataclass(frozen=True, slots=True, kw_only=True)
class Reader:
    """How a slot's encoder reads its angle: by a grating's signals (None: the angle itself), with an error."""

    encoder: Encoder
    error: AngleError
    grating: Grating | None

    def read(self, channel: str, angle_deg: NDArray[np.float64]) -> NDArray[np.float64]:
        """What a channel of the encoder gives at true angles, (n,), V or °."""
        counted_deg = self.error.read_deg(angle_deg)
        if self.encoder.reversed:
            counted_deg = -counted_deg
        if self.grating is None or channel == self.encoder.angle:
            return counted_deg
        wave = self.grating.sine_v if channel == self.encoder.sine else self.grating.cosine_v
        return wave(counted_deg)

    def truth(self) -> dict[str, float]:
        """The drawn figures, for the record."""
        name = self.encoder.angle or self.encoder.sine
        found = {
            "encoder_error_deg": self.error.amplitude_deg,
            "encoder_error_phase_deg": math.degrees(self.error.phase_rad),
        }
        if self.grating is not None:
            found |= self.grating.truth()
        return {f"{name}.{key}": value for key, value in found.items()}


class Seat:
    """A unit in its slot, for one record; asked for its samples in the order of time.

    `moved` tells what moves it when an acquisition begins; `converters` are those of all its channels.
    `dead`: its output stays at the zero-rate level.
    """

    def __init__(
        self,
        slot: Slot,
        housed: Housed,
        *,
        moved: Callable[[], Motion],
        reader: Reader | None,
        converters: Mapping[str, ChannelConverter],
        faults: DaqFaults,
        dead: bool,
        seed: int,
    ) -> None:
        self.housed = housed
        self.faults = faults
        self._moved = moved
        self._motion = moved()
        self.reader = reader
        self.converters = converters
        self._dead = dead
        names = output_channels(slot, housed.gyro.axes)
        self._outputs = {
            name: AxisOutput(element, housed, seed=seed)
            for name, element in zip(names, housed.elements, strict=True)
        }
        self._beside = frozenset(slot.auxiliary.values())
        self._grid = Grid(origin_s=0.0, step=1, knot_s=1.0)
        self._path = Path(0, 1.0)
        self._next = 0

    @property
    def knots_hz(self) -> float:
        """How many knots a second its motion needs at least."""
        damped = all(one.axis.dynamics.damping > 0.0 for one in self.housed.elements)
        return self._motion.knots_hz(damped=damped)

    def knots_ahead(self, grid: Grid) -> int:
        """How many knots after a sample's own one its channels need."""
        latest_s = max(one.wire.shift_s for one in self.converters.values()) + self._motion.late_s
        return 1 + max(0, math.floor(latest_s / grid.knot_s))

    def prepare(self) -> None:
        """Look for what moves it: an acquisition is about to begin."""
        self._motion = self._moved()

    def begin(self, grid: Grid, *, before: int) -> None:
        """Samples from the number `-before` on come next."""
        settling = [self._motion.settling_s]
        settling += [one.axis.dynamics.settling_s for one in self.housed.elements]
        self._grid = grid
        self._next = -before * grid.step - math.ceil(max(settling) / grid.knot_s)
        self._motion.begin(self._next, origin_s=grid.origin_s, interval_s=grid.knot_s)
        self._path = Path(self._next, grid.knot_s)
        for name, output in self._outputs.items():
            # Rates that are late are those of an earlier instant.
            shift_s = self.converters[name].wire.shift_s + self._motion.late_s
            output.begin(grid, self._next, shift_s=shift_s)

    def extend(self, last: int) -> None:
        """Let it move up to a knot."""
        count = last + 1 - self._next
        if count <= 0:
            return
        knots = self._motion.take(count)
        temperature = self.housed.surroundings.temperatures_degc(self._grid.knots_s(self._next, count))
        self._path.extend(knots)
        for output in self._outputs.values():
            output.extend(knots, self._next, temperature)
        self._next += count

    def take(self, channel: str, first: int, count: int) -> NDArray[np.float64]:
        """What a channel gives at the next samples, (count,), V or °."""
        times_s = self._grid.samples_s(first, count)
        if channel in self._outputs:
            return self._output(channel, first, times_s)
        if channel in self._beside:
            beside = TemperatureOutput(self.housed.surroundings)
            return beside.mean_voltages(
                float(times_s[0]), self._grid.interval_s, self._grid.interval_s, count
            )
        return self._read(channel, first, times_s)

    def _output(self, channel: str, first: int, times_s: NDArray[np.float64]) -> NDArray[np.float64]:
        temperature = self.housed.surroundings.temperatures_degc(times_s)
        given = self._outputs[channel].take(first, len(times_s), temperature)
        if self._dead:
            given = np.full(len(times_s), self.housed.gyro.zero_rate)
        railed = self.faults.during(Misbehaviour.RAIL, times_s)
        if railed is not None:
            given[railed] = _RAIL_V
        return given

    def _read(self, channel: str, first: int, times_s: NDArray[np.float64]) -> NDArray[np.float64]:
        if self.reader is None:
            raise ValueError(f"'{channel}' is no channel of this slot")
        angle_deg = self._path.angles_deg(
            first * self._grid.step,
            len(times_s),
            step=self._grid.step,
            shift_s=self.converters[channel].wire.shift_s,
        )
        read = self.reader.read(channel, angle_deg)
        dark = self.faults.during(Misbehaviour.ENCODER_DARK, times_s)
        return read if dark is None else np.where(dark, 0.0, read)
