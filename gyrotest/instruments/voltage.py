"""What the settings of DC voltmeters have in common: range, integration time, noise of a mean."""

import math

from gyrotest.errors import InstrumentError
from gyrotest.records.station import Accuracy
from gyrotest.units import Quantity

RANGE_10_V = Quantity(10.0, "V")
_RANGES_V = (0.1, 1.0, 10.0, 100.0, 1000.0)


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
