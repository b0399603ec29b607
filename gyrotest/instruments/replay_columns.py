"""Which columns of a file are played: the outputs, what is recorded beside them, their units and instants."""

import difflib
from collections.abc import Sequence
from dataclasses import dataclass, replace

from gyrotest.instruments.replay_settings import AuxiliaryColumn, ReplaySettings
from gyrotest.recordings.formats.selection import Selection
from gyrotest.recordings.stamps import Stamps
from gyrotest.records.bench import DaqChannel
from gyrotest.records.recording import Auxiliary, Sampling
from gyrotest.units import Dimension

# Rows whose stamps scatter by no more than this part of their interval come at a uniform rate.
_UNIFORM = 0.05


@dataclass(frozen=True, slots=True, kw_only=True)
class PlayedColumns:
    """Names, units and factors: of the outputs, all in `unit`, then of the auxiliary columns.

    `offsets_s` as of a sampling. `selection` reads the columns in this order. `one_instant`: there are
    several, and each row is one instant of them all but for the offsets.
    """

    selection: Selection
    channels: tuple[str, ...]
    unit: str
    auxiliary: tuple[Auxiliary, ...]
    factors: tuple[float, ...]
    offsets_s: tuple[float, ...] = ()
    one_instant: bool = False

    @property
    def names(self) -> tuple[str, ...]:
        """All columns by the names under which they play."""
        return (*self.channels, *(one.name for one in self.auxiliary))

    @property
    def angles(self) -> tuple[str, ...]:
        """Those that are angles, of which no mean can be taken: they may pass 360°."""
        return tuple(one.name for one in self.auxiliary if one.unit == Dimension.ANGLE)

    def as_channels(self) -> tuple[DaqChannel, ...]:
        """The columns as channels of a synchronous source."""
        units = (*(self.unit for _ in self.channels), *(one.unit for one in self.auxiliary))
        offsets_s = self.offsets_s or (0.0,) * len(units)
        return tuple(
            DaqChannel(name=name, unit=unit, scale=factor, skew_s=offset_s)
            for name, unit, factor, offset_s in zip(
                self.names, units, self.factors, offsets_s, strict=True
            )
        )

    def complaint(self, wanted: Sequence[str]) -> str | None:
        """What is wrong with the names that a slot wants; None where all are played."""
        for name in wanted:
            if name not in self.names:
                near = difflib.get_close_matches(name, self.names, n=1)
                meant = f"; did you mean '{near[0]}'?" if near else ""
                return (
                    f"plays no column under the name '{name}', which the slot or 'skew' has; it plays"
                    f" {', '.join(self.names)}{meant}"
                )
        return None


def uniform(stamps: Stamps | None) -> bool:
    """Whether a file's rows come at a uniform rate: without time stamps it is stated."""
    return stamps is None or stamps.jitter_rms_s <= _UNIFORM * stamps.interval_s


def played_columns(settings: ReplaySettings, own: Sampling | None) -> PlayedColumns:
    """Settle what is played; `own` is how one of our own recordings was sampled.

    Of such a recording all columns are played where none is chosen. Raises `UnitError`.
    """
    whole = settings if own is None else _completed(settings, own)
    selection = whole.selection()
    wanted = (selection.column, *selection.beside)
    places = [_place(one, own) for one in wanted]
    units = [_own_unit(place, own) for place in places]
    channels = tuple(whole.columns) or ("output",)
    beside = list(zip(whole.auxiliary.items(), units[len(channels) :], strict=True))
    return PlayedColumns(
        selection=selection,
        channels=channels,
        unit=whole.unit_out(units[0]),
        auxiliary=tuple(
            Auxiliary(name=name, unit=column.unit_out(unit)) for (name, column), unit in beside
        ),
        factors=(
            *(whole.factor(unit) for unit in units[: len(channels)]),
            *(column.factor(unit) for (_, column), unit in beside),
        ),
        offsets_s=_offsets_s(settings, (*channels, *whole.auxiliary), places, own),
        one_instant=len(wanted) > 1 if own is None else own.synchronous,
    )


def _offsets_s(
    settings: ReplaySettings,
    names: Sequence[str],
    places: Sequence[int | None],
    own: Sampling | None,
) -> tuple[float, ...]:
    """How much later than the row's instant each was sampled; the settings go before the recording."""
    recorded = own.offsets_s if own is not None else ()
    if not recorded and not settings.skew:
        return ()
    known_s = [recorded[one] if recorded and one is not None else 0.0 for one in places]
    stated = {name: one.to("s") for name, one in settings.skew.items()}
    return tuple(stated.get(name, one) for name, one in zip(names, known_s, strict=True))


def _completed(settings: ReplaySettings, own: Sampling) -> ReplaySettings:
    """Take all columns of a recording of ours where none is chosen."""
    if settings.column is not None or settings.columns:
        return settings
    beside = {one.name: AuxiliaryColumn(column=one.name) for one in own.auxiliary}
    outputs = {name: name for name in own.channels}
    return replace(settings, columns=outputs, auxiliary={**beside, **settings.auxiliary})


def _place(column: str | int | None, own: Sampling | None) -> int | None:
    """Return a column's place in a recording of ours; None where it is not one, or has no such column."""
    if own is None or column is None:
        return None if own is None or len(own.columns) != 1 else 0
    if isinstance(column, int):
        return column - 1 if 1 <= column <= len(own.columns) else None
    return own.columns.index(column) if column in own.columns else None


def _own_unit(place: int | None, own: Sampling | None) -> str | None:
    if own is None or place is None:
        return None
    outputs = len(own.channels)
    return own.unit if place < outputs else own.auxiliary[place - outputs].unit
