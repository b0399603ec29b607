"""Which channels of a synchronous source are wanted, and what their numbers mean."""

import difflib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from gyrotest.errors import InstrumentError, InstrumentProtocolError, UnitError
from gyrotest.records.bench import DaqChannel
from gyrotest.records.recording import Auxiliary, Sampling
from gyrotest.units import Dimension, conversion_factor, same_dimension

_OUTPUTS = (Dimension.VOLTAGE, Dimension.RATE, Dimension.COUNT)


@dataclass(frozen=True, slots=True, kw_only=True)
class Choice:
    """Channels in the order of their columns, the first `outputs` of them the gyros' own.

    `units` are those that are given out, `factors` what turns transferred numbers into them, one a column.
    """

    channels: tuple[DaqChannel, ...]
    outputs: int
    units: tuple[str, ...]
    factors: tuple[float, ...]

    @property
    def names(self) -> tuple[str, ...]:
        """The columns' names."""
        return tuple(one.name for one in self.channels)

    def sampling(
        self,
        interval_s: float,
        *,
        skew_s: Mapping[str, float],
        skew_uncertainty_s: float | None,
        filter_hz: float | None,
        full_scale: float,
        noise: float | None,
    ) -> Sampling:
        """How they are sampled; `skew_s` goes before what the source says, `full_scale` is the first one's.

        The samples follow one another without a pause, which is what an aperture as long as the interval says.
        """
        later_s = [skew_s.get(one.name, one.skew_s) for one in self.channels]
        return Sampling(
            interval_s=interval_s,
            aperture_s=interval_s,
            unit=self.units[0],
            channels=self.names[: self.outputs],
            auxiliary=tuple(
                Auxiliary(name=name, unit=unit)
                for name, unit in zip(
                    self.names[self.outputs :], self.units[self.outputs :], strict=True
                )
            ),
            offsets_s=tuple(one - later_s[0] for one in later_s),
            noise=noise,
            range=full_scale * conversion_factor(self.channels[0].unit, self.units[0]),
            synchronous=True,
            skew_uncertainty_s=skew_uncertainty_s,
            filter_hz=filter_hz,
        )


def choose(
    who: str, there: Sequence[DaqChannel], outputs: tuple[str, ...], auxiliary: tuple[str, ...]
) -> Choice:
    """Find the channels that are wanted; with no output named, all that are not auxiliary are outputs.

    Raises `InstrumentError` for a name that is not there, and for outputs that are not of one kind.
    """
    known = {one.name: one for one in there}
    own = tuple(dict.fromkeys(outputs or (name for name in known if name not in auxiliary)))
    beside = tuple(name for name in dict.fromkeys(auxiliary) if name not in own)
    refuse_unknown(who, "the slot", (*own, *beside), known)
    if not own:
        raise InstrumentError(f"{who}: no channel is left for the gyro; it has {', '.join(known)}")
    channels = tuple(known[name] for name in (*own, *beside))
    units = tuple(_unit_out(who, one) for one in channels)
    _refuse_mixed(who, channels[: len(own)], units)
    return Choice(
        channels=channels,
        outputs=len(own),
        units=units,
        factors=tuple(
            one.scale * conversion_factor(one.unit, unit)
            for one, unit in zip(channels, units, strict=True)
        ),
    )


def refuse_unknown(who: str, where: str, names: Sequence[str], known: Mapping[str, DaqChannel]) -> None:
    """Refuse a channel that is not there, with all that are; raises `InstrumentError`."""
    for name in names:
        if name not in known:
            near = difflib.get_close_matches(name, known, n=1)
            meant = f"; did you mean '{near[0]}'?" if near else ""
            raise InstrumentError(
                f"{who}: has no channel '{name}', which {where} names; it has {', '.join(known)}{meant}"
            )


def _unit_out(who: str, channel: DaqChannel) -> str:
    """The unit that gyrotest computes in, of the channel's kind."""
    try:
        kind = next((one for one in Dimension if same_dimension(channel.unit, one.value)), None)
    except UnitError as error:
        raise InstrumentProtocolError(f"{who}: channel '{channel.name}': {error}") from error
    return channel.unit if kind is None else kind.value


def _refuse_mixed(who: str, outputs: Sequence[DaqChannel], units: Sequence[str]) -> None:
    for one, unit in zip(outputs, units, strict=False):
        if unit not in _OUTPUTS:
            raise InstrumentError(
                f"{who}: channel '{one.name}' is in {one.unit}, and a gyro's output is a voltage, a rate or a"
                " count; name the gyro's channel in the slot's 'channel'"
            )
        if unit != units[0]:
            raise InstrumentError(
                f"{who}: '{outputs[0].name}' is in {outputs[0].unit} and '{one.name}' in {one.unit};"
                " outputs are of one kind: name them in the slot's 'channel' or 'channels'"
            )
