"""What is to be said of a sine-vibration case beside its results."""

from collections.abc import Iterator
from statistics import median

from gyrotest.procedures.sine_vibration.measured import MeasuredSines
from gyrotest.procedures.vibration_inspection import step_words
from gyrotest.procedures.vibration_names import AGAINST_THE_SIGN, level_remarks
from gyrotest.procedures.wording import plain
from gyrotest.records.plan import Context

_WORTH_TELLING = 1e-4
_DISTORTED = 0.05
_ROOT_2 = 2.0**0.5


def sine_remarks(measured: MeasuredSines, context: Context) -> Iterator[str]:
    """Give every remark, the gravest first."""
    if measured.inverted:
        yield AGAINST_THE_SIGN
    yield from _missing(measured)
    yield from _level(measured, context)
    yield from _frequency(measured)
    yield from _distortion(measured)


def _missing(measured: MeasuredSines) -> Iterator[str]:
    for one in measured.shortened:
        yield (
            f"S{step_words(one.dwell)[1:]}: samples are missing; the longest stretch without gaps is used,"
            f" {one.used} of {one.dwell.samples} samples."
        )


def _level(measured: MeasuredSines, context: Context) -> Iterator[str]:
    """By the middle one of all frequencies; each one's level stands beside its results."""
    moved_dps = median(one.response.rate_dps for one in measured.points) / _ROOT_2
    yield from level_remarks(moved_dps, context.parameters.level.to("deg/s"))


def _frequency(measured: MeasuredSines) -> Iterator[str]:
    off = [
        one
        for one in measured.points
        if abs(one.response.frequency_hz / one.asked_hz - 1.0) > _WORTH_TELLING
    ]
    if off:
        worst = max(off, key=lambda one: abs(one.response.frequency_hz / one.asked_hz - 1.0))
        yield (
            f"The table's frequency differs from the one asked for, most at {plain(worst.asked_hz, 6)} Hz, where"
            f" it is {plain(worst.response.frequency_hz, 7)} Hz; the fitted one is used."
        )


def _distortion(measured: MeasuredSines) -> Iterator[str]:
    left = {
        one.asked_hz: one.response.output_residual * _ROOT_2 / one.response.output
        for one in measured.points
        if one.response.output_residual * _ROOT_2 > _DISTORTED * one.response.output > 0.0
    }
    if left:
        yield (
            f"Beside its sine the output has up to {plain(100.0 * max(left.values()), 2)} % (rms, of the sine) of"
            f" something else at {_named(left)} Hz: noise, distortion, or motion of the table beside its sine."
        )


def _named(frequencies: dict[float, float]) -> str:
    return ", ".join(plain(one, 6) for one in frequencies)
