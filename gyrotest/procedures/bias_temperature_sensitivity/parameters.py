"""What a temperature case may be told, and what is wrong with it."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Annotated, ClassVar

from gyrotest.analysis.step_noise import SHORTEST_STEP
from gyrotest.procedures.case_plan import plan_of_steps, step_samples
from gyrotest.procedures.recorded_temperature import SENSOR
from gyrotest.records.described import Described
from gyrotest.records.plan import Plan, Soaking, Step
from gyrotest.records.spec import Case
from gyrotest.units import Dimension, OfDimension, Quantity

_APART = 2.0
_ROOM = Quantity(23.0, "degC")
_TOLERANCE = Quantity(0.5, "degC")
_SOAK = Quantity(30.0, "min")
_MOST = 100
_SAME_C = 1e-9


@dataclass(frozen=True, slots=True, kw_only=True)
class TemperatureParameters:
    """Parameters of a temperature case; the case's `duration` is the length of each set point's record."""

    __pydantic_config__: ClassVar = {"extra": "forbid", "strict": True}

    temperatures: Annotated[
        tuple[Annotated[Quantity, OfDimension(Dimension.TEMPERATURE)], ...],
        Described(
            "set points in the order in which they are reached; one may come twice, and the room "
            "temperature is put first and last where it is not among them",
            "[-40 degC, 0 degC, 60 degC, 85 degC]",
        ),
    ]
    soak: Annotated[
        Quantity,
        OfDimension(Dimension.TIME),
        Described(
            "time for which a temperature has held within the tolerance before its record", "30 min"
        ),
    ] = _SOAK
    tolerance: Annotated[
        Quantity,
        OfDimension(Dimension.TEMPERATURE),
        Described("how near to its set point the chamber must be", "0.5 degC"),
    ] = _TOLERANCE
    room: Annotated[
        Quantity,
        OfDimension(Dimension.TEMPERATURE),
        Described("room temperature, from which changes count", "23 degC"),
    ] = _ROOM

    @property
    def set_points_degc(self) -> tuple[float, ...]:
        """The set points as they are carried out, °C.

        A return to the room temperature tells how far the bias wandered by itself meanwhile.
        """
        given = tuple(one.to("degC") for one in self.temperatures)
        room = self.room.to("degC")
        return given if any(same_set_point(one, room) for one in given) else (room, *given, room)


def same_set_point(one_degc: float, other_degc: float) -> bool:
    """Whether two set points are the same temperature."""
    return abs(one_degc - other_degc) <= _SAME_C


def temperature_plan(case: Case, parameters: TemperatureParameters) -> Plan:
    """Return one record at rest at each set point."""
    steps = tuple(
        Step(
            samples=step_samples(case),
            name=f"{temperature:g} °C",
            stimulus=Soaking(
                temperature_degc=temperature,
                soak_s=parameters.soak.to("s"),
                tolerance_c=parameters.tolerance.to("degC"),
            ),
        )
        for temperature in parameters.set_points_degc
    )
    return plan_of_steps(case, steps, auxiliary=(SENSOR,))


def temperature_complaints(case: Case, parameters: TemperatureParameters) -> Iterator[tuple[str, str]]:
    """Give what is wrong with a temperature case beyond its types: key and message."""
    if parameters.soak.value < 0:
        yield "parameters.soak", f"'{parameters.soak}' is less than zero"
    if parameters.tolerance.value <= 0:
        yield "parameters.tolerance", f"'{parameters.tolerance}' is not more than zero"
    samples = step_samples(case)
    if samples < SHORTEST_STEP:
        shortest = SHORTEST_STEP * case.interval.to("s")
        yield (
            "duration",
            f"{samples} samples at a set point are too few to tell how well their mean is known;"
            f" {SHORTEST_STEP} are needed, {shortest:g} s",
        )
    yield from _set_point_complaints(parameters)


def _set_point_complaints(parameters: TemperatureParameters) -> Iterator[tuple[str, str]]:
    room, nearest = parameters.room.to("degC"), _APART * parameters.tolerance.to("degC")
    others = [one for one in parameters.set_points_degc if not same_set_point(one, room)]
    if not others or len(parameters.temperatures) > _MOST:
        message = (
            f"has no temperature beside the room's ({parameters.room}), or more than {_MOST};"
            " e.g. [-40 degC, 0 degC, 60 degC, 85 degC]"
        )
        yield "parameters.temperatures", message
    for place, given in enumerate(parameters.temperatures):
        away = abs(given.to("degC") - room)
        if _SAME_C < away < nearest:
            message = (
                f"'{given}' is {away:.3g} °C from the room temperature, and the chamber may be"
                f" {parameters.tolerance} off: a change cannot be divided by that; at least {nearest:g} °C"
            )
            yield f"parameters.temperatures[{place}]", message
