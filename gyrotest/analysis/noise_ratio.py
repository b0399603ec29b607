"""The ratio of the gyro's noise to the reference's, as the Hv estimator needs it, from a record at rest."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gyrotest.analysis.band_polynomial import BandPolynomial, Estimates, fit_band_polynomial
from gyrotest.analysis.cross_spectra import Spectra
from gyrotest.errors import InsufficientDataError

_Array = NDArray[np.float64]
_DEGREE = 3
_EDGE = 1e-9


@dataclass(frozen=True, slots=True, kw_only=True)
class NoiseRatio:
    """κ = G_dd/G_cc: noise of the output to noise of the rate, in the square of the output's unit a °/s.

    Either a `curve`, ln κ over ln f, or one `value` at all frequencies that is known. `coherence` is that of
    the record at rest: what both channels see there is no noise but motion, which draws κ towards the square
    of the gain (None: not known).
    """

    curve: BandPolynomial | None = None
    value: float = 1.0
    coherence: float | None = None

    def at(self, frequency_hz: _Array) -> _Array:
        """Return κ at frequencies (k,) of the band; inf where the reference, 0 where the output has no noise.

        Raises
        ------
        InsufficientDataError
            A frequency outside of the band of the record at rest.
        """
        if self.curve is None:
            return np.full(np.shape(frequency_hz), self.value)
        place = np.log(frequency_hz)
        if place.min() < self.curve.low - _EDGE or place.max() > self.curve.high + _EDGE:
            raise InsufficientDataError(
                f"noise at rest is known for {np.exp(self.curve.low):g} … {np.exp(self.curve.high):g} Hz, and"
                f" asked for at {np.min(frequency_hz):g} … {np.max(frequency_hz):g} Hz; take both spectra with"
                " the same segments and band"
            )
        found: _Array = np.exp(self.curve.value(place))
        return found

    def deviations(self, frequency_hz: _Array) -> _Array:
        """Return what moves ln κ (k, q): q independent standard deviations, each common to all frequencies."""
        if self.curve is None:
            return np.zeros((np.size(frequency_hz), 0))
        return self.curve.deviations(self.curve.rows(np.log(frequency_hz)))


def known_ratio(value: float) -> NoiseRatio:
    """Return a noise ratio that is the same at all frequencies and known; 1 for two equal channels.

    Raises
    ------
    ValueError
        A ratio below 0, or that is no number.
    """
    if not value >= 0.0:
        raise ValueError(f"a noise ratio is 0 or more, found {value!r}")
    return NoiseRatio(value=value)


def noise_ratio(rest: Spectra, *, degree: int = _DEGREE) -> NoiseRatio:
    """Find κ in the spectra of a record at rest, smooth over the band.

    Parameters
    ----------
    rest
        Spectra with the lines of those that κ is used for; a single segment is enough.
    degree
        Of the polynomial; the default holds a gyro that rolls off beside an encoder whose noise is an angle.

    Raises
    ------
    InsufficientDataError
        Neither channel has any noise.

    Notes
    -----
    A short record gives each line few averages: the ratio of two of them scatters by √(2/L). So ln κ is
    fitted by a polynomial in ln f through all lines, where white noise of an encoder's angle, which grows as
    f² as a rate, is a straight line. ln(G_dd/G_cc) is fitted because the logarithms of two averages of L have
    the same bias, which so falls out; its variance is 2ψ′(L). Single lines of interference weigh little.
    """
    if not rest.reference.any() or not rest.output.any():
        return _one_sided(rest)
    from scipy.special import polygamma

    frequency = np.log(rest.frequency_hz)
    line = np.rint(rest.frequency_hz * rest.segment_s).astype(np.int64)
    spread = float(np.sqrt(2.0 * polygamma(1, rest.averages)))
    estimates = Estimates(
        x=frequency,
        y=np.log(rest.output / rest.reference),
        error=np.full(frequency.size, spread),
        line=line,
        correlation=rest.correlation,
        averages=np.inf,
        common=np.zeros((frequency.size, 0)),
    )
    curve = fit_band_polynomial(
        estimates, low=float(frequency[0]), high=float(frequency[-1]), degree=degree
    )
    return NoiseRatio(curve=curve, coherence=_common(rest))


def _one_sided(rest: Spectra) -> NoiseRatio:
    if not rest.reference.any() and not rest.output.any():
        raise InsufficientDataError(
            "both channels stand still at rest, without any noise: the ratio of their noises cannot be found;"
            " see that both are connected, and that their resolution is finer than their noise"
        )
    return NoiseRatio(value=np.inf if rest.output.any() else 0.0)


def _common(rest: Spectra) -> float | None:
    """Return the mean coherence, less the 1/L that noise alone gives; None of a single average."""
    if rest.averages < 2.0:
        return None
    found = np.abs(rest.cross) ** 2 / (rest.reference * rest.output)
    chance = 1.0 / rest.averages
    return max(float((found.mean() - chance) / (1.0 - chance)), 0.0)
