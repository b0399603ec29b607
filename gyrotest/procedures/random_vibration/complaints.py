"""What is wrong with a random-vibration case beyond its types."""

from collections.abc import Iterator

from gyrotest.procedures.case_plan import step_samples
from gyrotest.procedures.random_vibration.measurands import (
    AMPLITUDE_AGREEMENT,
    AMPLITUDE_REPEATABILITY,
    PHASE_AGREEMENT,
    PHASE_REPEATABILITY,
)
from gyrotest.procedures.random_vibration.parameters import RandomVibrationParameters
from gyrotest.procedures.vibration_complaints import (
    LEAST_OVERSAMPLING,
    repeated_frequencies,
    vibration_complaints,
)
from gyrotest.records.spec import Case, Output
from gyrotest.units import Quantity

_MOST_RUNS = 50
_FEWEST_DEGREES, _MOST_DEGREES = 1, 20
_RUN_SEGMENTS, _REST_SEGMENTS = 10, 5
_WHOLE = 1e-6


def random_complaints(
    case: Case, parameters: RandomVibrationParameters, output: Output
) -> Iterator[tuple[str, str]]:
    """Give every complaint: key below the case, and message."""
    yield from vibration_complaints(case, output, level=parameters.level, settle=parameters.settle)
    yield from _count_complaints(parameters)
    band = tuple(_band_complaints(parameters))
    yield from band
    if not band:
        yield from _frequency_complaints(parameters)
        yield from _filter_complaints(case, parameters)
        yield from _length_complaints(case, parameters)
    yield from _comparison_complaints(case, parameters)


def _count_complaints(parameters: RandomVibrationParameters) -> Iterator[tuple[str, str]]:
    if not 1 <= parameters.runs <= _MOST_RUNS:
        yield "parameters.runs", f"{parameters.runs} is not between 1 and {_MOST_RUNS}"
    if not _FEWEST_DEGREES <= parameters.degree <= _MOST_DEGREES:
        yield (
            "parameters.degree",
            f"{parameters.degree} is not between {_FEWEST_DEGREES} and {_MOST_DEGREES}",
        )
    if not 0.0 < parameters.coherence_floor < 1.0:
        message = f"{parameters.coherence_floor:g} is not between 0 and 1; e.g. 0.8"
        yield "parameters.coherence_floor", message


def _band_complaints(parameters: RandomVibrationParameters) -> Iterator[tuple[str, str]]:
    low, high = parameters.low, parameters.high
    if low.value <= 0.0:
        yield "parameters.low", f"'{low}' is not more than zero"
    elif parameters.low_hz >= parameters.high_hz:
        yield "parameters.high", f"'{high}' does not lie above the lowest frequency, '{low}'"


def _frequency_complaints(parameters: RandomVibrationParameters) -> Iterator[tuple[str, str]]:
    yield from repeated_frequencies(parameters.frequencies)
    for place, one in enumerate(parameters.frequencies):
        yield from _outside(f"parameters.frequencies[{place}]", one, parameters)
    for name, given in (
        ("reference_frequency", parameters.reference_frequency),
        ("flat_to", parameters.flat_to),
    ):
        if given is not None:
            yield from _outside(f"parameters.{name}", given, parameters)


def _outside(
    key: str, given: Quantity, parameters: RandomVibrationParameters
) -> Iterator[tuple[str, str]]:
    if not parameters.low_hz <= given.to("Hz") <= parameters.high_hz:
        yield key, f"'{given}' is outside the band, {parameters.low} … {parameters.high}"


def _filter_complaints(case: Case, parameters: RandomVibrationParameters) -> Iterator[tuple[str, str]]:
    """The rule of ten times the cut-off waits for the source, which may state an analogue filter."""
    cutoff_hz, rate_hz = parameters.cutoff_hz, 1.0 / case.interval.to("s")
    if cutoff_hz <= parameters.high_hz:
        yield (
            "parameters.cutoff",
            f"'{parameters.cutoff}' does not lie above the highest frequency, '{parameters.high}'",
        )
    elif rate_hz < LEAST_OVERSAMPLING * cutoff_hz:
        slowest = 1e3 / (LEAST_OVERSAMPLING * cutoff_hz)
        message = (
            f"'{case.interval}' is too slow for a low-pass of {cutoff_hz:g} Hz; at most {slowest:.3g} ms, and a"
            " tenth of a period of that where no analogue filter is stated"
        )
        yield "interval", message


def _length_complaints(case: Case, parameters: RandomVibrationParameters) -> Iterator[tuple[str, str]]:
    segment_s, interval_s = parameters.segment_s, case.interval.to("s")
    if segment_s < parameters.shortest_segment_s * (1.0 - _WHOLE):
        message = (
            f"'{parameters.segment}' holds fewer than 20 periods of '{parameters.low}'; at least"
            f" {parameters.shortest_segment_s:g} s"
        )
        yield "parameters.segment", message
        return
    if step_samples(case) * interval_s < _RUN_SEGMENTS * segment_s * (1.0 - _WHOLE):
        message = (
            f"'{case.duration}' is too short for a run; at least {_RUN_SEGMENTS} segments of {segment_s:g} s,"
            f" {_RUN_SEGMENTS * segment_s:g} s"
        )
        yield "duration", message
    rest_s = parameters.rest.to("s")
    if rest_s < _REST_SEGMENTS * segment_s * (1.0 - _WHOLE):
        message = (
            f"'{parameters.rest}' is too short for the noise at rest; at least {_REST_SEGMENTS} segments of"
            f" {segment_s:g} s, {_REST_SEGMENTS * segment_s:g} s"
        )
        yield "parameters.rest", message
    elif abs(rest_s / interval_s - round(rest_s / interval_s)) > _WHOLE:
        yield (
            "parameters.rest",
            f"'{parameters.rest}' is no whole number of intervals of '{case.interval}'",
        )


def _comparison_complaints(
    case: Case, parameters: RandomVibrationParameters
) -> Iterator[tuple[str, str]]:
    for name, goal in (
        ("amplitude_goal", parameters.amplitude_goal),
        ("phase_goal", parameters.phase_goal),
    ):
        if goal.value <= 0.0:
            yield f"parameters.{name}", f"'{goal}' is not more than zero"
    if parameters.compare_with is not None and not parameters.compare_with.strip():
        yield "parameters.compare_with", "is empty; name an earlier case of procedure 'sine_vibration'"
    if parameters.compare_with is None:
        for name in (AMPLITUDE_AGREEMENT, PHASE_AGREEMENT):
            if name in case.limits:
                message = "compares with an earlier case; name it in 'parameters.compare_with'"
                yield f"limits.{name}", message
    if parameters.runs < 2:
        for name in (AMPLITUDE_REPEATABILITY, PHASE_REPEATABILITY):
            if name in case.limits:
                yield (
                    f"limits.{name}",
                    f"needs two runs or more; see 'parameters.runs', {parameters.runs}",
                )
