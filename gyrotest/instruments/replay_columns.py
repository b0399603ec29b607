"""Which columns of a file are played: the outputs, what is recorded beside them, and their units."""

from dataclasses import dataclass, replace

from gyrotest.instruments.replay_settings import AuxiliaryColumn, ReplaySettings
from gyrotest.recordings.formats.selection import Selection
from gyrotest.records.recording import Auxiliary, Sampling


@dataclass(frozen=True, slots=True, kw_only=True)
class PlayedColumns:
    """Names, units and factors: of the outputs, all in `unit`, then of the auxiliary columns.

    `offsets_s` as of a sampling. `selection` reads the columns in this order.
    """

    selection: Selection
    channels: tuple[str, ...]
    unit: str
    auxiliary: tuple[Auxiliary, ...]
    factors: tuple[float, ...]
    offsets_s: tuple[float, ...] = ()


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
        offsets_s=()
        if own is None or not own.offsets_s
        else tuple(own.offsets_s[place] for place in places if place is not None),
    )


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
