"""Squared second differences of an angle at many averaging factors, octaves together.

The differences of m, 2m, 4m … samples that end at one point have that point, and most of the others,
in common: one pass over a stretch of the angle that stays in the cache serves four of them at a time.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gyrotest.analysis.compiled import Floats, FloatsOut, Integers, compiled, compiled_sums

_BLOCK = 8192


@dataclass(frozen=True, slots=True, kw_only=True)
class Chains:
    """Factors in chains of doublings: each chain's first one and how many; where each factor's sum is."""

    first: NDArray[np.int64]
    octaves: NDArray[np.int64]
    place: NDArray[np.intp]


def octave_chains(factors: NDArray[np.int64]) -> Chains:
    """Put ascending averaging factors into chains."""
    left = dict.fromkeys(factors.tolist())
    chains: list[list[int]] = []
    while left:
        chain = [next(iter(left))]
        while 2 * chain[-1] in left:
            chain.append(2 * chain[-1])
        for factor in chain:
            del left[factor]
        chains.append(chain)
    order = np.array([factor for chain in chains for factor in chain], dtype=np.int64)
    return Chains(
        first=np.array([chain[0] for chain in chains], dtype=np.int64),
        octaves=np.array([len(chain) for chain in chains], dtype=np.int64),
        place=np.argsort(order),
    )


def overlapping_variances(angle: NDArray[np.float64], factors: NDArray[np.int64]) -> NDArray[np.float64]:
    """Overlapping Allan variances of one angle record.

    Parameters
    ----------
    angle
        Shape (n + 1,): the running sum of the rate, in rate × samples.
    factors
        Shape (k,), ascending, at most n/2: averaging factors.

    Returns
    -------
    ndarray
        Shape (k,), in the rate's unit squared: 1/(2m²(n − 2m + 1)) · Σ(θ[k+2m] − 2θ[k+m] + θ[k])².

    Notes
    -----
    NIST SP 1065 eq. 11.
    """
    chains = octave_chains(factors)
    sums = np.zeros(factors.size)
    add_squares(np.ascontiguousarray(angle), 0, angle.size, chains.first, chains.octaves, sums)
    variances: NDArray[np.float64] = sums[chains.place] / (
        2.0 * factors.astype(np.float64) ** 2 * (angle.size - 2 * factors)
    )
    return variances


@compiled
def add_squares(
    angle: Floats, begin: int, end: int, first: Integers, octaves: Integers, sums: FloatsOut
) -> None:
    """Add the squares of the differences that end in angle[begin:end], as far as they begin in it."""
    part = np.empty(sums.size)
    for start in range(begin, end, _BLOCK):
        part[:] = 0.0
        place = 0
        for chain in range(first.size):
            _stretch(angle, start, min(start + _BLOCK, end), first[chain], octaves[chain], part, place)
            place += octaves[chain]
        for place in range(sums.size):
            sums[place] += part[place]


@compiled
def _stretch(
    angle: Floats, begin: int, end: int, factor: int, octaves: int, sums: FloatsOut, place: int
) -> None:
    """Add one chain's squares; near the angle's first point only its shorter factors have any."""
    possible = 0
    while possible < octaves and 2 * (factor << possible) < end:
        possible += 1
    while possible > 0:
        start = max(begin, 2 * (factor << (possible - 1)))
        if start < end:
            _octaves(angle, start, end - start, factor, possible, sums, place)
            end = start
        possible -= 1


@compiled
def _octaves(
    angle: Floats, begin: int, count: int, factor: int, octaves: int, sums: FloatsOut, place: int
) -> None:
    while octaves >= 4:
        _four(angle, begin, count, factor, sums, place)
        factor *= 16
        place += 4
        octaves -= 4
    while octaves > 0:
        _one(angle, begin, count, factor, sums, place)
        factor *= 2
        place += 1
        octaves -= 1


@compiled
def _second(late: float, middle: float, early: float) -> float:
    """Take differences of neighbours first: they are exact, however far the angle has drifted."""
    return (late - middle) - (middle - early)


@compiled_sums
def _four(angle: Floats, begin: int, count: int, m: int, sums: FloatsOut, place: int) -> None:
    # Slices, because an index that might be negative keeps a loop out of the vector registers.
    x0 = angle[begin : begin + count]
    x1 = angle[begin - m : begin - m + count]
    x2 = angle[begin - 2 * m : begin - 2 * m + count]
    x4 = angle[begin - 4 * m : begin - 4 * m + count]
    x8 = angle[begin - 8 * m : begin - 8 * m + count]
    x16 = angle[begin - 16 * m : begin - 16 * m + count]
    sum_1 = sum_2 = sum_4 = sum_8 = 0.0
    for k in range(count):
        sum_1 += _second(x0[k], x1[k], x2[k]) ** 2
        sum_2 += _second(x0[k], x2[k], x4[k]) ** 2
        sum_4 += _second(x0[k], x4[k], x8[k]) ** 2
        sum_8 += _second(x0[k], x8[k], x16[k]) ** 2
    sums[place] += sum_1
    sums[place + 1] += sum_2
    sums[place + 2] += sum_4
    sums[place + 3] += sum_8


@compiled_sums
def _one(angle: Floats, begin: int, count: int, m: int, sums: FloatsOut, place: int) -> None:
    x0 = angle[begin : begin + count]
    x1 = angle[begin - m : begin - m + count]
    x2 = angle[begin - 2 * m : begin - 2 * m + count]
    total = 0.0
    for k in range(count):
        total += _second(x0[k], x1[k], x2[k]) ** 2
    sums[place] += total
