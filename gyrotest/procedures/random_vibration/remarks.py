"""What is to be said of a response beside its results: what was left out, and what speaks against it."""

from collections.abc import Iterator

import numpy as np

from gyrotest.procedures.random_vibration.measured import MeasuredResponse
from gyrotest.procedures.random_vibration.parameters import RandomVibrationParameters
from gyrotest.procedures.random_vibration.stretches import stretches_of
from gyrotest.procedures.vibration_names import AGAINST_THE_SIGN, level_remarks
from gyrotest.procedures.wording import plain
from gyrotest.records.plan import Context

_MOST_NAMED = 12
_COMMON_MOTION = 0.3
_MINUS = "\N{MINUS SIGN}"


def response_remarks(measured: MeasuredResponse, context: Context) -> Iterator[str]:
    """Give every remark, the gravest first."""
    if measured.inverted:
        yield AGAINST_THE_SIGN
    yield from _left_out(measured, context)
    yield from level_remarks(measured.rate_dps, context.parameters.level.to("deg/s"))
    yield from _at_rest(measured)
    yield from _lack_of_fit(measured, context)
    missing = sum(gap.missing for gap in context.gaps)
    if missing:
        yield f"{missing} samples are missing; no segment of the spectra bridges them."


def _left_out(measured: MeasuredResponse, context: Context) -> Iterator[str]:
    excluded = measured.curve.excluded_hz
    if not excluded.size:
        return
    parameters: RandomVibrationParameters = context.parameters
    spans = [_span(one) for one in stretches_of(excluded, 1.0 / measured.response.segment_s)]
    named = ", ".join(spans[:_MOST_NAMED]) + (", …" if len(spans) > _MOST_NAMED else "")
    yield (
        f"Left out, their coherence below {parameters.coherence_floor:g}: {excluded.size} of"
        f" {measured.response.frequency_hz.size} frequencies ({named} Hz)."
    )


def _span(frequencies_hz: np.ndarray) -> str:
    first, last = plain(float(frequencies_hz[0]), 6), plain(float(frequencies_hz[-1]), 6)
    return first if first == last else f"{first} … {last}"


def _at_rest(measured: MeasuredResponse) -> Iterator[str]:
    common = measured.noise.coherence
    if common is not None and common > _COMMON_MOTION:
        yield (
            f"At rest both channels see the same motion (coherence {plain(common, 2)}): the table does not stand"
            " still, and the ratio of the noises is drawn towards the square of the gain."
        )


def _lack_of_fit(measured: MeasuredResponse, context: Context) -> Iterator[str]:
    parameters: RandomVibrationParameters = context.parameters
    for what, fit, unit, factor in (
        ("sensitivity", measured.curve.log_gain, "%", 100.0),
        ("phase", measured.curve.phase, "°", 1.0),
    ):
        if fit.lacking:
            yield (
                f"A polynomial of degree {parameters.degree} does not follow the {what} wholly: it lacks"
                f" {plain(fit.lack_rms * factor, 2)} {unit} (rms over the band), which is part of the"
                " uncertainties; see 'parameters.degree'."
            )
