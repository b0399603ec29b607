"""How a bias follows the temperature: the worst ratio to the room temperature, and the slope of a line."""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from gyrotest.errors import InsufficientDataError

_FEWEST = 2


@dataclass(frozen=True, slots=True, kw_only=True)
class TemperatureSensitivity:
    """The greatest of |B_i − B_room|/|T_i − T_room|, in units of the bias a °C.

    `change` and `distance_c` are what it is the ratio of, `worst` the set point's place in the arrays.
    `ratios` (n − 1,) are those of all set points but the room, signed, `by_bias` and `by_setting` their
    standard uncertainties by noise and by the errors of the two temperatures.
    """

    value: float
    worst: int
    change: float
    distance_c: float
    ratios: NDArray[np.float64]
    by_bias: NDArray[np.float64]
    by_setting: NDArray[np.float64]


@dataclass(frozen=True, slots=True, kw_only=True)
class TemperatureLine:
    """The line of least squares through the biases: slope in units of the bias a °C.

    `departure` is the largest distance of a bias from it. Standard uncertainties as of
    `TemperatureSensitivity`; where the biases do not lie on a line, the slope is that of this choice
    of temperatures.
    """

    slope: float
    at_room: float
    departure: float
    by_bias: float
    by_setting: float


def temperature_sensitivity(
    temperature_degc: ArrayLike,
    bias: ArrayLike,
    *,
    room: int,
    bias_covariance: NDArray[np.float64],
    setting_uncertainty_c: float,
) -> TemperatureSensitivity:
    """Find the set point at which the bias changes most for its distance from the room temperature.

    Parameters
    ----------
    temperature_degc, bias
        Shape (n,): a temperature and a mean bias for each set point; the bias in any unit of rate.
    room
        Place of the room temperature in the arrays.
    bias_covariance
        Shape (n, n): covariance of the biases by their noise, square of their unit.
    setting_uncertainty_c
        Standard uncertainty of each temperature by its own error.

    Raises
    ------
    InsufficientDataError
        No set point apart from the room's, or one at the same temperature.

    Notes
    -----
    S3.9: S = max|B_i − B_room| / |T_i − T_room|. Of several ratios the largest is also the one that
    noise made larger: S errs towards the larger side where the ratios differ by no more than noise, and
    its interval is that of a largest magnitude (`gyrotest.analysis.extremes`).
    """
    found, values = _checked(temperature_degc, bias)
    distance = found - found[room]
    others = np.arange(found.size) != room
    if not others.any() or np.any(distance[others] == 0.0):
        raise InsufficientDataError(
            "a sensitivity needs temperatures that differ from the room's; found"
            f" {', '.join(f'{one:.4g} °C' for one in found)}"
        )
    distance, change = distance[others], (values - values[room])[others]
    ratios = change / distance
    worst = int(np.abs(ratios).argmax())
    variance = np.diag(bias_covariance) + bias_covariance[room, room] - 2.0 * bias_covariance[room]
    return TemperatureSensitivity(
        value=abs(float(ratios[worst])),
        worst=int(np.flatnonzero(others)[worst]),
        change=float(change[worst]),
        distance_c=float(distance[worst]),
        ratios=ratios,
        by_bias=np.sqrt(np.maximum(variance[others], 0.0)) / np.abs(distance),
        by_setting=np.abs(ratios / distance) * math.sqrt(2.0) * setting_uncertainty_c,
    )


def temperature_line(
    temperature_degc: ArrayLike,
    bias: ArrayLike,
    *,
    room: int,
    bias_covariance: NDArray[np.float64],
    setting_uncertainty_c: float,
) -> TemperatureLine:
    """Fit a line to biases over temperature by least squares.

    Parameters
    ----------
    temperature_degc, bias, room, bias_covariance, setting_uncertainty_c
        As of `temperature_sensitivity`.

    Raises
    ------
    InsufficientDataError
        Fewer than two temperatures that differ.

    Notes
    -----
    slope = Σ(T_i − T̄)B_i / Σ(T_i − T̄)², its variance gᵀVg with g_i = (T_i − T̄)/Σ(T_i − T̄)², and
    slope²·u²(T)·Σg_i² for the temperatures.
    """
    found, values = _checked(temperature_degc, bias)
    apart = found - found.mean()
    square = float(apart @ apart)
    if square == 0.0:
        raise InsufficientDataError("a slope needs at least two temperatures that differ")
    gradient = apart / square
    slope = float(gradient @ values)
    line = values.mean() + slope * apart
    return TemperatureLine(
        slope=slope,
        at_room=float(line[room]),
        departure=float(np.abs(values - line).max()),
        by_bias=float(np.sqrt(gradient @ bias_covariance @ gradient)),
        by_setting=abs(slope) * setting_uncertainty_c * float(np.sqrt(gradient @ gradient)),
    )


def _checked(temperature_degc: ArrayLike, bias: ArrayLike) -> tuple[NDArray[np.float64], ...]:
    found = np.asarray(temperature_degc, dtype=np.float64)
    values = np.asarray(bias, dtype=np.float64)
    if found.size < _FEWEST:
        raise InsufficientDataError(f"{found.size} set points; at least {_FEWEST} are needed")
    if not (np.isfinite(found).all() and np.isfinite(values).all()):
        raise InsufficientDataError("a temperature or a bias is not finite")
    return found, values
