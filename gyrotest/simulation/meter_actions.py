"""How an action of a simulated meter is made: setters, getters, and how numbers are printed."""

import functools
import math
from collections.abc import Callable, Sequence

from gyrotest.simulation.converter import OVERLOAD_V
from gyrotest.simulation.meter import Meter
from gyrotest.simulation.scpi import Action, keyword, none, one


def ascii_reading(value: float) -> str:
    """A reading as the meter prints it: `+2.51234567E+00`."""
    return f"{value:+.8E}"


def ascii_readings(values: Sequence[float]) -> bytes:
    """Readings as the meter prints them, separated by commas."""
    return ",".join(map(ascii_reading, values)).encode()


def _real(value: float) -> str:
    return ascii_reading(OVERLOAD_V if math.isinf(value) else value)


def setter(change: Callable[[Meter, str], None]) -> Action[Meter]:
    """An action with one parameter that changes the measurement: it ends what is under way."""

    @functools.wraps(change)
    def action(meter: Meter, parameters: Sequence[str]) -> None:
        change(meter, one(parameters))
        meter.abort()
        meter.memory.clear()

    return action


def getter(value: Callable[[Meter], str]) -> Action[Meter]:
    """A query without parameters."""

    @functools.wraps(value)
    def action(meter: Meter, parameters: Sequence[str]) -> str:
        none(parameters)
        return value(meter)

    return action


def limits_query(
    value: Callable[[Meter], float], least: Callable[[Meter], float], most: Callable[[Meter], float]
) -> Action[Meter]:
    """A query of a number, or of its limits with MIN or MAX as parameter."""

    def action(meter: Meter, parameters: Sequence[str]) -> str:
        if not parameters:
            return _real(value(meter))
        asked = keyword(one(parameters), "MINimum", "MAXimum", "DEFault")
        return _real({"MIN": least, "MAX": most}.get(asked, value)(meter))

    return action
