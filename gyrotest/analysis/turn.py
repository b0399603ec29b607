"""A turn between two rests: where it is, and what the output integrates to over it."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gyrotest.analysis.correlation import correlation_time
from gyrotest.errors import InsufficientDataError

FEWEST_AT_REST = 16
_SMOOTHED = 200
_MOVES_SIGMAS = 6.0
_MOVES_OF_PEAK = 0.01
_KEPT_OF_REST = 0.8
_PASSES = 4
_DRIFTS_SIGMAS = 3.0


@dataclass(frozen=True, slots=True, kw_only=True)
class Parts:
    """A record `[0, size)` is at rest in `[0, begin)` and `[end, size)` and turns between."""

    begin: int
    end: int


@dataclass(frozen=True, slots=True, kw_only=True)
class Rest:
    """The mean output of a part at rest, its standard uncertainty, and where its middle is on the grid."""

    mean: float
    uncertainty: float
    degrees_of_freedom: float
    middle: float
    noise: float
    """Standard deviation of a sum of samples over the square root of their number."""


@dataclass(frozen=True, slots=True, kw_only=True)
class TurnIntegral:
    """∫(U − U0)dt over the turn, in the output's unit times s, and what it is uncertain by.

    `noise` comes from the samples of the turn, `rest` from the means at rest, each with its degrees of
    freedom; `drift` is a half-width: how far the output at rest may have strayed from a straight line,
    None where the two rests agree within their noise. `difference` is the rest after less that before,
    None where there is only one. `rest_level` is the output at rest in the middle of the turn and
    `lasts_s` the turn's length.
    """

    integral: float
    noise: float
    noise_freedom: float
    rest: float
    rest_freedom: float
    drift: float | None
    difference: float | None
    rest_level: float
    rest_level_uncertainty: float
    lasts_s: float


def find_rests(values: NDArray[np.float64]) -> Parts:
    """Find the parts at rest at both ends of a record in which a gyro is turned.

    Parameters
    ----------
    values
        Shape (n,): the output, any unit.

    Raises
    ------
    InsufficientDataError
        Neither end is at rest, or nothing turns.

    Notes
    -----
    Moving means of 1/200 of the record are compared with the output at each end: at rest they differ from
    it by less than 1 % of the turn's peak, or than six standard deviations of the mean where that is more
    (by the median absolute difference of neighbours, which the turn hardly touches). The output at an end
    is the median of what is at rest there, and is found anew four times. Of each rest the fifth next to the
    turn is counted to the turn, so that its slow begin and end are in the integral.
    """
    if values.size < 4 * FEWEST_AT_REST:
        raise InsufficientDataError(
            f"{values.size} samples are too few for a turn between two rests; {4 * FEWEST_AT_REST} are needed"
        )
    width = max(values.size // _SMOOTHED, 1)
    smooth = np.convolve(values, np.full(width, 1.0 / width), mode="valid")
    noise = 1.4826 * float(np.median(np.abs(np.diff(values)))) / np.sqrt(2.0 * width)
    before = after = max(smooth.size // 50, 1)
    for _ in range(_PASSES):
        levels = float(np.median(smooth[:before])), float(np.median(smooth[-after:]))
        middle = sum(levels) / 2.0
        moves = max(_MOVES_OF_PEAK * float(np.abs(smooth - middle).max()), _MOVES_SIGMAS * noise)
        before = _still(np.abs(smooth - levels[0]), moves)
        after = _still(np.abs(smooth[::-1] - levels[1]), moves)
        if before == smooth.size:
            raise InsufficientDataError("nothing turns: the whole record is at rest")
        before, after = max(before, 1), max(after, 1)
    begin, end = int(_KEPT_OF_REST * before), values.size - int(_KEPT_OF_REST * after)
    return _usable(begin if begin >= FEWEST_AT_REST else 0, end, values.size)


def _still(away: NDArray[np.float64], moves: float) -> int:
    """Return how many values from the begin on stay below a threshold."""
    beyond = np.flatnonzero(away > moves)
    return int(beyond[0]) if beyond.size else away.size


def _usable(begin: int, end: int, size: int) -> Parts:
    end = end if size - end >= FEWEST_AT_REST else size
    if begin == 0 and end == size:
        raise InsufficientDataError(
            f"neither end of the record is at rest for {FEWEST_AT_REST} samples; say with 'rest_before' and"
            " 'rest_after' how long it is, or record longer"
        )
    return Parts(begin=begin, end=end)


def turn_integral(
    values: NDArray[np.float64], place: NDArray[np.int64], parts: Parts, *, interval_s: float
) -> TurnIntegral:
    """Integrate the output over a turn, less the output at rest.

    Parameters
    ----------
    values, place
        Shape (n,): outputs and their places on the grid. Gaps may be in the rests, none in the turn.
    parts
        What is at rest; of at least one end so many samples as a mean needs.
    interval_s
        Time between two places.

    Raises
    ------
    InsufficientDataError
        Samples of the turn are missing; a rest of too few samples, or none at all.

    Notes
    -----
    ∫(U − U0)dt = Σ(U_k − U0(t_k))·τ0, with U0 interpolated between the middles of the two rests, or that
    of the only one. The mean of a rest and the sum over the turn are as uncertain as the rests' samples
    scatter, their correlation counted: s·√(τ/n) and s·√(τ·n).
    """
    turn = slice(parts.begin, parts.end)
    places = place[turn]
    if places.size < 2:
        raise InsufficientDataError("no sample is left for the turn between the rests")
    lacking = int(places[-1] - places[0]) + 1 - places.size
    if lacking:
        raise InsufficientDataError(
            f"{lacking} samples of the turn are missing, and an angle cannot be had without them"
        )
    rests = [
        _rest(values[part], place[part])
        for part in (slice(0, parts.begin), slice(parts.end, None))
        if values[part].size
    ]
    if not rests:
        raise InsufficientDataError("there is no rest before the turn, and none after it")
    weights = _weights(rests, float(places.mean()))
    level = sum(weight * one.mean for weight, one in zip(weights, rests, strict=True))
    variances = [(weight * one.uncertainty) ** 2 for weight, one in zip(weights, rests, strict=True)]
    level_uncertainty = float(np.sqrt(sum(variances)))
    lasts_s = places.size * interval_s
    # Of the samples in the turn no other noise is known than that of the rests.
    noise = float(np.sqrt(np.mean([one.noise**2 for one in rests]) * places.size)) * interval_s
    difference = rests[-1].mean - rests[0].mean if len(rests) > 1 else None
    return TurnIntegral(
        integral=float((values[turn] - level).sum()) * interval_s,
        noise=noise,
        noise_freedom=sum(one.degrees_of_freedom for one in rests),
        rest=level_uncertainty * lasts_s,
        rest_freedom=_combined_freedom(variances, rests),
        drift=_drift(rests, difference, lasts_s),
        difference=difference,
        rest_level=level,
        rest_level_uncertainty=level_uncertainty,
        lasts_s=lasts_s,
    )


def _rest(values: NDArray[np.float64], place: NDArray[np.int64]) -> Rest:
    if values.size < FEWEST_AT_REST:
        raise InsufficientDataError(
            f"{values.size} samples at rest are too few for a mean; {FEWEST_AT_REST} are needed"
        )
    lasting = min(correlation_time(values), values.size / 3.0)
    deviation = float(values.std(ddof=1))
    return Rest(
        mean=float(values.mean()),
        uncertainty=deviation * float(np.sqrt(lasting / values.size)),
        degrees_of_freedom=values.size / lasting - 1.0,
        middle=float(place.mean()),
        noise=deviation * float(np.sqrt(lasting)),
    )


def _weights(rests: list[Rest], at: float) -> tuple[float, ...]:
    """Return how the rests weigh in the output at rest at a place between them."""
    if len(rests) == 1:
        return (1.0,)
    share = (at - rests[0].middle) / (rests[1].middle - rests[0].middle)
    return (1.0 - share, share)


def _combined_freedom(variances: list[float], rests: list[Rest]) -> float:
    """Welch–Satterthwaite, JCGM 100 eq. G.2b."""
    shares = sum(
        variance**2 / one.degrees_of_freedom for variance, one in zip(variances, rests, strict=True)
    )
    return sum(variances) ** 2 / shares if shares > 0.0 else sum(one.degrees_of_freedom for one in rests)


def _drift(rests: list[Rest], difference: float | None, lasts_s: float) -> float | None:
    if difference is None:
        return None
    by_noise = float(np.hypot(rests[0].uncertainty, rests[1].uncertainty))
    return abs(difference) / 2.0 * lasts_s if abs(difference) > _DRIFTS_SIGMAS * by_noise else None
