"""What a synchronous source says of itself, held against what is asked of it and what the station says."""

import math

from gyrotest.errors import InstrumentError
from gyrotest.records.station import Accuracy
from gyrotest.units import Quantity, same_dimension

_RATES_AGREE = 1e-6
_FILTERS_AGREE = 0.01


def refuse_other_rate(who: str, *, asked_hz: float, had_hz: float) -> None:
    """Refuse another rate than the one asked for, naming the interval that would do."""
    if not math.isclose(had_hz, asked_hz, rel_tol=_RATES_AGREE):
        raise InstrumentError(
            f"{who}: samples at {had_hz:.9g} Hz where {asked_hz:.9g} Hz is asked for; set the case's interval"
            f" to {1.0 / had_hz:.12g} s, or to another that it has"
        )


def filter_hz(who: str, *, said_hz: float | None, stated: Quantity | None) -> float | None:
    """The filter's cut-off, by the source or else by the station; raises `InstrumentError` where they differ."""
    if stated is None or said_hz is None:
        return said_hz if stated is None else stated.to("Hz")
    if not math.isclose(stated.to("Hz"), said_hz, rel_tol=_FILTERS_AGREE):
        raise InstrumentError(
            f"{who}: its filter cuts off at {said_hz:g} Hz, the station says {stated};"
            " correct or remove the station's filter"
        )
    return said_hz


def noise_of(accuracy: Accuracy | None, unit: str) -> float | None:
    """The source's own noise, as the station states it; None where it does not, or in another kind of unit."""
    noise = accuracy.noise if accuracy else None
    return noise.to(unit) if noise is not None and same_dimension(noise.unit, unit) else None
