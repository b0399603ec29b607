"""Sine fits of records (IEEE 1057): with a known frequency, by sums, or with one that is fitted as well."""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gyrotest.analysis.fixed import fixed
from gyrotest.errors import InsufficientDataError

_Array = NDArray[np.float64]

FEWEST_SAMPLES = 8
_CHUNK = 65536
_MOST_ROUNDS = 30
_CONVERGED = 1e-11
_SAME = 1e-12
_WORST_CONDITION = 1e6
_LOOKED_AT = 1 << 20


@dataclass(frozen=True, slots=True, kw_only=True)
class SineFit:
    """The sine `sine·sin ω(t − at_s) + cosine·cos ω(t − at_s) + offset`, t from the first sample, s.

    In the values' unit. `covariance` (3, 3) is that of (sine, cosine, offset), by the residual as white
    noise; the frequency's share is in it where that was fitted, which `frequency_uncertainty_hz` then tells.
    """

    frequency_hz: float
    sine: float
    cosine: float
    offset: float
    covariance: _Array
    residual_rms: float
    degrees_of_freedom: int
    samples: int
    at_s: float = 0.0
    frequency_uncertainty_hz: float | None = None

    @property
    def phasor(self) -> complex:
        """The complex amplitude E of `Re[E·exp jω(t − at_s)]`."""
        return complex(self.cosine, -self.sine)

    @property
    def amplitude(self) -> float:
        """The sine's peak."""
        return abs(self.phasor)

    @property
    def phase_deg(self) -> float:
        """The phase of its cosine at `at_s`, °."""
        return math.degrees(math.atan2(-self.sine, self.cosine))

    @property
    def amplitude_uncertainty(self) -> float:
        """Standard uncertainty of the amplitude."""
        along = np.array([self.sine, self.cosine, 0.0]) / self.amplitude
        return float(np.sqrt(along @ self.covariance @ along))

    @property
    def phase_uncertainty_deg(self) -> float:
        """Standard uncertainty of the phase, °."""
        across = np.array([-self.cosine, self.sine, 0.0]) / self.amplitude**2
        return math.degrees(float(np.sqrt(across @ self.covariance @ across)))


class SineSums:
    """A fit with a known frequency, of values that stream by: memory does not grow.

    Parameters
    ----------
    frequency_hz
        The sine's frequency.
    interval_s
        Time between two samples, s.

    Notes
    -----
    IEEE 1057, three-parameter fit.
    """

    def __init__(self, frequency_hz: float, interval_s: float) -> None:
        self._frequency_hz = frequency_hz
        self._per_sample = 2.0 * math.pi * frequency_hz * interval_s
        self._origin: float | None = None
        self._normal = np.zeros((3, 3))
        self._right = np.zeros(3)
        self._squares = 0.0
        self._seen = 0

    def push(self, values: _Array, *, missing: int = 0) -> None:
        """Take the next values (n,); `missing` are not there between the last ones and these."""
        self._seen += missing
        if self._origin is None and values.size:
            self._origin = float(values.mean())
        for begin in range(0, values.size, _CHUNK):
            self._add(values[begin : begin + _CHUNK])

    def fit(self) -> SineFit:
        """Return the fit; raises `InsufficientDataError`."""
        samples = round(float(self._normal[2, 2]))
        freedom = samples - 3
        if samples < FEWEST_SAMPLES or self._origin is None:
            raise InsufficientDataError(
                f"{samples} samples are too few for a sine; {FEWEST_SAMPLES} are needed"
            )
        inverse = _inverse(self._normal)
        sine, cosine, offset = inverse @ self._right
        explained = float(self._right @ (inverse @ self._right))
        variance = max(self._squares - explained, 0.0) / freedom
        return SineFit(
            frequency_hz=self._frequency_hz,
            sine=float(sine),
            cosine=float(cosine),
            offset=float(offset) + self._origin,
            covariance=fixed(variance * inverse),
            residual_rms=math.sqrt(variance * freedom / samples),
            degrees_of_freedom=freedom,
            samples=samples,
        )

    def _add(self, values: _Array) -> None:
        waves = _waves(self._per_sample, np.arange(self._seen, self._seen + values.size))
        centred = values - (self._origin or 0.0)
        self._normal += waves @ waves.T
        self._right += waves @ centred
        self._squares += float(centred @ centred)
        self._seen += values.size


def three_parameter_fit(values: _Array, *, frequency_hz: float, interval_s: float) -> SineFit:
    """Fit a sine of a known frequency to values (n,), n at least 8 (IEEE 1057).

    Parameters
    ----------
    values
        Shape (n,), any unit, a sample every `interval_s`.
    frequency_hz
        Its frequency, above 0 and below half the sampling rate.
    interval_s
        Time between two samples, s.

    Raises
    ------
    InsufficientDataError
        Too few samples, or too short a record for the frequency.
    """
    sums = SineSums(frequency_hz, interval_s)
    sums.push(values)
    return sums.fit()


def four_parameter_fit(
    values: _Array, *, interval_s: float, frequency_hz: float | None = None
) -> SineFit:
    """Fit a sine and its frequency to values (n,), n at least 8 (IEEE 1057).

    Parameters
    ----------
    values
        Shape (n,), any unit, a sample every `interval_s`.
    interval_s
        Time between two samples, s.
    frequency_hz
        Where to begin, within half of the record's resolution 1/(n·interval_s); None: at the greatest peak
        of the spectrum.

    Returns
    -------
    The fit, its phase that in the middle of the record, where frequency and phase do not depend on one
    another.

    Raises
    ------
    InsufficientDataError
        Too few samples, less than a whole period of a sine, or none that the iteration settles on.

    Notes
    -----
    Gauss–Newton steps with sin ωt, cos ωt, 1 and t·∂/∂ω, t from the record's middle.
    """
    if values.size < FEWEST_SAMPLES:
        raise InsufficientDataError(
            f"{values.size} samples are too few for a sine; {FEWEST_SAMPLES} are needed"
        )
    start_hz = spectral_peak_hz(values, interval_s) if frequency_hz is None else frequency_hz
    per_sample = 2.0 * math.pi * start_hz * interval_s
    step = _step(values, per_sample, None)
    for _ in range(_MOST_ROUNDS):
        step = _step(values, per_sample, step)
        per_sample += step.turned / step.middle
        if not 0.0 < per_sample < math.pi:
            break
        if abs(step.turned) < _CONVERGED:
            return _fitted(step, per_sample, interval_s)
    raise InsufficientDataError(
        f"no sine near {start_hz:.6g} Hz is found in {values.size} samples of {interval_s:.6g} s: the fit does not"
        " settle"
    )


def spectral_peak_hz(
    values: _Array, interval_s: float, *, low_hz: float = 0.0, high_hz: float = math.inf
) -> float:
    """Return the frequency of the greatest peak in a record's spectrum, between its lines by a parabola.

    Looked for between two frequencies, and of a long record in the first million samples, which are tapered
    by Hann's window. Raises `InsufficientDataError` where there is none.
    """
    looked_at = values[:_LOOKED_AT] - values[:_LOOKED_AT].mean()
    spectrum = np.abs(np.fft.rfft(looked_at * np.hanning(looked_at.size)))
    frequencies_hz = np.fft.rfftfreq(looked_at.size, interval_s)
    inside = (frequencies_hz >= low_hz) & (frequencies_hz <= high_hz)
    inside[[0, -1]] = False
    peak = int(np.argmax(np.where(inside, spectrum, -1.0)))
    if not (inside[peak] and spectrum[peak] > 0.0):
        raise InsufficientDataError("the record is constant, or too short: there is no sine in it")
    below, at, above = np.log(np.maximum(spectrum[peak - 1 : peak + 2], spectrum[peak] * _SAME))
    curvature = below - 2.0 * at + above
    shift = 0.5 * (below - above) / curvature if curvature < 0.0 else 0.0
    return float((peak + shift) / (looked_at.size * interval_s))


@dataclass(frozen=True, slots=True, kw_only=True)
class _Step:
    """A least-squares step, phases counted from the record's middle.

    `solution` are sine, cosine and offset from `origin`, then by how much the phase turns at the ends.
    """

    solution: _Array
    inverse: _Array
    squares: float
    origin: float
    samples: int

    @property
    def middle(self) -> float:
        """The middle sample."""
        return (self.samples - 1) / 2.0

    @property
    def turned(self) -> float:
        """By how much the phase turned at the record's ends, radians."""
        return float(self.solution[3])


def _step(values: _Array, per_sample: float, before: _Step | None) -> _Step:
    """Take a step: the first one at the given frequency, the others about what was found before."""
    columns, middle, origin = 3 if before is None else 4, (values.size - 1) / 2.0, float(values.mean())
    normal, right, squares = np.zeros((columns, columns)), np.zeros(columns), 0.0
    for begin in range(0, values.size, _CHUNK):
        centred = values[begin : begin + _CHUNK] - origin
        ticks = np.arange(begin, begin + centred.size) - middle
        waves = _waves(per_sample, ticks)
        if before is not None:
            sine, cosine = before.solution[:2]
            turning = (ticks / middle) * (sine * waves[1] - cosine * waves[0])
            waves = np.vstack((waves, turning))
        normal += waves @ waves.T
        right += waves @ centred
        squares += float(centred @ centred)
    inverse = _inverse(normal)
    solution = inverse @ right
    return _Step(
        solution=solution,
        inverse=inverse,
        squares=max(squares - float(right @ solution), 0.0),
        origin=origin,
        samples=values.size,
    )


def _fitted(step: _Step, per_sample: float, interval_s: float) -> SineFit:
    freedom = step.samples - 4
    covariance = step.squares / freedom * step.inverse
    per_hz = 2.0 * math.pi * interval_s * step.middle
    return SineFit(
        frequency_hz=per_sample / (2.0 * math.pi * interval_s),
        sine=float(step.solution[0]),
        cosine=float(step.solution[1]),
        offset=float(step.solution[2]) + step.origin,
        covariance=fixed(covariance[:3, :3].copy()),
        residual_rms=math.sqrt(step.squares / step.samples),
        degrees_of_freedom=freedom,
        samples=step.samples,
        at_s=step.middle * interval_s,
        frequency_uncertainty_hz=math.sqrt(covariance[3, 3]) / per_hz,
    )


def _waves(per_sample: float, ticks: NDArray[np.number]) -> _Array:
    phase = per_sample * ticks
    return np.stack((np.sin(phase), np.cos(phase), np.ones_like(phase)))


def _inverse(normal: _Array) -> _Array:
    """Return the inverse of normal equations, scaled so that their units do not matter."""
    scale = np.sqrt(np.diag(normal))
    if not (scale > 0.0).all():
        raise InsufficientDataError("the record is constant: there is no sine in it")
    scaled = normal / np.outer(scale, scale)
    if np.linalg.cond(scaled) > _WORST_CONDITION:
        raise InsufficientDataError("the record is too short for a sine: it holds no period of it")
    inverse: _Array = np.linalg.inv(scaled) / np.outer(scale, scale)
    return inverse
