"""Records of a vibrating gyro whose response is known: angle of the table and output, with noise on both."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gyrotest.analysis.cross_spectra import CrossSpectra, Spectra

_Array = NDArray[np.float64]
_Complex = NDArray[np.complex128]

RATE_HZ = 400.0
LOW_HZ, HIGH_HZ = 5.0, 100.0


@dataclass(frozen=True, kw_only=True)
class Truth:
    """A second-order gyro with a delay: gain at 0 Hz in output units a °/s, −90° of its own at `natural_hz`."""

    gain: float = 1.0
    natural_hz: float = 160.0
    damping: float = 0.7
    delay_s: float = 0.0

    def response(self, frequency_hz: _Array) -> _Complex:
        ratio = np.asarray(frequency_hz) / self.natural_hz
        found: _Complex = (
            self.gain
            * np.exp(-2j * np.pi * np.asarray(frequency_hz) * self.delay_s)
            / (1.0 - ratio**2 + 2j * self.damping * ratio)
        )
        return found

    def phase_deg(self, frequency_hz: _Array) -> _Array:
        dense = np.linspace(0.0, float(np.max(frequency_hz)), 4001)
        return np.interp(frequency_hz, dense, np.degrees(np.unwrap(np.angle(self.response(dense)))))


@dataclass(frozen=True, kw_only=True)
class Vibration:
    """White random vibration over a little more than the band, and white noise as shares of its power.

    `reference` is the noise of the rate and `output` that of the output over the squared gain, both as
    densities over that of the vibration.
    """

    truth: Truth = Truth()
    reference: float = 0.005
    output: float = 0.005
    rest: bool = False

    @property
    def coherence(self) -> float:
        """At low frequencies."""
        return 1.0 / ((1.0 + self.reference) * (1.0 + self.output))

    @property
    def ratio(self) -> float:
        """κ."""
        return self.truth.gain**2 * self.output / self.reference

    def record(
        self, random: np.random.Generator, *, duration_s: float, rate_hz: float = RATE_HZ
    ) -> tuple[_Array, _Array]:
        """Angle in ° and output: noise of the angle is such that it is white as a rate."""
        samples = int(duration_s * rate_hz)
        lines = np.fft.rfftfreq(samples, 1.0 / rate_hz)
        moving = _white(random, samples) * ((lines > 2.0) & (lines < 150.0)) * (not self.rest)
        rate = moving + np.sqrt(self.reference) * _white(random, samples)
        output = self.truth.response(lines) * moving
        output += self.truth.gain * np.sqrt(self.output) * _white(random, samples)
        angle = np.divide(rate, 2j * np.pi * lines, out=np.zeros_like(rate), where=lines > 1.0)
        return np.fft.irfft(angle, samples), np.fft.irfft(output, samples)

    def spectra(
        self,
        seed: int | tuple[int, ...],
        *,
        duration_s: float,
        segment_s: float = 4.0,
        rate_hz: float = RATE_HZ,
    ) -> Spectra:
        angle, output = self.record(np.random.default_rng(seed), duration_s=duration_s, rate_hz=rate_hz)
        made = CrossSpectra(
            rate_hz=rate_hz, low_hz=LOW_HZ, high_hz=HIGH_HZ, segment=int(segment_s * rate_hz)
        )
        made.push(angle, output)
        return made.spectra()


def _white(random: np.random.Generator, samples: int) -> _Complex:
    """A white spectrum of one °/s rms."""
    return np.fft.rfft(random.normal(size=samples))
