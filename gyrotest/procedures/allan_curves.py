"""An Allan deviation, its confidence band and its fitted components, as what figures are made of."""

from collections.abc import Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gyrotest.analysis.allan import AllanDeviation
from gyrotest.analysis.noise_model import NoiseModel
from gyrotest.records.figure import Band, Curve, Role

TERM_LETTERS = ("Q", "N", "B", "K", "R")
"""The noise model's terms in its order: quantization, angle and rate walk, and the others."""

# A component is drawn where it makes up at least so much of the fitted deviation: below, it would
# stretch the axis and show nothing.
_DRAWN_SHARE = 0.15
_SAME_TIME = 1e-9


def deviation_curve(curve: AllanDeviation, *, per_dps: float, series: int = 0, label: str = "") -> Curve:
    """Return a record's curve; `per_dps` units of the y axis make 1 °/s."""
    return Curve(
        x=_numbers(curve.tau_s),
        y=_numbers(curve.deviation_dps * per_dps),
        role=Role.DATA,
        series=series,
        label=label,
    )


def confidence_band(curve: AllanDeviation, *, per_dps: float, series: int = 0) -> Band:
    """Return the 68 % band around a record's curve."""
    return Band(
        x=_numbers(curve.tau_s),
        lower=_numbers(curve.lower_dps * per_dps),
        upper=_numbers(curve.upper_dps * per_dps),
        series=series,
    )


def fitted_curve(
    curve: AllanDeviation, model: NoiseModel, *, per_dps: float, label: str = "fit"
) -> Curve:
    """Return the model's curve at those averaging times of a record's curve that were fitted."""
    factors = _fitted(curve, model)
    return Curve(
        x=_numbers(factors * model.grid.interval_s),
        y=_numbers(model.allan_deviation_dps(factors) * per_dps),
        role=Role.MODEL,
        label=label,
    )


def component_curves(curve: AllanDeviation, model: NoiseModel, *, per_dps: float) -> Iterator[Curve]:
    """Yield what each term contributes to the fitted curve, where that is not negligible.

    A label is the term's letter. A term that the fit found to be nothing is left out.
    """
    factors = _fitted(curve, model)
    floor = _DRAWN_SHARE * model.allan_deviation_dps(factors)
    for letter, deviation_dps in zip(TERM_LETTERS, model.components_dps(factors), strict=True):
        drawn = deviation_dps >= floor
        if np.count_nonzero(drawn) > 1:
            yield Curve(
                x=_numbers(factors[drawn] * model.grid.interval_s),
                y=_numbers(deviation_dps[drawn] * per_dps),
                role=Role.COMPONENT,
                label=letter,
            )


def _fitted(curve: AllanDeviation, model: NoiseModel) -> NDArray[np.int64]:
    first_s, last_s = model.first_tau_s * (1 - _SAME_TIME), model.last_tau_s * (1 + _SAME_TIME)
    fitted: NDArray[np.int64] = curve.averaging_factor[
        (curve.tau_s >= first_s) & (curve.tau_s <= last_s)
    ]
    return fitted


def _numbers(values: NDArray[np.floating[Any]]) -> tuple[float, ...]:
    return tuple(values.tolist())
