"""How well a frequency response repeats: three standard deviations over runs, and its largest in the band."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gyrotest.analysis.fixed import fixed
from gyrotest.analysis.interval import chi_square_quantile
from gyrotest.analysis.response_curve import ResponseCurve
from gyrotest.errors import InsufficientDataError

_Array = NDArray[np.float64]
_POINTS = 201
_TAIL = 0.025


@dataclass(frozen=True, slots=True, kw_only=True)
class Largest:
    """The largest 3σ in the band and where, the 95 % interval of what underlies it, and what noise gives.

    `noise` is 3σ there by the random error of the curves alone, which the value contains.
    """

    value: float
    at_hz: float
    lower_95: float
    upper_95: float
    noise: float


@dataclass(frozen=True, slots=True, kw_only=True)
class ResponseRepeatability:
    """3σ of `runs` runs at frequencies (n,): of the gain in % of their mean, of the phase in °."""

    runs: int
    frequency_hz: _Array
    amplitude_percent: _Array
    phase_deg: _Array
    amplitude: Largest
    phase: Largest


def response_repeatability(
    runs: Sequence[ResponseCurve], *, frequency_hz: _Array | None = None
) -> ResponseRepeatability:
    """Compare the fitted curves of runs: their sample standard deviation (n − 1) at each frequency, times 3.

    Parameters
    ----------
    runs
        Two or more.
    frequency_hz
        Where, shape (n,); None: 201 frequencies evenly over the band that all runs have in common.

    Raises
    ------
    InsufficientDataError
        Fewer than two runs, runs without a common band, or a frequency outside of one's band.

    Notes
    -----
    S4.6. The largest of many standard deviations of a few runs is no standard deviation of a few runs, and
    a curve of p coefficients has about p independent frequencies. The interval holds the largest underlying
    3σ, however the spread is distributed over the band: the lower end is the smallest σ of which the largest
    of p independent estimates reaches what was found with 2.5 %; the upper end the largest σ of which a
    single estimate, that at the worst frequency, stays below it with 2.5 %. As in other repeatabilities the
    curves' own noise is not taken from the value, but from the lower end.
    """
    if len(runs) < 2:
        raise InsufficientDataError(f"{len(runs)} run has no spread; 2 are needed")
    where = _common_band(runs) if frequency_hz is None else np.asarray(frequency_hz, dtype=np.float64)
    points = [one.at(where) for one in runs]
    gain = np.array([one.gain for one in points])
    phase = _on_one_branch(np.array([one.phase_deg for one in points]))
    amplitude = 300.0 * gain.std(axis=0, ddof=1) / gain.mean(axis=0)
    angle = 3.0 * phase.std(axis=0, ddof=1)
    noise = [300.0 * one.log_gain.random(one.log_gain.rows(where)) for one in runs]
    phase_noise = [3.0 * one.phase.random(one.phase.rows(where)) for one in runs]
    return ResponseRepeatability(
        runs=len(runs),
        frequency_hz=fixed(where),
        amplitude_percent=fixed(amplitude),
        phase_deg=fixed(angle),
        amplitude=_largest(where, amplitude, noise, runs[0].log_gain.coefficients.size),
        phase=_largest(where, angle, phase_noise, runs[0].phase.coefficients.size),
    )


def _largest(where: _Array, spread: _Array, noise: Sequence[_Array], independent: int) -> Largest:
    worst = int(np.argmax(spread))
    value, freedom = float(spread[worst]), len(noise) - 1
    by_noise = float(np.sqrt(np.mean([one[worst] ** 2 for one in noise])))
    highest = chi_square_quantile((1.0 - _TAIL) ** (1.0 / independent), freedom)
    lower = value * float(np.sqrt(freedom / highest))
    return Largest(
        value=value,
        at_hz=float(where[worst]),
        lower_95=float(np.sqrt(max(lower**2 - by_noise**2, 0.0))),
        upper_95=value * float(np.sqrt(freedom / chi_square_quantile(_TAIL, freedom))),
        noise=by_noise,
    )


def _common_band(runs: Sequence[ResponseCurve]) -> _Array:
    low, high = max(one.low_hz for one in runs), min(one.high_hz for one in runs)
    if low >= high:
        raise InsufficientDataError(
            "the runs have no band with enough coherence in common; see which of them was not excited"
        )
    return np.linspace(low, high, _POINTS)


def _on_one_branch(phase_deg: _Array) -> _Array:
    """Return phases (runs, n) less the whole turns by which a run differs from the first one."""
    middle = phase_deg.shape[1] // 2
    turns = np.rint((phase_deg[:, middle] - phase_deg[0, middle]) / 360.0)
    found: _Array = phase_deg - 360.0 * turns[:, np.newaxis]
    return found
