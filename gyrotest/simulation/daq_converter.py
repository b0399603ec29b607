"""The converters of a simulated acquisition system: a quantity on each channel to numbers of 32 bits."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gyrotest.simulation.blocks import CLIPPED
from gyrotest.simulation.daq_settings import DaqParameters
from gyrotest.simulation.streams import generator

# A converter has 24 bits; an angle comes as a number.
_STEPS = 2.0**23
_ANGLE_STEP_DEG = 1e-6
_ANGLE_RANGE_DEG = 2000.0


@dataclass(frozen=True, slots=True, kw_only=True)
class Wire:
    """A channel as it was drawn for a record: its errors and its noise, in V or °.

    It is sampled `shift_s` later than the system's own instant, of which `skew_error_s` is not known.
    """

    shift_s: float = 0.0
    skew_error_s: float = 0.0
    gain: float = 0.0
    offset: float = 0.0
    noise: float = 0.0


class ChannelConverter:
    """Makes numbers of what a channel is given; `analogue`: by a voltage, through a low-pass."""

    def __init__(
        self,
        wire: Wire,
        *,
        scale: float,
        full_scale: float,
        analogue: bool,
        source: np.random.Generator,
    ) -> None:
        self.wire = wire
        self.analogue = analogue
        self._factor = (1.0 + wire.gain) / scale
        self._offset = wire.offset / scale
        self._noise = wire.noise / scale
        self._end = full_scale / scale
        self._source = source

    def numbers(self, values: NDArray[np.float64]) -> NDArray[np.float64]:
        """What is transferred, (n,): whole numbers."""
        raw = values * self._factor
        raw += self._offset
        if self._noise:
            raw += self._noise * self._source.standard_normal(raw.size)
        np.rint(raw, out=raw)
        if raw.max() >= self._end or raw.min() <= -self._end:
            raw[raw >= self._end] = CLIPPED
            raw[raw <= -self._end] = -CLIPPED
        return raw


@dataclass(frozen=True, slots=True, kw_only=True)
class Converters:
    """An acquisition system's converters: all have one range, but for those of an angle."""

    name: str
    parameters: DaqParameters
    seed: int

    def unit(self, channel: str) -> str:
        """The unit of a channel's values."""
        return "deg" if channel in self.parameters.angles else "V"

    def scale(self, channel: str) -> float:
        """What a step of a channel's numbers stands for."""
        return _ANGLE_STEP_DEG if channel in self.parameters.angles else self.parameters.range_v / _STEPS

    def full_scale(self, channel: str) -> float:
        """Where a channel is clipped."""
        return _ANGLE_RANGE_DEG if channel in self.parameters.angles else self.parameters.range_v

    def make(self, channel: str, wire: Wire, *names: str | int) -> ChannelConverter:
        """A channel's converter; `names` are what its noise depends on."""
        step = self.scale(channel)
        return ChannelConverter(
            wire,
            scale=step,
            # The last step of all bits is the end.
            full_scale=self.full_scale(channel) - step,
            analogue=channel not in self.parameters.angles,
            source=generator(self.seed, "daq noise", self.name, *names, channel),
        )

    def draw(self, channel: str, serial_number: str, *, noise_v: float = 0.0, skewed: bool) -> Wire:
        """Throw the dice for a channel as it is when a unit is tested.

        `noise_v` is what its signal brings with it; only what is `skewed` is sampled at another instant
        than stated.
        """
        parameters = self.parameters
        source = generator(self.seed, "daq errors", serial_number, self.name, channel)
        gain, offset, skew = (float(one) for one in source.uniform(-1.0, 1.0, 3))
        error_s = parameters.skew_uncertainty_s * skew if skewed else 0.0
        shift_s = parameters.nominal_skew_of(channel) + error_s
        if channel in parameters.angles:
            return Wire(shift_s=shift_s, skew_error_s=error_s, noise=parameters.encoder_noise_deg)
        return Wire(
            shift_s=shift_s,
            skew_error_s=error_s,
            gain=gain * parameters.gain_error,
            offset=offset * parameters.offset_error_of_range * parameters.range_v,
            noise=float(np.hypot(parameters.noise_v, noise_v)),
        )
