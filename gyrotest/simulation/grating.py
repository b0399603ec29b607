"""A simulated encoder: a circular grating's two signals with their faults, or the angle with its own."""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True, slots=True, kw_only=True)
class GratingFigures:
    """What a grating's signals may be like: half-widths in proportion to the amplitude where nothing else is said.

    `ripple` is how far the amplitude changes around a turn, `harmonic` the share of the third harmonic.
    """

    amplitude_v: float = 1.0
    offset: float = 0.02
    mismatch: float = 0.02
    quadrature_deg: float = 1.0
    harmonic: float = 0.001
    ripple: float = 0.005
    noise_v: float = 2e-4


@dataclass(frozen=True, slots=True, kw_only=True)
class AngleError:
    """An encoder's error within a turn, of a ring that does not sit quite in the middle."""

    amplitude_deg: float = 0.0
    phase_rad: float = 0.0

    def read_deg(self, angle_deg: NDArray[np.float64]) -> NDArray[np.float64]:
        """What is read at true angles, (n,)."""
        if self.amplitude_deg == 0.0:
            return angle_deg
        return angle_deg + self.amplitude_deg * np.sin(np.radians(angle_deg) + self.phase_rad)


@dataclass(frozen=True, slots=True, kw_only=True)
class Grating:
    """A grating's two signals, as they were drawn for a record; `begins_rad` is their phase at the angle 0."""

    lines: int
    begins_rad: float
    amplitude_v: float
    sine_offset_v: float
    cosine_offset_v: float
    mismatch: float
    quadrature_rad: float
    harmonic: float
    ripple: float
    ripple_phase_rad: float

    def sine_v(self, angle_deg: NDArray[np.float64]) -> NDArray[np.float64]:
        """The sine signal at angles as the grating counts them, (n,), V."""
        wave = np.sin(self._phase_rad(angle_deg))
        # sin 3φ = 3 sin φ − 4 sin³ φ
        wave *= 1.0 + self.harmonic * (3.0 - 4.0 * wave * wave)
        return np.asarray(self.sine_offset_v + self._amplitude_v(angle_deg) * wave)

    def cosine_v(self, angle_deg: NDArray[np.float64]) -> NDArray[np.float64]:
        """The cosine signal, (n,), V: with another amplitude, and not quite a quarter of a line away."""
        wave = np.cos(self._phase_rad(angle_deg) + self.quadrature_rad)
        # cos 3φ = 4 cos³ φ − 3 cos φ
        wave *= 1.0 + self.harmonic * (4.0 * wave * wave - 3.0)
        amplitude_v = (1.0 + self.mismatch) * self._amplitude_v(angle_deg)
        return np.asarray(self.cosine_offset_v + amplitude_v * wave)

    def _phase_rad(self, angle_deg: NDArray[np.float64]) -> NDArray[np.float64]:
        return np.asarray(math.radians(self.lines) * angle_deg + self.begins_rad)

    def _amplitude_v(self, angle_deg: NDArray[np.float64]) -> NDArray[np.float64]:
        turned = np.radians(angle_deg) + self.ripple_phase_rad
        return np.asarray(self.amplitude_v * (1.0 + self.ripple * np.cos(turned)))

    def truth(self) -> dict[str, float]:
        """The drawn figures, for the record."""
        return {
            "grating_sine_offset_v": self.sine_offset_v,
            "grating_cosine_offset_v": self.cosine_offset_v,
            "grating_mismatch": self.mismatch,
            "grating_quadrature_deg": math.degrees(self.quadrature_rad),
            "grating_harmonic": self.harmonic,
            "grating_ripple": self.ripple,
        }


def draw_grating(lines: int, figures: GratingFigures, source: np.random.Generator) -> Grating:
    """Throw the dice for a grating's signals."""
    sine, cosine, mismatch, quadrature, harmonic, ripple = source.uniform(-1.0, 1.0, 6)
    begins, phase = source.uniform(0.0, 2.0 * math.pi, 2)
    amplitude_v = figures.amplitude_v
    return Grating(
        lines=lines,
        begins_rad=float(begins),
        amplitude_v=amplitude_v,
        sine_offset_v=float(sine) * figures.offset * amplitude_v,
        cosine_offset_v=float(cosine) * figures.offset * amplitude_v,
        mismatch=float(mismatch) * figures.mismatch,
        quadrature_rad=float(quadrature) * math.radians(figures.quadrature_deg),
        harmonic=float(harmonic) * figures.harmonic,
        ripple=float(ripple) * figures.ripple,
        ripple_phase_rad=float(phase),
    )


def draw_angle_error(half_width_deg: float, source: np.random.Generator) -> AngleError:
    """Throw the dice for an encoder's error within a turn; it is never beyond the half-width."""
    return AngleError(
        amplitude_deg=half_width_deg * float(source.uniform()),
        phase_rad=float(source.uniform(0.0, 2.0 * math.pi)),
    )
