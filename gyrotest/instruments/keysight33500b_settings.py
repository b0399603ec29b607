"""What a station says of a generator and of the vibration table behind it, and what that table cannot do."""

import math
import re
from dataclasses import dataclass
from typing import Annotated

from gyrotest.instruments.transport.serial_settings import SerialSettings
from gyrotest.records.described import Described
from gyrotest.records.plan import Excitation, Vibrating
from gyrotest.units import Dimension, OfDimension, Quantity

# The generator's Gaussian noise is cut off at so many times its root mean square.
NOISE_CREST = 4.6
# Of an open circuit; half of it across 50 ohm.
_MOST_PEAK_V = 10.0
_LEAST_PEAK_V = 1e-3
_SOURCE_OHM = 50.0
_LEAST_OHM, _MOST_OHM = 1.0, 10e3
_OHM = re.compile(r"(\d+(?:\.\d+)?) *(?:ohm|Ω)", re.IGNORECASE)
_LEAST_HZ, _MOST_HZ = 1e-3, 20e6
_LONGEST_SWEEP_S = 500.0
_SHORTEST_SWEEP_S = 1e-3
_HIGH = "high"
_OUTPUTS = (1, 2)


@dataclass(frozen=True, slots=True, kw_only=True)
class Keysight33500BSettings(SerialSettings):
    """The station's settings of a generator that drives a vibration table."""

    sensitivity: Annotated[
        Quantity,
        OfDimension(Dimension.RATE_PER_VOLTAGE),
        Described(
            "The vibration table's rate by the generator's voltage, where its response is flat.",
            "20 deg/s/V",
        ),
    ]
    max_voltage: Annotated[
        Quantity,
        OfDimension(Dimension.VOLTAGE),
        Described(
            "The highest peak that the power amplifier may be given; noise peaks at 4.6 times its rms.",
            "5 V",
        ),
    ]
    max_rate: Annotated[
        Quantity,
        OfDimension(Dimension.RATE),
        Described("The highest rms of the table's rate.", "40 deg/s"),
    ]
    output: Annotated[int, Described("The generator's output, where it has two.", "1")] = 1
    load: Annotated[
        str,
        Described(
            "The power amplifier's input: `high`, or a resistance from 1 ohm to 10000 ohm.", "high"
        ),
    ] = _HIGH

    def __post_init__(self) -> None:
        for name, value in (
            ("sensitivity", self.sensitivity),
            ("max_voltage", self.max_voltage),
            ("max_rate", self.max_rate),
        ):
            if not value.value > 0.0:
                raise ValueError(f"{name} '{value}' is not more than zero")
        if self.output not in _OUTPUTS:
            raise ValueError(f"output {self.output} is neither 1 nor 2")
        _ = self.load_ohm, self.line  # checks them

    @property
    def load_ohm(self) -> float:
        """The power amplifier's input resistance, infinity if it is high; raises `ValueError`."""
        if self.load.strip().lower() == _HIGH:
            return math.inf
        match = _OHM.fullmatch(self.load.strip())
        found = float(match[1]) if match else 0.0
        if not _LEAST_OHM <= found <= _MOST_OHM:
            raise ValueError(
                f"load '{self.load}' is neither 'high' nor {_LEAST_OHM:g} ohm to {_MOST_OHM:g} ohm; write e.g."
                " '50 ohm'"
            )
        return found

    def drive_v(self, vibrating: Vibrating) -> float:
        """The rms voltage that gives a vibration its rate, V.

        Noise reaches from 0 to its upper frequency: it has so much more in all that the band has its share.
        """
        rms_v = vibrating.rms_dps / self.sensitivity.to(Dimension.RATE_PER_VOLTAGE)
        if vibrating.excitation is Excitation.RANDOM:
            return rms_v * math.sqrt(vibrating.high_hz / (vibrating.high_hz - vibrating.low_hz))
        return rms_v

    def refusal(self, vibrating: Vibrating, *, sampled_s: float) -> str | None:
        """Why a vibration (a sweep: of that duration) cannot be; None where it can."""
        return self._unfit_band(vibrating, sampled_s) or self._unfit_level(vibrating)

    def _unfit_band(self, vibrating: Vibrating, sampled_s: float) -> str | None:
        low_hz, high_hz = vibrating.low_hz, vibrating.high_hz
        if vibrating.excitation is Excitation.SINE:
            fits = _LEAST_HZ <= low_hz <= _MOST_HZ
        else:
            least_hz = 0.0 if vibrating.excitation is Excitation.RANDOM else _LEAST_HZ
            fits = least_hz <= low_hz < high_hz and _LEAST_HZ <= high_hz <= _MOST_HZ
        if not fits:
            return (
                f"{low_hz:g} to {high_hz:g} Hz cannot be generated; frequencies are {_LEAST_HZ:g} Hz to"
                f" {_MOST_HZ:g} Hz, the lower one first"
            )
        swept = vibrating.excitation is Excitation.SWEEP
        if swept and not _SHORTEST_SWEEP_S <= sampled_s <= _LONGEST_SWEEP_S:
            return (
                f"a sweep of {sampled_s:g} s is asked for, a logarithmic one of this generator lasts"
                f" {_SHORTEST_SWEEP_S:g} s to {_LONGEST_SWEEP_S:g} s; change the duration, or step the frequency"
            )
        return None

    def _unfit_level(self, vibrating: Vibrating) -> str | None:
        rms_dps, most_dps = vibrating.rms_dps, self.max_rate.to(Dimension.RATE)
        if not 0.0 < rms_dps <= most_dps:
            return (
                f"{rms_dps:g} deg/s rms is asked for, the station allows more than 0 and up to {most_dps:g} deg/s"
                " (settings.max_rate); change the level, or correct the station"
            )
        random = vibrating.excitation is Excitation.RANDOM
        crest = NOISE_CREST if random else math.sqrt(2.0)
        peak_v = crest * self.drive_v(vibrating)
        most_v = self.max_voltage.to("V")
        if peak_v > most_v:
            return (
                f"{rms_dps:g} deg/s rms drives the amplifier up to {peak_v:.3g} V peak ({crest:.3g} times the"
                f" rms), the station allows {most_v:g} V (settings.max_voltage); lower the level, or correct the"
                " station"
            )
        least_v, highest_v = _LEAST_PEAK_V * self.load_share, _MOST_PEAK_V * self.load_share
        if not least_v <= peak_v <= highest_v:
            return (
                f"{rms_dps:g} deg/s rms needs {peak_v:.3g} V peak, the generator gives {least_v:.3g} V to"
                f" {highest_v:.3g} V into this load; change the level or the amplifier's gain"
            )
        return None

    @property
    def load_share(self) -> float:
        """The share of the generator's open-circuit voltage that is left across the load."""
        return 1.0 if math.isinf(self.load_ohm) else self.load_ohm / (self.load_ohm + _SOURCE_OHM)
