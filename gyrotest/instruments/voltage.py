"""What the settings of DC voltmeters have in common: range, integration time, noise of a mean."""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Annotated, Any, ClassVar

from gyrotest.errors import InstrumentError
from gyrotest.records.described import Described
from gyrotest.records.station import Accuracy
from gyrotest.units import Dimension, OfDimension, Quantity

_RANGE_10_V = Quantity(10.0, "V")
_RANGES_V = (0.1, 1.0, 10.0, 100.0, 1000.0)


@dataclass(frozen=True, slots=True, kw_only=True)
class MeterSettings:
    """The settings of a meter that measures DC volts, in a station beside the instrument's own."""

    __pydantic_config__: ClassVar[Mapping[str, Any]] = {"extra": "forbid", "strict": True}

    range: Annotated[
        Quantity, OfDimension(Dimension.VOLTAGE), Described("Measuring range; never automatic.", "10 V")
    ] = _RANGE_10_V
    nplc: Annotated[float, Described("Integration time of a reading in power-line cycles.", "10")] = 10.0
    autozero: Annotated[
        bool,
        Described("Measure the zero after each reading: half as fast, no drift over hours.", "true"),
    ] = True
    high_impedance: Annotated[
        bool, Described("More than 10 GOhm input resistance up to 10 V, else 10 MOhm.", "true")
    ] = True


def check_range(voltage: Quantity) -> None:
    """Refuse what is no range of a bench multimeter; raises `ValueError`."""
    if not any(math.isclose(voltage.to("V"), known) for known in _RANGES_V):
        known = ", ".join(f"{one:g} V" for one in _RANGES_V)
        raise ValueError(f"range {voltage} is none of the meter's: write one of {known}")


def check_nplc(nplc: float, known: tuple[float, ...], model: str) -> None:
    """Refuse an integration time that the meter does not have; raises `ValueError`."""
    if nplc not in known:
        one_of = ", ".join(f"{one:g}" for one in known)
        raise ValueError(
            f"nplc {nplc:g} is none of the {model}'s: write one of {one_of} power-line cycles"
        )


def power_line_cycle_s(line_frequency_hz: float | None, who: str) -> float:
    """The time of one power-line cycle; raises `InstrumentError` where the frequency is not known."""
    if line_frequency_hz is None:
        raise InstrumentError(
            f"{who}: the integration time is set in power-line cycles, whose length is not known;"
            " set line_frequency in the station: '50 Hz' or '60 Hz'"
        )
    return 1.0 / line_frequency_hz


def noise_of_mean(accuracy: Accuracy | None, readings: int) -> float | None:
    """The meter's own rms noise of a mean of readings, V; None where not known."""
    if accuracy is None or accuracy.noise is None:
        return None
    return accuracy.noise.to("V") / math.sqrt(readings)


def too_short(who: str, interval_s: float, *, reading: str, shortest_s: float) -> InstrumentError:
    """The refusal of an interval that the meter cannot reach."""
    return InstrumentError(
        f"{who}: an interval of {interval_s:g} s cannot be reached with {reading};"
        f" the shortest is {shortest_s:.4g} s; lengthen the interval or lower nplc"
    )


def on_off(*, on: bool) -> str:
    """A switch in a command."""
    return "ON" if on else "OFF"
