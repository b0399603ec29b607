"""What is uncertain in a frequency response by whichever method: the source's gain, the encoder, the skew.

Both methods err by it alike, so that it cancels where they are compared.
"""

import math
from collections.abc import Iterator

from gyrotest.procedures.uncertainty import rectangular
from gyrotest.procedures.wording import engineering, plain
from gyrotest.records.plan import Context
from gyrotest.records.recording import Sampling
from gyrotest.records.result import Contribution
from gyrotest.records.spec import OutputKind
from gyrotest.units import printed_unit

_TURN_DEG = 360.0
_WAVES = 2.0
_PPM = 1e6


def gain_contributions(context: Context, *, value: float, unit: str) -> Iterator[Contribution]:
    """Give what makes every sensitivity too large or too small in the same proportion; `value` is in `unit`.

    An error of the encoder that goes up and down once or twice in a turn makes the angle's slope err by
    2·2π/360° times its half-width at most.
    """
    if context.accuracy is not None:
        share = context.accuracy.of_reading
        yield _of_gain(f"source, {share} of reading", share.to(""), value, unit)
    encoder = context.encoder
    if encoder is not None and encoder.accuracy is not None:
        slope = _WAVES * math.radians(encoder.accuracy.to("deg"))
        yield _of_gain(f"encoder, {encoder.accuracy}, up to twice a turn", slope, value, unit)


def phase_contributions(sampling: Sampling, *, frequency_hz: float) -> Iterator[Contribution]:
    """Give what delays the output against the encoder, ° (S4.8: 28 µs is 1° at 100 Hz)."""
    skew_s = sampling.skew_uncertainty_s
    if skew_s:
        slope = _TURN_DEG * frequency_hz
        half_width = engineering(skew_s, "s")
        sensitivity = f"{plain(slope * 1e-6, 3)} °/µs"
        yield rectangular("skew of the channels", half_width, sensitivity, slope * skew_s)


def missing_of_gain(context: Context) -> tuple[str, ...]:
    """Give what could not be had of the uncertainty of a sensitivity."""
    missing = []
    if context.output.kind is OutputKind.VOLTAGE and context.accuracy is None:
        missing.append("accuracy of the source")
    if context.encoder is None or context.encoder.accuracy is None:
        missing.append("accuracy of the encoder")
    return tuple(missing)


def missing_of_phase(sampling: Sampling) -> tuple[str, ...]:
    """Give what could not be had of the uncertainty of a phase."""
    return ("skew of the channels",) if sampling.skew_uncertainty_s is None else ()


def _of_gain(source: str, share: float, value: float, unit: str) -> Contribution:
    of = f"{plain(abs(value), 4)} {printed_unit(unit)}".strip()
    return rectangular(source, f"{plain(share * _PPM, 3)} ppm", of, share * abs(value))
