"""What is wrong with a sine-vibration case beyond its types."""

import math
from collections.abc import Iterator

from gyrotest.analysis.sine_response import FEWEST_PERIODS, SWEPT_SHARE
from gyrotest.procedures.case_plan import step_samples
from gyrotest.procedures.sine_vibration.parameters import SineVibrationParameters, Sweep
from gyrotest.procedures.vibration_complaints import (
    LEAST_OVERSAMPLING,
    repeated_frequencies,
    vibration_complaints,
)
from gyrotest.procedures.vibration_names import BANDWIDTH, FLATNESS, PHASE_90
from gyrotest.procedures.wording import plain
from gyrotest.records.spec import Case, Output

MOST_SAMPLES_STEADY, MOST_SAMPLES_SWEPT = 3_000_000, 20_000_000
"""Samples of a step that are held in memory at once."""

_MOST_FREQUENCIES = 100
_SPARE_PERIODS = 1.0
_SWEPT_MARGIN = 0.02
_WHOLE = 1e-6


def sine_complaints(
    case: Case, parameters: SineVibrationParameters, output: Output
) -> Iterator[tuple[str, str]]:
    """Give every complaint: key below the case, and message."""
    yield from vibration_complaints(case, output, level=parameters.level, settle=parameters.settle)
    frequencies = tuple(_frequency_complaints(parameters))
    yield from frequencies
    if frequencies:
        return
    yield from _reference_complaints(parameters)
    yield from _interval_complaints(case, parameters)
    yield from _sweep_complaints(case, parameters)
    yield from _limit_complaints(case, parameters)


def _frequency_complaints(parameters: SineVibrationParameters) -> Iterator[tuple[str, str]]:
    if not 1 <= len(parameters.frequencies) <= _MOST_FREQUENCIES:
        message = f"gives none, or more than {_MOST_FREQUENCIES}; e.g. [5 Hz, 20 Hz, 100 Hz]"
        yield "parameters.frequencies", message
    yield from repeated_frequencies(parameters.frequencies)
    for place, one in enumerate(parameters.frequencies):
        if one.value <= 0.0:
            yield f"parameters.frequencies[{place}]", f"'{one}' is not more than zero"


def _reference_complaints(parameters: SineVibrationParameters) -> Iterator[tuple[str, str]]:
    known = parameters.frequencies_hz
    reference, flat_to = parameters.reference_frequency, parameters.flat_to
    if reference is not None and not any(_same(reference.to("Hz"), one) for one in known):
        yield "parameters.reference_frequency", f"'{reference}' is none of the 'frequencies'"
    if flat_to is not None and not min(known) <= flat_to.to("Hz") <= max(known):
        low, high = (plain(one(known), 6) for one in (min, max))
        yield "parameters.flat_to", f"'{flat_to}' is outside the frequencies, {low} … {high} Hz"


def _same(one_hz: float, other_hz: float) -> bool:
    return abs(one_hz - other_hz) <= _WHOLE * other_hz


def _interval_complaints(case: Case, parameters: SineVibrationParameters) -> Iterator[tuple[str, str]]:
    """The rule of ten times the cut-off waits for the source, which may state an analogue filter."""
    rate_hz, highest_hz = 1.0 / case.interval.to("s"), parameters.highest_hz
    if rate_hz < LEAST_OVERSAMPLING * highest_hz:
        slowest = 1e3 / (LEAST_OVERSAMPLING * highest_hz)
        yield (
            "interval",
            f"'{case.interval}' is too slow for {plain(highest_hz, 6)} Hz; at most {plain(slowest, 3)} ms, and a"
            " sixth of that and less where no analogue filter is stated",
        )
    most = MOST_SAMPLES_STEADY if parameters.sweep is None else MOST_SAMPLES_SWEPT
    if step_samples(case) > most:
        longest = most * case.interval.to("s")
        yield "duration", f"'{case.duration}' is more than a step can hold; at most {longest:g} s"
    lowest_hz = min(parameters.frequencies_hz)
    shortest_s = (FEWEST_PERIODS + _SPARE_PERIODS) / lowest_hz
    if parameters.sweep is None and case.duration.to("s") < shortest_s * (1.0 - _WHOLE):
        yield (
            "duration",
            f"'{case.duration}' holds fewer than {FEWEST_PERIODS} periods of {plain(lowest_hz, 6)} Hz and one to"
            f" spare; at least {plain(shortest_s, 4)} s",
        )


def _sweep_complaints(case: Case, parameters: SineVibrationParameters) -> Iterator[tuple[str, str]]:
    given = {"sweep_from": parameters.sweep_from, "sweep_to": parameters.sweep_to}
    lacking = [name for name, one in given.items() if one is None]
    if len(lacking) == 1:
        yield f"parameters.{lacking[0]}", "is not given; a sweep needs both ends"
    sweep = parameters.sweep
    if sweep is None:
        return
    if not 0.0 < sweep.low_hz < sweep.high_hz:
        message = f"'{parameters.sweep_to}' does not lie above '{parameters.sweep_from}', or that not above zero"
        yield "parameters.sweep_to", message
        return
    yield from _reach_complaints(parameters, sweep)
    yield from _pace_complaints(case, parameters, sweep)


def _reach_complaints(parameters: SineVibrationParameters, sweep: Sweep) -> Iterator[tuple[str, str]]:
    """The window about a frequency, and a drive that begins a little late, must have room."""
    room = math.exp(SWEPT_SHARE / 2.0 + _SWEPT_MARGIN)
    lowest_hz, highest_hz = min(parameters.frequencies_hz), max(parameters.frequencies_hz)
    if sweep.low_hz * room > lowest_hz * (1.0 + _WHOLE):
        most = plain(lowest_hz / room, 3)
        message = f"'{parameters.sweep_from}' is too near to {plain(lowest_hz, 6)} Hz; at most {most} Hz"
        yield "parameters.sweep_from", message
    if sweep.high_hz < highest_hz * room * (1.0 - _WHOLE):
        least = plain(highest_hz * room, 4)
        message = (
            f"'{parameters.sweep_to}' is too near to {plain(highest_hz, 6)} Hz; at least {least} Hz"
        )
        yield "parameters.sweep_to", message


def _pace_complaints(
    case: Case, parameters: SineVibrationParameters, sweep: Sweep
) -> Iterator[tuple[str, str]]:
    lowest_hz = min(parameters.frequencies_hz)
    octaves = math.log(sweep.high_hz / sweep.low_hz)
    shortest_s = octaves * (FEWEST_PERIODS + _SPARE_PERIODS) / (SWEPT_SHARE * lowest_hz)
    if case.duration.to("s") < shortest_s * (1.0 - _WHOLE):
        yield (
            "duration",
            f"'{case.duration}' sweeps too fast for {plain(lowest_hz, 6)} Hz; at least {plain(shortest_s, 4)} s",
        )


def _limit_complaints(case: Case, parameters: SineVibrationParameters) -> Iterator[tuple[str, str]]:
    if len(parameters.frequencies) < 2:
        for name in (FLATNESS, BANDWIDTH, PHASE_90):
            if name in case.limits:
                yield f"limits.{name}", "needs two frequencies or more; see 'parameters.frequencies'"
