"""What the angle is measured by that a unit is compared with, and how a level shaft lies."""

from collections.abc import Iterator

from gyrotest.certificate.printing import printed_text
from gyrotest.records.recording import ENCODER
from gyrotest.records.run import RunRecord
from gyrotest.records.station import Encoder, Shaft, Slot
from gyrotest.units import Quantity


def angles(record: RunRecord) -> Iterator[str]:
    """Tell of the encoder and of the shaft, as far as they were used; a half-width with each."""
    station = record.header.station.station
    slot = station.slots.get(record.header.slot)
    if slot is None or record.replayed:
        return
    if slot.encoder is not None and _recorded(record):
        yield f"Angle measured by {_encoder(slot.encoder)}."
    shaft = station.shaft(record.header.slot)
    if shaft is not None and _held(record):
        yield printed_text(_lies(shaft))
        yield f"Axes of the unit along those of the stage: {_frame(slot)}."


def _recorded(record: RunRecord) -> bool:
    return any(
        name.startswith(ENCODER)
        for item in record.items
        for attempt in item.attempts
        if attempt.recording is not None
        for name in attempt.recording.header.sampling.columns
    )


def _held(record: RunRecord) -> bool:
    """Whether the shaft was put to an angle."""
    return any(
        dwell.position_deg is not None
        for item in record.items
        for attempt in item.attempts
        if attempt.recording is not None
        for dwell in attempt.recording.dwells
    )


def _encoder(encoder: Encoder) -> str:
    what = (
        f"an encoder (channel {encoder.angle})"
        if encoder.lines is None
        else f"a grating of {encoder.lines} lines a turn (channels {encoder.sine} and {encoder.cosine})"
    )
    against = ", which counts against the unit's direction" if encoder.reversed else ""
    return f"{what}{against}; {_within(encoder.accuracy, 'its error within a turn')}"


def _within(half_width: Quantity | None, what: str) -> str:
    return (
        f"{what} is not stated" if half_width is None else printed_text(f"{what} ±{half_width} at most")
    )


def _lies(shaft: Shaft) -> str:
    azimuth = (
        "is not stated"
        if shaft.azimuth is None
        else f"{shaft.azimuth} (±{shaft.azimuth_uncertainty} at most)"
    )
    return (
        f"Level shaft: azimuth of the stage's x axis at the angle 0 {azimuth}; tilt {shaft.tilt}"
        f" (±{shaft.tilt_uncertainty} at most); angle 0 within ±{shaft.index_uncertainty}."
    )


def _frame(slot: Slot) -> str:
    told = ", ".join(f"{own} along {along}" for own, along in slot.frame.items())
    return told.replace("-", "\N{MINUS SIGN}")
