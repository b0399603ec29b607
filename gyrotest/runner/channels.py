"""Which columns of a source are a unit's own: by its slot's channels, or by its axes' names."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

from gyrotest.errors import InstrumentError
from gyrotest.ports import Selecting
from gyrotest.records.recording import ENCODER_ANGLE, ENCODER_COSINE, ENCODER_SINE, Auxiliary, Sampling
from gyrotest.records.station import Slot
from gyrotest.runner.bench import OpenSource


@dataclass(frozen=True, slots=True, kw_only=True)
class Share:
    """A unit's columns of a source, and how they are sampled; outputs bear the axes' names."""

    columns: tuple[int, ...]
    sampling: Sampling


def configured(
    opened: OpenSource, slots: Sequence[Slot], interval_s: float, axes: tuple[str, ...]
) -> tuple[Share, ...]:
    """Set a source up for the units in some slots; each one's share. Raises `InstrumentError`."""
    source = opened.source
    if isinstance(source, Selecting):
        source.select(
            tuple(name for slot in slots for name in slot_outputs(slot)),
            tuple(dict.fromkeys(name for slot in slots for name in slot_auxiliary(slot).values())),
        )
    sampling = source.configure(interval_s)
    return tuple(share(sampling, slot, axes, opened.use.resource) for slot in slots)


def slot_outputs(slot: Slot) -> tuple[str, ...]:
    """The instrument's channels that a slot names for the unit's outputs."""
    if slot.channels:
        return tuple(slot.channels.values())
    return () if slot.channel is None else (slot.channel,)


def slot_auxiliary(slot: Slot) -> dict[str, str]:
    """What is recorded beside a slot's outputs: a name for each, and the instrument's channel."""
    encoder = slot.encoder
    if encoder is None:
        return dict(slot.auxiliary)
    read = {
        ENCODER_SINE: encoder.sine,
        ENCODER_COSINE: encoder.cosine,
        ENCODER_ANGLE: encoder.angle,
    }
    return dict(slot.auxiliary) | {name: one for name, one in read.items() if one is not None}


def share(sampling: Sampling, slot: Slot, axes: tuple[str, ...], who: str) -> Share:
    """A unit's share of what a source gives; raises `InstrumentError` where it is not all there."""
    names = axes or ("output",)
    outputs = _outputs(sampling, slot, names, who)
    auxiliary = _auxiliary(sampling, slot, who)
    columns = (
        *(_place(sampling, one, who) for one in outputs),
        *(_place(sampling, one, who) for one in auxiliary.values()),
    )
    units = {one.name: one.unit for one in sampling.auxiliary}
    return Share(
        columns=columns,
        sampling=replace(
            sampling,
            channels=names,
            auxiliary=tuple(
                Auxiliary(name=name, unit=units.get(channel, sampling.unit))
                for name, channel in auxiliary.items()
            ),
            offsets_s=tuple(sampling.offsets_s[one] for one in columns) if sampling.offsets_s else (),
        ),
    )


def _outputs(sampling: Sampling, slot: Slot, names: tuple[str, ...], who: str) -> tuple[str, ...]:
    if slot.channels:
        lacking = [one for one in names if one not in slot.channels]
        if lacking:
            raise InstrumentError(
                f"{who}: the slot's 'channels' name none for axis {', '.join(lacking)}; it names"
                f" {', '.join(slot.channels)}"
            )
        return tuple(slot.channels[one] for one in names)
    if slot.channel is not None and len(names) == 1:
        return (slot.channel,)
    if len(names) == 1 and len(sampling.channels) == 1:
        return sampling.channels
    if set(names) <= set(sampling.channels):
        return names
    raise InstrumentError(
        f"{who}: gives {', '.join(sampling.channels)}, and the spec's output has"
        f" {'the axes ' + ', '.join(names) if len(names) > 1 else 'one axis'}; correct 'output.axes', or name"
        " the channels in the station's slot"
    )


def _auxiliary(sampling: Sampling, slot: Slot, who: str) -> dict[str, str]:
    known = {one.name for one in sampling.auxiliary}
    wanted = slot_auxiliary(slot)
    if not wanted:
        return {one.name: one.name for one in sampling.auxiliary}
    lacking = [one for one in wanted.values() if one not in (*known, *sampling.channels)]
    if lacking:
        raise InstrumentError(
            f"{who}: has no channel {', '.join(lacking)}, which the slot's 'auxiliary' or 'encoder' names; it"
            f" gives {', '.join(sampling.columns)}"
        )
    return wanted


def _place(sampling: Sampling, channel: str, who: str) -> int:
    if channel not in sampling.columns:
        raise InstrumentError(
            f"{who}: has no channel '{channel}'; it gives {', '.join(sampling.columns)};"
            " correct the slot's 'channel'"
        )
    return sampling.columns.index(channel)
