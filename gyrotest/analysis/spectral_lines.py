"""Spectral lines: what stands out of a record's spectrum, by Welch's method.

Lines (mains, a resonance, a clock) raise the Allan variance at short times, where they would pass
for angle random walk or quantization noise.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gyrotest.analysis.noise_model import SpectralLine
from gyrotest.analysis.noise_terms import Grid, allan_response

_LONGEST_SEGMENT = 16384
_SHORTEST_SEGMENT = 128
_FEWEST_SEGMENTS = 16
_AT_ONCE = 32

_NEIGHBOURS = 20
_WIDE = 32
_MOST = 0.7
_LEAKAGE = 2
_FALSE_ALARMS = 1e-3
_LEAST_RATIO = 1.5
_RELATIVE = 0.05
_HANN_FREEDOM = 36.0 / 19.0
_HANN_SPREAD = 1.94
"""Neighbouring bins of a Hann window are not independent: the sum over a line spreads that much more."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Spectrum:
    """One-sided spectral density (f,), (°/s)²/Hz, of half-overlapping Hann segments.

    `freedom` are the degrees of freedom of each value.
    """

    frequency_hz: NDArray[np.float64]
    density: NDArray[np.float64]
    freedom: float

    def coarser(self, bins: int) -> "Spectrum":
        """Average neighbouring bins; a tail of fewer is left out."""
        size = self.density.size // bins * bins
        return Spectrum(
            frequency_hz=self.frequency_hz[:size].reshape(-1, bins).mean(axis=1),
            density=self.density[:size].reshape(-1, bins).mean(axis=1),
            freedom=self.freedom * bins / _HANN_SPREAD,
        )


@dataclass(frozen=True, slots=True, kw_only=True)
class Excess:
    """A line's power (bins,), (°/s)², at its frequencies, and the standard uncertainty of their sum."""

    frequency_hz: NDArray[np.float64]
    power: NDArray[np.float64]
    standard_uncertainty: float

    def overlaps(self, other: "Excess") -> bool:
        """Whether two excesses share frequencies."""
        return bool(
            self.frequency_hz[0] <= other.frequency_hz[-1]
            and other.frequency_hz[0] <= self.frequency_hz[-1]
        )

    @property
    def line(self) -> SpectralLine:
        """The line as a sine."""
        total = float(self.power.sum())
        amplitude = float(np.sqrt(2.0 * total))
        return SpectralLine(
            frequency_hz=float(self.power @ self.frequency_hz) / total,
            amplitude_dps=amplitude,
            standard_uncertainty_dps=self.standard_uncertainty / amplitude,
        )

    def allan_variances(self, factors: NDArray[np.int64], grid: Grid) -> NDArray[np.float64]:
        """Return what the line adds to the Allan variances (k,)."""
        added: NDArray[np.float64] = allan_response(self.frequency_hz, factors, grid) @ self.power
        return added


def spectrum(rate_dps: NDArray[np.float64], *, sample_rate_hz: float) -> Spectrum | None:
    """Estimate the spectral density of a record (n,); None where it is too short for sixteen segments.

    Notes
    -----
    P. D. Welch, IEEE Trans. Audio Electroacoust. 15, 70, 1967. Piece by piece, since a library's
    transform of all segments at once takes several times the record's memory.
    """
    size = min(
        1 << max((2 * rate_dps.size // (_FEWEST_SEGMENTS + 1)).bit_length() - 1, 0), _LONGEST_SEGMENT
    )
    if size < _SHORTEST_SEGMENT:
        return None
    window = 0.5 - 0.5 * np.cos(2.0 * np.pi * np.arange(size) / size)
    segments = np.lib.stride_tricks.sliding_window_view(rate_dps, size)[:: size // 2]
    total = np.zeros(size // 2 + 1)
    for begin in range(0, segments.shape[0], _AT_ONCE):
        piece = segments[begin : begin + _AT_ONCE]
        transform = np.fft.rfft((piece - piece.mean(axis=1, keepdims=True)) * window, axis=1)
        total += np.sum(transform.real**2 + transform.imag**2, axis=0)
    count = segments.shape[0]
    return Spectrum(
        frequency_hz=np.asarray(np.fft.rfftfreq(size, 1.0 / sample_rate_hz), dtype=np.float64),
        density=total * 2.0 / (sample_rate_hz * float(window @ window) * count),
        freedom=_HANN_FREEDOM * count,
    )


def lines_in(found: Spectrum) -> tuple[Excess, ...]:
    """Find the lines: wide ones (a resonance), and narrow ones (mains, a clock) beside them.

    A strong narrow one stands out of the coarser spectrum too: it is narrow if most of it is.
    """
    narrow = _standing_out(found)
    wide = [one for one in _standing_out(found.coarser(_WIDE)) if not _consists_of(one, narrow)]
    return (*wide, *(one for one in narrow if not any(one.overlaps(each) for each in wide)))


def _consists_of(wide: Excess, narrow: tuple[Excess, ...]) -> bool:
    power = sum(float(one.power.sum()) for one in narrow if one.overlaps(wide))
    return power > _MOST * float(wide.power.sum())


def _standing_out(found: Spectrum) -> tuple[Excess, ...]:
    """Find bins that exceed the floor about them by more than chance and by half at least."""
    from scipy.special import chdtri

    if found.density.size < 3 * _NEIGHBOURS:
        return ()

    floor = _floor(found)
    size = found.density.size
    by_chance = float(chdtri(found.freedom, _FALSE_ALARMS / size)) / found.freedom
    standing_out = found.density > floor * max(by_chance, _LEAST_RATIO)
    # The lowest bins belong to flicker and drift, the last one has no neighbour beyond.
    standing_out[:_NEIGHBOURS] = False
    standing_out[-1] = False
    places = np.flatnonzero(standing_out)
    if not places.size:
        return ()
    groups = np.split(places, np.flatnonzero(np.diff(places) > _LEAKAGE + 1) + 1)
    return tuple(_excess(found, floor, group) for group in groups if group.size <= _NEIGHBOURS)


def _floor(found: Spectrum) -> NDArray[np.float64]:
    """Return the density without lines: the running median, made a mean by the chi-square's ratio."""
    from scipy.special import chdtri

    padded = np.pad(found.density[1:], (_NEIGHBOURS + 1, _NEIGHBOURS), mode="reflect")
    windows = np.lib.stride_tricks.sliding_window_view(padded, 2 * _NEIGHBOURS + 1)
    median_over_mean = float(chdtri(found.freedom, 0.5)) / found.freedom
    floor: NDArray[np.float64] = np.median(windows, axis=1) / median_over_mean
    return floor


def _excess(found: Spectrum, floor: NDArray[np.float64], group: NDArray[np.intp]) -> Excess:
    begin = max(int(group[0]) - _LEAKAGE, 1)
    end = min(int(group[-1]) + _LEAKAGE + 1, found.density.size)
    width_hz = float(found.frequency_hz[1] - found.frequency_hz[0])
    power = np.maximum(found.density[begin:end] - floor[begin:end], 0.0) * width_hz
    noise = found.density[begin:end] * width_hz
    by_chance = np.sum(noise**2) * 2.0 / found.freedom * _HANN_SPREAD
    return Excess(
        frequency_hz=found.frequency_hz[begin:end],
        power=power,
        standard_uncertainty=float(np.hypot(np.sqrt(by_chance), _RELATIVE * power.sum())),
    )
