"""Noise type: which power law rules a record at an averaging time, by its lag-1 autocorrelation."""

from enum import IntEnum

import numpy as np
from numpy.typing import NDArray

_SHORTEST = 30
_LONGEST = 65536
_MOST_DIFFERENCES = 2


class NoiseType(IntEnum):
    """A power law of the rate's spectrum; the value is its exponent of frequency."""

    QUANTIZATION = 2
    ANGLE_FLICKER = 1
    ANGLE_RANDOM_WALK = 0
    BIAS_INSTABILITY = -1
    RATE_RANDOM_WALK = -2


def noise_types(
    angle: NDArray[np.float64], averaging_factors: NDArray[np.int64]
) -> tuple[NoiseType, ...]:
    """Identify the dominant noise type at each averaging factor.

    Parameters
    ----------
    angle
        Shape (n + 1,): the running sum of the rate record.
    averaging_factors
        Ascending. Where fewer than 30 averages remain, the type of the next shorter time stands.

    Notes
    -----
    W. J. Riley and C. A. Greenhall, "Power law noise identification using the lag 1
    autocorrelation", 18th EFTF, 2004. A longer record is taken in pieces of 65,536 averages.
    """
    found: list[NoiseType] = []
    for factor in averaging_factors:
        averages = (angle.size - 1) // int(factor)
        if averages >= _SHORTEST:
            found.append(_identify(angle, int(factor), averages))
        else:
            found.append(found[-1] if found else NoiseType.ANGLE_RANDOM_WALK)
    return tuple(found)


def _identify(angle: NDArray[np.float64], factor: int, averages: int) -> NoiseType:
    """Find p = −2(ρ + d), the data differenced d times until ρ = r1/(1 + r1) < 1/4."""
    differences = 0
    while (
        rho := _rho(angle, factor, averages, differences)
    ) >= 0.25 and differences < _MOST_DIFFERENCES:
        differences += 1
    exponent = round(-2.0 * (rho + differences))
    return NoiseType(min(max(exponent, -2), 2))


def _rho(angle: NDArray[np.float64], factor: int, averages: int, differences: int) -> float:
    r1 = _lag_1(angle, factor, averages, differences)
    return r1 / (1.0 + r1)


def _lag_1(angle: NDArray[np.float64], factor: int, averages: int, differences: int) -> float:
    products = squares = 0.0
    for begin in range(0, averages, _LONGEST):
        end = min(begin + _LONGEST, averages)
        if end - begin < _SHORTEST:
            break
        piece = np.diff(angle[begin * factor : end * factor + 1 : factor])
        piece = np.diff(_without_line(piece), n=differences)
        piece -= piece.mean()
        products += float(np.sum(piece[1:] * piece[:-1]))
        squares += float(np.sum(piece * piece))
    return products / squares if squares > 0.0 else 0.0


def _without_line(values: NDArray[np.float64]) -> NDArray[np.float64]:
    """Take the least-squares line out."""
    abscissa = np.arange(values.size) - (values.size - 1) / 2.0
    slope = float(np.sum(abscissa * values) / np.sum(abscissa * abscissa))
    residual: NDArray[np.float64] = values - values.mean() - slope * abscissa
    return residual
