"""The course of an identification: lines and drift out, the fit begun where it holds, a model made."""

from dataclasses import replace

import numpy as np

from gyrotest.analysis.curve import GROUPS, log_spaced_factors
from gyrotest.analysis.drift import Course, DriftSearch, found_drift
from gyrotest.analysis.fitted_record import FittedRecord
from gyrotest.analysis.goodness import goodness
from gyrotest.analysis.interval import chi_square_quantile
from gyrotest.analysis.likelihood import TERMS, Solution
from gyrotest.analysis.noise_intervals import Profiles
from gyrotest.analysis.noise_model import NoiseModel, carried_range
from gyrotest.analysis.noise_terms import allan_columns
from gyrotest.analysis.spectral_lines import Excess
from gyrotest.errors import InsufficientDataError

NO_NOISE = (
    "no noise model describes the record: all that moves in it is a drift, a tone or a few samples,"
    " without noise; is this a gyro's output, and are all samples of it?"
)

_STEP = 2
_MISFIT = 0.995
_QUANTIZATION = 0
_AKAIKE = 2.0
_ROUNDING = 1e-10


def identified(record: FittedRecord, lines: tuple[Excess, ...]) -> NoiseModel:
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


def _first_consistent(record: FittedRecord, course: Course | None, found: Solution) -> int:
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
    record: FittedRecord, solution: Solution, search: DriftSearch, lines: tuple[Excess, ...]
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
        raise InsufficientDataError(NO_NOISE)
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
