"""The lowest point of an Allan deviation curve, and whether it is a floor.

Two bias-instability numbers are in use, and they must never be mixed: `allan_minimum`, the lowest
point of the curve, which most datasheets print, and `bias_instability_coefficient`, the B of IEEE
952, which the noise model fits and which is half as large again (minimum/0.6643) where the curve
really is flat. This module finds the former only; nothing here is divided by 0.6643.
"""

from dataclasses import dataclass

import numpy as np

from gyrotest.analysis.allan import AllanDeviation

FEWEST_FREEDOM = 10.0
"""Degrees of freedom below which a point of the curve is too uncertain to be called its lowest."""

_SAME_TIME = 1e-9


@dataclass(frozen=True, slots=True, kw_only=True)
class AllanMinimum:
    """The lowest admissible point of an Allan deviation curve, with its 95 % chi-square interval.

    Where `reached` is False it lies at an end of the admissible range: the floor was not reached,
    and `deviation_dps` is no more than an upper limit of it, to be shown as `≤`. It is not the
    bias instability coefficient, which is the fit's.
    """

    tau_s: float
    deviation_dps: float
    lower_95_dps: float
    upper_95_dps: float
    reached: bool


def allan_minimum(curve: AllanDeviation, *, first_tau_s: float) -> AllanMinimum | None:
    """Find the lowest point of a curve where its degrees of freedom are at least 10.

    Parameters
    ----------
    curve
        Of one record: its arrays have shape (k,).
    first_tau_s
        Averaging time below which nothing counts: where the noise model begins to describe the
        record (a low-pass filter makes the curve fall towards shorter times, without the bias
        being any stabler); 0 for all of the curve.

    Returns
    -------
    AllanMinimum | None
        None where no averaging time is admissible: the record is too short.
    """
    if curve.deviation_dps.ndim != 1:
        raise ValueError(
            f"the curve has shape {curve.deviation_dps.shape}; the minimum is that of one record"
        )
    described = curve.tau_s >= first_tau_s * (1.0 - _SAME_TIME)
    admissible = np.flatnonzero((curve.edf >= FEWEST_FREEDOM) & described)
    if not admissible.size:
        return None
    place = int(admissible[np.argmin(curve.deviation_dps[admissible])])
    bounds = curve.bounds_dps(0.95)
    return AllanMinimum(
        tau_s=float(curve.tau_s[place]),
        deviation_dps=float(curve.deviation_dps[place]),
        lower_95_dps=float(bounds.lower[place]),
        upper_95_dps=float(bounds.upper[place]),
        reached=place not in (int(admissible[0]), int(admissible[-1])),
    )
