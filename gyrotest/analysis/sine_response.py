"""The response of a gyro's output to the rate of a table that moves as a sine, steady or swept."""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gyrotest.analysis.sine_envelope import Envelope, fit_envelope
from gyrotest.analysis.sine_fit import four_parameter_fit, spectral_peak_hz
from gyrotest.errors import InsufficientDataError

_Array = NDArray[np.float64]

FEWEST_PERIODS = 10
"""Whole periods that a response is taken over."""

SWEPT_SHARE = 0.1
"""By how much of itself the frequency changes in the window in which a sweep is evaluated."""

_LEAST_OVER_NOISE = 10.0
_WAVES = 2.0 * math.pi
_SIDEBANDS = 8
_STEADY_ORDER, _SWEPT_ORDER = 0, 2
_DRIFT = 2
_CENTRE_VARIANCE = {_STEADY_ORDER: 1.0, _SWEPT_ORDER: 9.0 / 4.0}
"""Variance of a polynomial in the middle of what it is fitted to, over that of a mean."""

_MOST_ROUNDS = 8
_MOST_MISFIT = 0.05
_FARTHEST = 0.3
_NEAR = 1.25
_TUNED = 1e-3
_MOST_OFF = 0.01


@dataclass(frozen=True, slots=True, kw_only=True)
class SineResponse:
    """Output over rate at a frequency: `ratio` in the output's unit per °/s, a lag negative in its angle.

    `relative_uncertainty` is the standard uncertainty of its size over that, and of its angle in radians, by
    the noise beside the frequency, with its degrees of freedom. `rate_dps` and `output` are amplitudes
    (peaks), the residuals root mean squares of what the sine leaves of the angle (in °) and of the output.
    """

    frequency_hz: float
    ratio: complex
    relative_uncertainty: float
    degrees_of_freedom: float
    rate_dps: float
    output: float
    angle_residual_deg: float
    output_residual: float
    samples: int
    periods: int

    @property
    def gain(self) -> float:
        """Amplitude of the output over that of the rate."""
        return abs(self.ratio)

    @property
    def phase_deg(self) -> float:
        """Phase of the output less that of the rate, −180° … 180°."""
        return math.degrees(math.atan2(self.ratio.imag, self.ratio.real))


def steady_response(
    angle_deg: _Array, output: _Array, *, interval_s: float, frequency_hz: float
) -> SineResponse:
    """Return the response to a steady sine, over as many whole periods as there are.

    Parameters
    ----------
    angle_deg, output
        Shape (n,): the table's angle, °, and the gyro's output, any unit, sampled at the same instants.
    interval_s
        Time between two samples, s.
    frequency_hz
        What the table was asked for; the frequency is fitted to the angle (IEEE 1057, four parameters, then
        once more beside the drift) and imposed on the output.

    Raises
    ------
    InsufficientDataError
        Fewer than ten periods, no sine in the angle, or its amplitude is less than ten times its noise.

    Notes
    -----
    S4.7. The rate of A·exp jωt is jω·A. The noise is not taken for white: it is what lies within eight
    lines (of the record's resolution) on either side of the frequency, output less response times rate,
    so that motion of the table beside its sine is none. Beside the sine not a constant is fitted but a
    parabola: a table that creeps must not leak into it.
    """
    peak_hz = spectral_peak_hz(
        angle_deg, interval_s, low_hz=frequency_hz / _NEAR, high_hz=frequency_hz * _NEAR
    )
    found = four_parameter_fit(angle_deg, interval_s=interval_s, frequency_hz=peak_hz)
    periods = math.floor(angle_deg.size * interval_s * found.frequency_hz + 1e-6)
    if periods < FEWEST_PERIODS:
        raise InsufficientDataError(
            f"{periods} whole periods of {found.frequency_hz:.5g} Hz are too few; {FEWEST_PERIODS} are needed"
        )
    _refuse_other(found.frequency_hz, frequency_hz)
    samples = min(round(periods / (found.frequency_hz * interval_s)), angle_deg.size)
    at_hz = _tuned_hz(angle_deg[:samples], found.frequency_hz, interval_s)
    wave = _steady_wave(at_hz, samples, interval_s)
    window = _Window(
        angle=fit_envelope(angle_deg[:samples], wave, order=_STEADY_ORDER, drift=_DRIFT),
        output=fit_envelope(output[:samples], wave, order=_STEADY_ORDER, drift=_DRIFT),
        wave=wave,
        frequency_hz=at_hz,
        length_s=samples * interval_s,
        periods=periods,
    )
    return _response(window)


def swept_response(
    angle_deg: _Array,
    output: _Array,
    *,
    interval_s: float,
    frequency_hz: float,
    low_hz: float,
    growth_per_s: float,
) -> SineResponse:
    """Return the response at a frequency that a logarithmic sweep passes.

    Parameters
    ----------
    angle_deg, output
        Shape (n,): the table's angle, °, and the gyro's output, any unit, from the sweep's begin (about).
    interval_s
        Time between two samples, s.
    frequency_hz
        Where the response is wanted.
    low_hz, growth_per_s
        The sweep's law: frequency `low_hz·exp(growth_per_s·t)`.

    Raises
    ------
    InsufficientDataError
        Fewer than ten periods in the window, the window reaches beyond the record, the angle does not follow
        the sweep, or its amplitude is less than ten times its noise.

    Notes
    -----
    In a window in which the frequency changes by 10 % both channels are fitted by the sweep's own wave with
    an envelope that is quadratic in time. The rate's is E' + jωE of the angle's envelope E, all at the
    window's middle, where E also tells the frequency. The window is moved until that is the one wanted.
    """
    length = round(SWEPT_SHARE / growth_per_s / interval_s)
    periods = math.floor(length * interval_s * frequency_hz)
    if periods < FEWEST_PERIODS:
        raise InsufficientDataError(
            f"the sweep passes {frequency_hz:.5g} Hz too fast: {periods} periods while the frequency changes by"
            f" {SWEPT_SHARE:.0%}; {FEWEST_PERIODS} are needed"
        )
    middle = math.log(frequency_hz / low_hz) / growth_per_s / interval_s
    for _ in range(_MOST_ROUNDS):
        window = _swept_window(
            angle_deg,
            output,
            begin=round(middle - length / 2.0),
            length=length,
            interval_s=interval_s,
            frequency_hz=frequency_hz,
            growth_per_s=growth_per_s,
        )
        shift = math.log(frequency_hz / window.at_hz) / growth_per_s / interval_s
        if abs(shift) < 1.0:
            return _response(window)
        middle += shift
    raise InsufficientDataError(f"the sweep is not found to pass {frequency_hz:.5g} Hz")


@dataclass(frozen=True, slots=True, kw_only=True)
class _Window:
    """Envelopes of both channels on a wave of `frequency_hz` in the middle."""

    angle: Envelope
    output: Envelope
    wave: NDArray[np.complex128]
    frequency_hz: float
    length_s: float
    periods: int

    @property
    def rate(self) -> complex:
        """The rate's phasor in the middle, °/s: the derivative of the angle's wave."""
        omega = _WAVES * self.frequency_hz
        return self.angle.slope * 2.0 / self.length_s + 1j * omega * self.angle.middle

    @property
    def at_hz(self) -> float:
        """The frequency in the middle: the wave's, and what the angle's envelope turns beside."""
        turning = (self.angle.slope / self.angle.middle).imag * 2.0 / self.length_s
        return self.frequency_hz + turning / _WAVES


def _response(window: _Window) -> SineResponse:
    angle, output, rate = window.angle, window.output, window.rate
    ratio = output.middle / rate
    lines = _lines(window)
    # what moves beside the sine is motion: its rate times the response belongs to the output
    rates = 1j * _WAVES * (window.at_hz + lines / window.length_s) * angle.sidebands(window.wave, lines)
    noise = output.sidebands(window.wave, lines) - ratio * rates
    own = angle.sidebands(window.wave, lines)
    if abs(angle.middle) < _LEAST_OVER_NOISE * math.sqrt(float(np.mean(np.abs(own) ** 2))):
        raise InsufficientDataError(
            f"the table's angle at {window.at_hz:.5g} Hz has an amplitude of {abs(angle.middle):.3g}°, which its"
            f" noise beside that frequency does not let tell; raise the level"
        )
    variance = _CENTRE_VARIANCE[angle.order] * float(np.mean(np.abs(noise) ** 2))
    return SineResponse(
        frequency_hz=window.at_hz,
        ratio=complex(ratio),
        relative_uncertainty=math.sqrt(variance / 2.0) / abs(output.middle)
        if output.middle
        else math.inf,
        degrees_of_freedom=2.0 * lines.size,
        rate_dps=abs(rate),
        output=abs(output.middle),
        angle_residual_deg=angle.residual_rms,
        output_residual=output.residual_rms,
        samples=window.wave.size,
        periods=window.periods,
    )


def _lines(window: _Window) -> NDArray[np.int64]:
    """Return the sidebands, as multiples of the resolution: those that the envelope does not take up."""
    first = 1 + window.angle.order
    count = min(_SIDEBANDS, max(window.periods // 2 - first + 1, 2))
    beside = np.arange(first, first + count)
    return np.concatenate((-beside[::-1], beside))


def _steady_wave(frequency_hz: float, samples: int, interval_s: float) -> NDArray[np.complex128]:
    ticks = np.arange(samples) - (samples - 1) / 2.0
    wave: NDArray[np.complex128] = np.exp(1j * _WAVES * frequency_hz * interval_s * ticks)
    return wave


def _tuned_hz(angle_deg: _Array, frequency_hz: float, interval_s: float) -> float:
    """Return the frequency at which the angle's phase does not turn, beside whatever drifts."""
    wave = _steady_wave(frequency_hz, angle_deg.size, interval_s)
    envelope = fit_envelope(angle_deg, wave, order=1, drift=_DRIFT)
    turning = (envelope.slope / envelope.middle).imag * 2.0 / (angle_deg.size * interval_s)
    return frequency_hz + turning / _WAVES


def _swept_window(
    angle_deg: _Array,
    output: _Array,
    *,
    begin: int,
    length: int,
    interval_s: float,
    frequency_hz: float,
    growth_per_s: float,
) -> _Window:
    """Return the window that begins at a sample, its wave tuned to the angle's."""
    if begin < 0 or begin + length > angle_deg.size:
        raise InsufficientDataError(
            f"the sweep does not hold {frequency_hz:.5g} Hz and what is needed on either side; let it begin lower,"
            " or end higher"
        )
    chosen = slice(begin, begin + length)
    ticks_s = (np.arange(length) - (length - 1) / 2.0) * interval_s
    turned_s = np.expm1(growth_per_s * ticks_s) / growth_per_s
    wave_hz = frequency_hz + _detuning_hz(angle_deg[chosen], turned_s, frequency_hz, interval_s)
    for _ in range(_MOST_ROUNDS):
        wave = np.exp(1j * _WAVES * wave_hz * turned_s)
        window = _Window(
            angle=fit_envelope(angle_deg[chosen], wave, order=_SWEPT_ORDER, drift=_DRIFT),
            output=fit_envelope(output[chosen], wave, order=_SWEPT_ORDER, drift=_DRIFT),
            wave=wave,
            frequency_hz=wave_hz,
            length_s=length * interval_s,
            periods=math.floor(length * interval_s * frequency_hz),
        )
        if abs(window.at_hz - wave_hz) * window.length_s < _TUNED:
            break
        wave_hz = window.at_hz
    amplitude = abs(window.angle.middle)
    if window.angle.residual_rms * math.sqrt(2.0) > _MOST_MISFIT * amplitude:
        raise InsufficientDataError(
            f"the table's angle does not follow the sweep about {frequency_hz:.5g} Hz: it leaves"
            f" {window.angle.residual_rms:.3g}° of an amplitude of {amplitude:.3g}°"
        )
    return window


def _detuning_hz(angle_deg: _Array, turned_s: _Array, frequency_hz: float, interval_s: float) -> float:
    """Return by how much the sweep's wave is off in the window, by the spectrum of the angle beside it."""
    wave = np.exp(-1j * _WAVES * frequency_hz * turned_s)
    beside = (angle_deg - angle_deg.mean()) * wave * np.hanning(angle_deg.size)
    size = 4 * angle_deg.size
    spectrum = np.abs(np.fft.fft(beside, size))
    offsets_hz = np.fft.fftfreq(size, interval_s)
    spectrum[np.abs(offsets_hz) > _FARTHEST * frequency_hz] = 0.0
    return float(offsets_hz[np.argmax(spectrum)])


def _refuse_other(found_hz: float, asked_hz: float) -> None:
    if abs(found_hz - asked_hz) > _MOST_OFF * asked_hz:
        raise InsufficientDataError(
            f"the table moves at {found_hz:.6g} Hz, and was asked for {asked_hz:.6g} Hz; look at its drive"
        )
