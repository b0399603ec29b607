"""What must hold of a station's slots and of what turns, vibrates, powers and soaks the units there."""

from collections.abc import Iterator

from gyrotest.analysis.mounting import frame_complaints
from gyrotest.records.recording import ENCODER
from gyrotest.records.station import Encoder, Motion, Shaft, Slot, Station
from gyrotest.specification.checked import Complaint
from gyrotest.specification.shapes import nearest
from gyrotest.specification.yaml_tree import KeyPath

_GRATING = "{sine: ua, cosine: ub, lines: 9000}"
_TURN_DEG = 360.0
_MOST_TILT_DEG = 5.0


def slot_complaints(station: Station) -> Iterator[Complaint]:
    """Give what is wrong with the slots."""
    if not station.slots:
        yield Complaint(("slots",), "is empty; a station has a place for at least one unit")
    for name, slot in station.slots.items():
        yield from _instrument_complaints(station, slot, ("slots", name))
        yield from _channel_complaints(slot, ("slots", name))
        if slot.encoder is not None:
            yield from _encoder_complaints(slot.encoder, ("slots", name, "encoder"))
        for message in frame_complaints(slot.frame):
            yield Complaint(("slots", name, "frame"), message)
    yield from _shared_outputs(station)


def _instrument_complaints(station: Station, slot: Slot, key: KeyPath) -> Iterator[Complaint]:
    for part in ("source", "table", "supply", "chamber", "vibration"):
        name: str | None = getattr(slot, part)
        if name is not None and name not in station.instruments:
            message = f"'{name}' is no instrument of this station; {nearest(name, station.instruments)}"
            yield Complaint((*key, part), message, (("instruments",),))
    table = station.instruments.get(slot.table) if slot.table is not None else None
    if table is not None and table.motion is None:
        message = (
            f"'{slot.table}' has no 'motion'; state how fast and how far it may turn, e.g."
            " {max_rate: 200 deg/s, max_acceleration: 100 deg/s/s, slip_ring: true}"
        )
        yield Complaint((*key, "table"), message, (("instruments", str(slot.table)),))
    if slot.supply_output < 1:
        yield Complaint((*key, "supply_output"), f"{slot.supply_output} is no output; they count from 1")


def _channel_complaints(slot: Slot, key: KeyPath) -> Iterator[Complaint]:
    if slot.channels and slot.channel is not None:
        message = (
            "stands beside 'channel'; a unit of one axis has a 'channel', one of several 'channels'"
        )
        yield Complaint((*key, "channels"), message, ((*key, "channel"),))
    named = [*slot.channels.values(), *slot.auxiliary.values()]
    named += [] if slot.channel is None else [slot.channel]
    if slot.encoder is not None:
        named += [one for one in _channels(slot.encoder).values() if one is not None]
        yield from (
            Complaint((*key, "auxiliary", name), f"names that begin with '{ENCODER}' are the encoder's")
            for name in slot.auxiliary
            if name.startswith(ENCODER)
        )
    twice = next((one for one in named if named.count(one) > 1), None)
    if twice is not None:
        yield Complaint(key, f"channel '{twice}' is named twice")


def _channels(encoder: Encoder) -> dict[str, str | None]:
    return {"sine": encoder.sine, "cosine": encoder.cosine, "angle": encoder.angle}


def _encoder_complaints(encoder: Encoder, key: KeyPath) -> Iterator[Complaint]:
    grating = {"sine": encoder.sine, "cosine": encoder.cosine, "lines": encoder.lines}
    missing = [name for name, value in grating.items() if value is None]
    if encoder.angle is None and missing:
        what = "is empty" if len(missing) == len(grating) else f"lacks {' and '.join(missing)}"
        yield Complaint(key, f"{what}; write e.g. {_GRATING}, or {{angle: theta}}")
    if encoder.angle is not None and len(missing) < len(grating):
        beside = next(name for name in grating if name not in missing)
        message = f"stands beside '{beside}'; an encoder has either an 'angle', or e.g. {_GRATING}"
        yield Complaint((*key, "angle"), message, ((*key, beside),))
    if encoder.lines is not None and encoder.lines < 1:
        yield Complaint((*key, "lines"), f"{encoder.lines} lines are no grating; it has one or more")
    if encoder.accuracy is not None and encoder.accuracy.value < 0:
        yield Complaint((*key, "accuracy"), f"'{encoder.accuracy}' is less than zero")


def shaft_complaints(shaft: Shaft, key: KeyPath) -> Iterator[Complaint]:
    """Give what is wrong with how a level shaft lies."""
    for name in ("azimuth_uncertainty", "tilt_uncertainty", "index_uncertainty"):
        value = getattr(shaft, name)
        if value.value < 0:
            yield Complaint((*key, name), f"'{value}' is less than zero; it is a half-width")
    if shaft.azimuth is not None and abs(shaft.azimuth.to("deg")) > _TURN_DEG:
        yield Complaint((*key, "azimuth"), f"'{shaft.azimuth}' is not between '-360 deg' and '360 deg'")
    if abs(shaft.tilt.to("deg")) > _MOST_TILT_DEG:
        message = f"'{shaft.tilt}' is more than {_MOST_TILT_DEG:g} deg; such a shaft does not lie level"
        yield Complaint((*key, "tilt"), message)


def _shared_outputs(station: Station) -> Iterator[Complaint]:
    """Give slots that would read one signal, or share an output, and so could take each other's unit."""
    seen: dict[tuple[str, ...], str] = {}
    for name, slot in station.slots.items():
        read = tuple(slot.channels.values()) or (slot.channel or "",)
        for channel in read:
            place = ("source", slot.source, channel, *slot.models)
            before = seen.setdefault(place, name)
            if before != name:
                message = (
                    f"reads '{slot.source}' as slot '{before}' does; give each slot its own 'channel'"
                )
                yield Complaint(("slots", name, "source"), message, (("slots", before),))


def motion_complaints(motion: Motion, key: KeyPath) -> Iterator[Complaint]:
    """Give what is wrong with what a table may do."""
    for name, value in (("max_rate", motion.max_rate), ("max_acceleration", motion.max_acceleration)):
        if value.value <= 0:
            yield Complaint((*key, name), f"'{value}' is not more than zero")
    if motion.slip_ring and motion.max_turns is not None:
        message = "has no meaning with a slip ring; remove one of the two"
        yield Complaint((*key, "max_turns"), message, ((*key, "slip_ring"),))
    if not motion.slip_ring and motion.max_turns is None:
        message = (
            "is missing; without a slip ring state how far the cables let the table turn, e.g. 'max_turns: 3',"
            " or write 'slip_ring: true'"
        )
        yield Complaint((*key, "max_turns"), message, ((*key, "slip_ring"),))
    if motion.max_turns is not None and motion.max_turns <= 0:
        yield Complaint((*key, "max_turns"), f"{motion.max_turns:g} is not more than zero")
