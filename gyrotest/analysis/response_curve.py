"""A frequency response as a smooth curve over its band, and what is read off it."""

import math
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from gyrotest.analysis.band_polynomial import BandPolynomial, Estimates, fit_band_polynomial
from gyrotest.analysis.fixed import fixed
from gyrotest.analysis.frequency_response import Response
from gyrotest.errors import InsufficientDataError

_Array = NDArray[np.float64]

HALF_POWER = -0.5 * math.log(2.0)
"""A gain of 1/√2, −3.01 dB, as a logarithm."""

_FINEST = 1e-8
_COARSEST = 0.3
_MOST_NOISE = 4.0
_GRID = 2001


@dataclass(frozen=True, slots=True, kw_only=True)
class CurvePoints:
    """A curve at frequencies (n,), with standard uncertainties by its random error."""

    frequency_hz: _Array
    gain: _Array
    gain_uncertainty: _Array
    phase_deg: _Array
    phase_uncertainty_deg: _Array


@dataclass(frozen=True, slots=True, kw_only=True)
class Reading:
    """A value read off a curve, with its standard uncertainty by the random error and the fit.

    It moves by Σ `factors`·δ where the curve (ln gain, or phase in °) moves by δ at the frequencies `at_hz`.
    """

    value: float
    uncertainty: float
    at_hz: tuple[float, ...] = ()
    factors: tuple[float, ...] = ()


@dataclass(frozen=True, slots=True, kw_only=True)
class ResponseCurve:
    """Gain and phase over `low_hz` … `high_hz`, the first and the last line that was used.

    `log_gain` is the natural logarithm of the gain, `phase` in °, both over the frequency in Hz: each with
    its residual and its lack of fit. `lines` is what they were fitted to, the phase unwrapped; `excluded_hz`
    are lines of too little coherence.
    """

    log_gain: BandPolynomial
    phase: BandPolynomial
    lines: Response
    excluded_hz: _Array

    @property
    def low_hz(self) -> float:
        """Where the curve begins."""
        return self.log_gain.low

    @property
    def high_hz(self) -> float:
        """Where the curve ends."""
        return self.log_gain.high

    def at(self, frequency_hz: _Array) -> CurvePoints:
        """Evaluate at frequencies (n,) of the band.

        Raises
        ------
        InsufficientDataError
            A frequency more than one line outside: a curve is not extrapolated.
        """
        wanted = np.atleast_1d(np.asarray(frequency_hz, dtype=np.float64))
        self._require(wanted)
        rows = self.log_gain.rows(wanted)
        gain = np.exp(self.log_gain.value(wanted))
        return CurvePoints(
            frequency_hz=wanted,
            gain=gain,
            gain_uncertainty=gain * self.log_gain.uncertainty(rows),
            phase_deg=self.phase.value(wanted),
            phase_uncertainty_deg=self.phase.uncertainty(self.phase.rows(wanted)),
        )

    def _require(self, frequency_hz: _Array) -> None:
        line_hz = 1.0 / self.lines.segment_s
        outside = (frequency_hz < self.low_hz - line_hz) | (frequency_hz > self.high_hz + line_hz)
        if outside.any():
            raise InsufficientDataError(
                f"{frequency_hz[outside][0]:g} Hz lies outside of what was measured with enough coherence,"
                f" {self.low_hz:g} … {self.high_hz:g} Hz; choose a frequency inside, or excite the band wider"
            )


def fit_response(
    response: Response, *, degree: int, coherence_floor: float, phase_degree: int | None = None
) -> ResponseCurve:
    """Fit polynomials over the frequency to the logarithm of the gain, and to the phase.

    Parameters
    ----------
    response
        Of a run, or of several runs' spectra averaged.
    degree, phase_degree
        Of the polynomials; None: the phase has the gain's.
    coherence_floor
        Lines of a lower coherence are left out and listed; so are any whose random error exceeds 30 %, of
        which neither the logarithm nor the turn of the phase could be trusted.

    Raises
    ------
    InsufficientDataError
        Too few lines with as much coherence, for the degree.

    Notes
    -----
    S4.6, weighted by 1/ε². The logarithm is fitted, because the error of the gain is relative, and because
    noise makes the mean of gains too large (by ε²/2), but not that of their logarithms. The ε of a line is
    estimated from its own coherence, which is larger where noise has made its gain larger (smaller, if the
    noise is on the reference): so weighted, the mean would be wrong by 2ε², however many lines there are.
    The weights of the fit are those with the gain of a first fit, of as high a degree as is looked for a lack.
    """
    used = response.coherence >= coherence_floor
    used &= response.error <= _COARSEST
    if not used.any():
        raise _incoherent(response, coherence_floor)
    lines = _chosen(response, used)
    low, high = float(lines.frequency_hz[0]), float(lines.frequency_hz[-1])
    error = np.maximum(lines.error, _FINEST)  # a weight, where a simulation has no noise at all
    first = fit_band_polynomial(
        _estimates(lines, np.log(lines.gain), error, lines.common), low=low, high=high, degree=degree
    )
    smooth = first.value(lines.frequency_hz) + first.rows(lines.frequency_hz) @ first.lack
    by_noise = np.clip(np.log(lines.gain) - smooth, -_MOST_NOISE * error, _MOST_NOISE * error)
    error *= np.exp(lines.leaning * by_noise)
    gain = _estimates(lines, np.log(lines.gain), error, lines.common)
    none = np.zeros((error.size, 0))
    phase = _estimates(lines, lines.phase_deg, np.degrees(error), none)
    return ResponseCurve(
        log_gain=fit_band_polynomial(gain, low=low, high=high, degree=degree),
        phase=fit_band_polynomial(
            phase, low=low, high=high, degree=degree if phase_degree is None else phase_degree
        ),
        lines=lines,
        excluded_hz=fixed(response.frequency_hz[~used]),
    )


def bandwidth(curve: ResponseCurve, *, reference_hz: float) -> Reading | None:
    """Find the lowest frequency above a reference at which the gain is 1/√2 of that there, Hz.

    Returns
    -------
    None where the gain has not fallen so far at the end of the band: it is not extrapolated.

    Raises
    ------
    InsufficientDataError
        The reference lies outside of the band.
    """
    reference = np.array([reference_hz])
    curve.at(reference)
    level = float(curve.log_gain.value(reference)[0]) + HALF_POWER
    found = _crossing(curve.log_gain, level, begin=reference_hz)
    if found is None:
        return None
    return _at_crossing(curve.log_gain, found, counted_from=(reference_hz,))


def quarter_turn(curve: ResponseCurve) -> Reading | None:
    """Find the lowest frequency at which the phase has fallen to −90°, Hz.

    Returns
    -------
    None where it has not at the end of the band: it is not extrapolated.

    Raises
    ------
    InsufficientDataError
        The phase is lower than that where the band begins.
    """
    begin = float(curve.phase.value(np.array([curve.low_hz]))[0])
    if begin <= -90.0:
        raise InsufficientDataError(
            f"the phase is {begin:.1f}° where the band begins ({curve.low_hz:g} Hz), so that −90° lies below"
            " it; begin the band lower, or see whether the sign of the scale factor is right"
        )
    found = _crossing(curve.phase, -90.0, begin=curve.low_hz)
    if found is None:
        return None
    return _at_crossing(curve.phase, found)


def group_delay(curve: ResponseCurve, *, frequency_hz: float) -> Reading:
    """Return −dφ/dω = −(dφ/df)/360° at a frequency of the band, s; raises as `ResponseCurve.at` does."""
    where = np.array([frequency_hz])
    curve.at(where)
    rows = curve.phase.rows(where, derivative=1)
    slope = float(curve.phase.value(where, derivative=1)[0])
    return Reading(value=-slope / 360.0, uncertainty=float(curve.phase.uncertainty(rows)[0]) / 360.0)


def flatness(curve: ResponseCurve, *, reference_hz: float, to_hz: float | None = None) -> Reading:
    """Return the highest less the lowest gain over the band, in % of that at a reference frequency.

    Up to `to_hz` where it is given, else up to the end of the band. Noise makes it larger, never smaller: a
    curve that is flat to within its uncertainty is not seen to be.

    Raises
    ------
    InsufficientDataError
        The reference, or the end, lies outside of the band.
    """
    reference = np.array([reference_hz])
    end_hz = curve.high_hz if to_hz is None else to_hz
    curve.at(np.array([reference_hz, end_hz]))
    grid = np.linspace(curve.low_hz, min(end_hz, curve.high_hz), _GRID)
    relative = np.exp(curve.log_gain.value(grid) - curve.log_gain.value(reference))
    ends = np.array([np.argmax(relative), np.argmin(relative)])
    high, low = relative[ends]
    at_hz = np.append(grid[ends], reference_hz)
    return _read(
        curve.log_gain, 100.0 * float(high - low), at_hz, 100.0 * np.array([high, -low, low - high])
    )


def _crossing(polynomial: BandPolynomial, level: float, *, begin: float) -> float | None:
    """Return where a polynomial first falls through a level; None up to the end of the band."""
    from scipy.optimize import brentq

    def above(x: float) -> float:
        return float(polynomial.value(np.array([x]))[0]) - level

    grid = np.linspace(begin, polynomial.high, _GRID)
    beneath = np.flatnonzero(polynomial.value(grid) <= level)
    if not beneath.size or beneath[0] == 0:
        return None
    return float(brentq(above, grid[beneath[0] - 1], grid[beneath[0]]))


def _at_crossing(
    polynomial: BandPolynomial, found: float, *, counted_from: tuple[float, ...] = ()
) -> Reading:
    slope = float(polynomial.value(np.array([found]), derivative=1)[0])
    at_hz = np.array([found, *counted_from])
    return _read(polynomial, found, at_hz, np.array([-1.0, *(1.0 for _ in counted_from)]) / slope)


def _read(polynomial: BandPolynomial, value: float, at_hz: _Array, factors: _Array) -> Reading:
    change = factors @ polynomial.rows(at_hz)
    return Reading(
        value=value,
        uncertainty=float(polynomial.uncertainty(change[np.newaxis])[0]),
        at_hz=tuple(float(one) for one in at_hz),
        factors=tuple(float(one) for one in factors),
    )


def _chosen(response: Response, used: NDArray[np.bool_]) -> Response:
    """Return some of the lines, their phase unwrapped from the first of them on."""
    return replace(
        response,
        frequency_hz=fixed(response.frequency_hz[used]),
        gain=fixed(response.gain[used]),
        phase_deg=fixed(np.unwrap(response.phase_deg[used], period=360.0)),
        coherence=fixed(response.coherence[used]),
        error=fixed(response.error[used]),
        common=fixed(response.common[used]),
        leaning=fixed(response.leaning[used]),
    )


def _estimates(lines: Response, values: _Array, error: _Array, common: _Array) -> Estimates:
    return Estimates(
        x=lines.frequency_hz,
        y=values,
        error=error,
        line=np.rint(lines.frequency_hz * lines.segment_s).astype(np.int64),
        correlation=lines.correlation,
        averages=lines.averages,
        common=common,
    )


def _incoherent(response: Response, floor: float) -> InsufficientDataError:
    best = int(np.argmax(response.coherence))
    small = response.coherence[best] < floor
    said = f"coherence is below {floor:g}" if small else f"random error is above {100.0 * _COARSEST:g} %"
    return InsufficientDataError(
        f"the {said} over the whole band; the coherence is {response.coherence[best]:.3f} at best, at"
        f" {response.frequency_hz[best]:g} Hz, of {response.averages:.0f} averages: vibrate harder or longer,"
        " see that the unit and the encoder sit on the same table and are sampled together, or lower the floor"
    )
