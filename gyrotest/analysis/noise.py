"""Noise identification: Q, N, B, K and R of a record, with uncertainties that hold.

The squared coefficients are fitted, none of them negative, to log-spaced overlapping Allan variances
by generalised least squares with the covariance that the model itself gives between averaging times,
and, for what is slower, to the likelihood of the record's slow modes. Spectral lines and a drift are
recognised and kept out. The fit begins at the shortest averaging time from which the model describes
the record, so that a sensor's filter does not pass for less noise.
"""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from gyrotest.analysis.allan import AllanDeviation, overlapping_allan_deviation
from gyrotest.analysis.allan_fit import AllanFit, allan_fit
from gyrotest.analysis.curve import GROUPS, checked_sample_rate, log_spaced_factors
from gyrotest.analysis.drift import Course, DriftSearch, courses, found_drift, search_drift
from gyrotest.analysis.goodness import goodness
from gyrotest.analysis.interval import chi_square_quantile
from gyrotest.analysis.kernels.record import difference_powers
from gyrotest.analysis.likelihood import TERMS, Likelihood, Solution
from gyrotest.analysis.minimum import AllanMinimum, allan_minimum
from gyrotest.analysis.noise_intervals import Profiles
from gyrotest.analysis.noise_model import (
    Drift,
    DriftKind,
    NoiseModel,
    NoiseTerm,
    SpectralLine,
    carried_range,
)
from gyrotest.analysis.noise_terms import Grid, allan_columns
from gyrotest.analysis.slow_lines import take_slow_lines
from gyrotest.analysis.slow_modes import TO_MODES, SlowModes, mode_count, slow_modes
from gyrotest.analysis.spectral_lines import Excess, lines_in, spectrum
from gyrotest.errors import InsufficientDataError

__all__ = [
    "SHORTEST_RECORD",
    "AllanMinimum",
    "Drift",
    "DriftKind",
    "NoiseModel",
    "NoiseTerm",
    "SpectralLine",
    "allan_minimum",
    "fitted_factors",
    "identify_noise",
    "spectral_lines",
]

SHORTEST_RECORD = 36
"""Samples below which no noise model is fitted."""

_FIRST_FACTORS = (1, 2, 3, 4, 6, 10)
_OCTAVES = (16, 25, 40)  # times 4^j: five a decade, all of them among the default factors
_STEP = 2
_FEWEST_MODES = 16
_MISFIT = 0.995
_ROUNDS = 4
_ROUNDS_ON = 2
_ALL = (0, 1, 2, 3)
_QUANTIZATION = 0
_AKAIKE = 2.0
_ROUNDING = 1e-10
_MOST_DIFFERENCES = 1 << 21
_NO_NOISE = (
    "no noise model describes the record: all that moves in it is a drift, a tone or a few samples,"
    " without noise; is this a gyro's output, and are all samples of it?"
)


def identify_noise(
    rate_dps: ArrayLike,
    *,
    sample_rate_hz: float,
    duty: float = 1.0,
    deviation: AllanDeviation | None = None,
    lines: tuple[Excess, ...] | None = None,
) -> NoiseModel:
    """Identify quantization noise, angle random walk, bias instability, rate random walk and rate ramp.

    Parameters
    ----------
    rate_dps
        Shape (n,): rate samples, evenly spaced, °/s.
    sample_rate_hz
        Samples a second.
    duty
        Share of each interval over which a sample is averaged, above 0 and at most 1.
    deviation
        The record's overlapping Allan deviation, where it is at hand already; one at the default
        averaging factors will do.
    lines
        The record's spectral lines, where they are at hand already (`spectral_lines`).

    Returns
    -------
    NoiseModel
        Its angle random walk is the apparent one where the duty is below 1.

    Raises
    ------
    InsufficientDataError
        Fewer than 36 samples, a sample that is not finite, a constant record, or one without noise
        (a ramp or a tone alone).
    ValueError
        A sample rate is not positive and finite, or a duty not above 0 and at most 1.

    Notes
    -----
    Terms and their spectra: IEEE 952 Annex C. Where the fit begins: `first_tau_s` of the model.
    """
    checked_sample_rate(sample_rate_hz)
    if not 0.0 < duty <= 1.0:
        raise ValueError(f"a duty is above 0 and at most 1, found {duty!r}")
    rate = np.asarray(rate_dps, dtype=np.float64)
    if rate.ndim != 1:
        raise ValueError(f"a rate record has one dimension, found {rate.ndim}")
    if rate.size < SHORTEST_RECORD:
        raise InsufficientDataError(
            f"the record has {rate.size} samples; a noise model needs at least {SHORTEST_RECORD}"
        )
    factors = fitted_factors(rate.size)
    if deviation is None or not np.isin(factors, deviation.averaging_factor).all():
        deviation = overlapping_allan_deviation(
            rate, sample_rate_hz=sample_rate_hz, averaging_factors=factors.tolist()
        )
    if lines is None:
        lines = spectral_lines(rate, sample_rate_hz=sample_rate_hz)
    grid = Grid(interval_s=1.0 / sample_rate_hz, aperture_s=duty / sample_rate_hz)
    fit = allan_fit(factors, deviation.at(factors).deviation_dps ** 2, rate.size, grid).less_lines(lines)
    fit = fit.with_tails(fourth_cumulant(rate))
    modes = slow_modes(rate, grid)
    record = _Record(fit=fit, modes=modes, candidates=courses(modes))
    try:
        with np.errstate(divide="raise", over="raise", invalid="raise"):
            return _identified(record, lines)
    except (FloatingPointError, np.linalg.LinAlgError) as error:
        raise InsufficientDataError(_NO_NOISE) from error


def spectral_lines(rate_dps: NDArray[np.float64], *, sample_rate_hz: float) -> tuple[Excess, ...]:
    """Find the spectral lines of a record (n,); none in one too short for a spectrum."""
    found = spectrum(rate_dps, sample_rate_hz=sample_rate_hz)
    return () if found is None else lines_in(found)


def fourth_cumulant(rate_dps: NDArray[np.float64]) -> float:
    """Return the fourth cumulant, (°/s)⁴, of the samples of a record (n,), which are taken for independent.

    By first differences d, which drift does not touch: (⟨d⁴⟩ − 3⟨d²⟩²)/2. Of a very long record some
    two million of them, evenly spread.
    """
    sums = np.empty(3)
    every = max(rate_dps.size // _MOST_DIFFERENCES, 1)
    difference_powers(np.ascontiguousarray(rate_dps), every, sums)
    second, fourth = sums[1:] / sums[0]
    return float(fourth - 3.0 * second**2) / 2.0


def fitted_factors(samples: int) -> NDArray[np.int64]:
    """Return the averaging factors of the fit: five a decade, as far as the slow modes do not speak."""
    longest = max(int(TO_MODES * samples / mode_count(samples)), 1)
    octaves = 4 ** np.arange(longest.bit_length(), dtype=np.int64)
    series = np.append(_FIRST_FACTORS, np.multiply.outer(octaves, _OCTAVES).ravel())
    return series[series <= longest]


@dataclass(frozen=True, slots=True, kw_only=True)
class _Record:
    """What is fitted, Allan variances and slow modes, and the drifts that are looked for.

    `filtered` says that short times contradict the longer ones, as a filter makes them.
    """

    fit: AllanFit
    modes: SlowModes
    candidates: tuple[Course, ...]
    filtered: bool = False

    def since(self, first: int) -> "_Record":
        """Leave out the shortest averaging times; after the last of them, an octave of modes each."""
        beyond = max(first - self.fit.factors.size, 0)
        count = self.modes.mode_dps.size >> beyond
        return _Record(
            fit=self.fit.since(first),
            modes=self.modes.slowest(count),
            candidates=tuple(one.slowest(count) for one in self.candidates),
        )

    @property
    def times(self) -> int:
        """How many averaging times and octaves of modes there are to leave out."""
        octaves = (self.modes.mode_dps.size // _FEWEST_MODES).bit_length() - 1
        return self.fit.factors.size + max(octaves, 0)

    @property
    def first_tau_s(self) -> float:
        """The averaging time at which the fit begins."""
        tau_s = self.fit.tau_s
        return float(tau_s[0]) if tau_s.size else self.modes.first_tau_s

    def share_at_first(self, search: DriftSearch) -> float:
        """Return a recognised drift's Allan variance where the fit begins; 0 of none."""
        if search.course is None:
            return 0.0
        tau = np.array([self.first_tau_s / self.modes.duration_s])
        return float(search.amplitude**2 * search.course.allan_variances(tau)[0])

    def less(self, search: DriftSearch) -> "_Record":
        """Take a recognised drift's share out of the Allan variances."""
        if search.course is None:
            return self
        tau = self.fit.tau_s / self.modes.duration_s
        share = search.amplitude**2 * search.course.allan_variances(tau)
        return replace(self, fit=self.fit.less(share))

    def without_slow_lines(self, search: DriftSearch) -> tuple["_Record", tuple[Excess, ...]]:
        """Take the slow lines out, beside a recognised drift, and return them too."""
        course = np.zeros(self.modes.mode_dps.size)
        if search.course is not None:
            course = search.amplitude * search.course.modes
        modes, lines = take_slow_lines(self.modes, course)
        return replace(self, modes=modes, fit=self.fit.less_lines(lines)), lines

    def solved(
        self, *, course: Course | None = None, start: NDArray[np.float64] | None = None
    ) -> Solution:
        """Fit the noise, and a drift's amplitude, with the covariance of the model that results."""
        squares, rounds = (self.fit.guess(), _ROUNDS) if start is None else (start, _ROUNDS_ON)
        for _ in range(rounds):
            likelihood = Likelihood(
                variances=self.fit.variances,
                columns=self.fit.columns,
                precision=self.fit.precision(squares),
                modes=self.modes.mode_dps,
                mode_variance=self.modes.variance,
                course=None if course is None else course.slowest(self.modes.mode_dps.size).modes,
                restricted=course is not None,
                filtered=self.filtered,
            )
            state = likelihood.minimise(squares, _ALL)
            squares = state.squares
        return Solution(likelihood=likelihood, state=state)

    def searched(self, solution: Solution) -> DriftSearch:
        """Look for a drift."""
        return search_drift(solution, self.modes, self.candidates)


def _identified(record: _Record, lines: tuple[Excess, ...]) -> NoiseModel:
    """Recognise a drift, find where the fit begins, and fit."""
    found = record.solved()
    search = record.searched(found)
    record, slow = record.without_slow_lines(search)
    if slow:
        lines = (*slow, *lines)
        found = record.solved()
        search = record.searched(found)
    first = _first_consistent(record.less(search), search.course, found)
    record = replace(record.since(first), filtered=first > 0)
    still = record.solved(start=found.state.squares)
    search = record.searched(still)
    final = still
    if search.course is not None:
        record = record.less(search)
        final = record.solved(course=search.course, start=still.state.squares)
    return _model(record, final, search, lines)


def _first_consistent(record: _Record, course: Course | None, found: Solution) -> int:
    """Leave out short averaging times while they contradict the longer ones.

    They do where chi-square falls by more than chance when half a decade, or a whole one, goes.
    """
    misfits: dict[int, float] = {}

    def misfit(first: int) -> float:
        if first not in misfits:
            kept = record.since(first)
            misfits[first] = goodness(kept.solved(course=course, start=found.state.squares)).chi_square
        return misfits[first]

    first = 0
    while any(
        first + reach <= record.times
        and misfit(first) - misfit(first + reach) > chi_square_quantile(_MISFIT, reach)
        for reach in (_STEP, 2 * _STEP)
    ):
        first += _STEP
    return first


def _parsimonious(solution: Solution) -> Solution:
    """Leave quantization noise out where it makes the record no likelier (Akaike's criterion).

    It is hardly ever there, and an idle term that cannot be negative would pull the angle random
    walk down.
    """
    if solution.likelihood.filtered:
        return solution
    fewer = solution.without(_QUANTIZATION)
    return fewer if fewer.state.deviance - solution.state.deviance < _AKAIKE else solution


def _model(
    record: _Record, solution: Solution, search: DriftSearch, lines: tuple[Excess, ...]
) -> NoiseModel:
    fits = goodness(solution)
    values = _parsimonious(solution)
    covariance = np.zeros((TERMS + 1, TERMS + 1))
    covariance[:TERMS, :TERMS] = solution.covariance() * fits.widening
    profiles = Profiles(
        solution=solution, values=values, widening=fits.widening, ambiguity=search.ambiguity
    )
    sigmas = np.sqrt(np.diag(covariance))
    duration_s = record.modes.duration_s
    bounds = [one.root() for one in profiles.coefficients(sigmas)]
    bounds.append(profiles.change(record.candidates[0], search.course).over(duration_s))
    squares = np.array([one.value**2 for one in bounds])
    factors = np.unique(
        np.append(record.fit.factors, log_spaced_factors(record.fit.samples // GROUPS, per_decade=10))
    )
    factors = factors[factors * record.fit.grid.interval_s >= record.first_tau_s * (1.0 - 1e-9)]
    parts = allan_columns(factors, record.fit.grid) * squares
    shares = parts / parts.sum(axis=1, keepdims=True)
    if parts[0, :TERMS].sum() <= _ROUNDING * record.share_at_first(search):
        raise InsufficientDataError(_NO_NOISE)
    tau_s = np.asarray(factors * record.fit.grid.interval_s, dtype=np.float64)
    terms = [
        one.term(carried_range(tau_s, np.asarray(shares[:, place]))) for place, one in enumerate(bounds)
    ]
    ramp = terms[TERMS]
    size = ramp.value if ramp.resolved else ramp.upper_95 / 2.0
    covariance[TERMS, TERMS] = (2.0 * size * ramp.standard_uncertainty) ** 2
    covariance.setflags(write=False)
    return NoiseModel(
        quantization_noise=terms[0],
        angle_random_walk=terms[1],
        bias_instability_coefficient=terms[2],
        rate_random_walk=terms[3],
        rate_ramp=ramp,
        covariance=covariance,
        lines=tuple(one.line for one in lines),
        drift=None if search.course is None else found_drift(search.course, values, duration_s),
        first_tau_s=record.first_tau_s,
        last_tau_s=duration_s / 2.0,
        misfit=fits.misfit,
        fit_probability=fits.probability,
        grid=record.fit.grid,
    )
