"""What a static case may be told, and what it measures."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Annotated, ClassVar

from gyrotest.analysis.noise import SHORTEST_RECORD
from gyrotest.procedures.rest.bias_over_repeats import run_to_run_name
from gyrotest.procedures.static.terms import (
    ANGLE_WALK,
    BIAS_INSTABILITY,
    QUANTIZATION,
    RAMP,
    RATE_WALK,
    Term,
)
from gyrotest.records.described import Described
from gyrotest.records.result import Measurand
from gyrotest.records.spec import Case, Over
from gyrotest.units import Dimension, OfDimension, Quantity

_WHOLE = 1e-6
_MOST_SMOOTHINGS = 20


@dataclass(frozen=True, slots=True, kw_only=True)
class StaticParameters:
    """Parameters of a static case; times count from the record's first sample."""

    __pydantic_config__: ClassVar = {"extra": "forbid", "strict": True}

    smoothing: Annotated[
        tuple[Annotated[Quantity, OfDimension(Dimension.TIME)], ...],
        Described("times over which the rate is averaged for bias stability", "[1 s, 10 s, 100 s]"),
    ] = (Quantity(1.0, "s"), Quantity(10.0, "s"), Quantity(100.0, "s"))
    start: Annotated[
        Quantity | None,
        OfDimension(Dimension.TIME),
        Described("time from which on bias stability counts; the record's begin by default", "5 min"),
    ] = None
    window: Annotated[
        tuple[
            Annotated[Quantity, OfDimension(Dimension.TIME)],
            Annotated[Quantity, OfDimension(Dimension.TIME)],
        ]
        | None,
        Described(
            "part of the record that is used, [begin, end); all of it by default", "[0 s, 30 min]"
        ),
    ] = None


def stability_name(smoothing: Quantity) -> str:
    """Return the name of the bias stability over a smoothing time: `bias_stability_10s`."""
    return f"bias_stability_{str(smoothing).replace(' ', '')}"


def static_measurands(case: Case, parameters: StaticParameters) -> tuple[Measurand, ...]:
    """Return all that a static case measures."""
    rate = Dimension.RATE
    return (
        _measurand("bias", "Bias", rate, "deg/s"),
        *(
            _measurand(stability_name(one), f"Bias stability, {one} averages", rate, "deg/h")
            for one in parameters.smoothing
        ),
        _measurand("allan_minimum", "Allan deviation, minimum", rate, "deg/h"),
        _fitted(BIAS_INSTABILITY),
        _fitted(ANGLE_WALK),
        _measurand(
            "angle_random_walk_apparent",
            "Angle random walk, as read",
            ANGLE_WALK.dimension,
            ANGLE_WALK.unit,
        ),
        *(_fitted(one) for one in (RATE_WALK, RAMP, QUANTIZATION)),
        *_over_repeats(case),
    )


def _measurand(
    name: str, label: str, dimension: Dimension, unit: str, over: Over | None = None
) -> Measurand:
    return Measurand(name=name, label=label, dimension=dimension, unit=unit, over=over)


def _fitted(term: Term) -> Measurand:
    return _measurand(term.name, term.label, term.dimension, term.unit)


def _over_repeats(case: Case) -> Iterator[Measurand]:
    if case.repeats < 2:
        return
    name = run_to_run_name(case)
    label = "Bias repeatability" if name == "bias_repeatability" else "Bias, run to run"
    yield _measurand(name, label, Dimension.RATE, "deg/h", Over.REPEATS)


def static_complaints(case: Case, parameters: StaticParameters) -> Iterator[tuple[str, str]]:
    """Give what is wrong with a static case beyond its types: key and message."""
    interval_s, duration_s = case.interval.to("s"), case.duration.to("s")
    begin_s, end_s = 0.0, duration_s
    if parameters.window is not None:
        begin_s, end_s = (one.to("s") for one in parameters.window)
        if not 0.0 <= begin_s < end_s <= duration_s * (1.0 + _WHOLE):
            begin, end = parameters.window
            message = f"[{begin}, {end}) is no part of the record; it lasts {case.duration} from 0 s on"
            yield "parameters.window", message
            return
    samples = round((end_s - begin_s) / interval_s)
    if samples < SHORTEST_RECORD:
        shortest = SHORTEST_RECORD * interval_s
        yield (
            "duration" if parameters.window is None else "parameters.window",
            f"{samples} samples are too few for an Allan deviation;"
            f" {SHORTEST_RECORD} are needed, {shortest:g} s of record",
        )
        return
    if parameters.start is not None:
        start_s = parameters.start.to("s")
        if not 0.0 <= start_s < end_s:
            yield "parameters.start", f"'{parameters.start}' is not within the record"
            return
        begin_s = max(begin_s, start_s)
    yield from _smoothing_complaints(parameters, interval_s, end_s - begin_s)


def _smoothing_complaints(
    parameters: StaticParameters, interval_s: float, length_s: float
) -> Iterator[tuple[str, str]]:
    if not 1 <= len(parameters.smoothing) <= _MOST_SMOOTHINGS:
        yield "parameters.smoothing", f"gives no time, or more than {_MOST_SMOOTHINGS}; e.g. [1 s, 10 s]"
    seen: set[str] = set()
    for place, smoothing in enumerate(parameters.smoothing):
        key, time_s = f"parameters.smoothing[{place}]", smoothing.to("s")
        intervals = time_s / interval_s
        if stability_name(smoothing) in seen:
            yield key, f"'{smoothing}' is there twice"
        elif intervals < 1.0 - _WHOLE or abs(intervals - round(intervals)) > _WHOLE * intervals:
            fits = max(round(intervals), 1) * interval_s
            message = (
                f"'{smoothing}' is no whole number of intervals of {interval_s:g} s; e.g. '{fits:g} s'"
            )
            yield key, message
        elif length_s / time_s < 2.0 - _WHOLE:
            yield key, f"'{smoothing}' leaves fewer than two averages of the {length_s:g} s that count"
        seen.add(stability_name(smoothing))
