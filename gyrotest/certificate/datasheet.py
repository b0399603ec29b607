"""The datasheet's figures beside what was measured, each axis in a column; nothing here is judged."""

from collections.abc import Iterator, Mapping, Sequence
from itertools import groupby

from gyrotest.certificate.numbers import bounded, plain, significant
from gyrotest.certificate.order import in_order
from gyrotest.certificate.procedure_table import TableView
from gyrotest.certificate.rows import ABSENT, repeat_words, row
from gyrotest.errors import UnitError
from gyrotest.records.result import JudgedResult
from gyrotest.records.run import RunRecord
from gyrotest.records.table import Column
from gyrotest.units import Quantity, printed_unit

_ABREAST = 3  # axes beside one another
_DIGITS = 3


def datasheet_tables(record: RunRecord) -> tuple[TableView, ...]:
    """Return what was measured of the datasheet's figures; nothing where it gives none."""
    stated = record.header.spec.spec.datasheet
    found = [one for one in in_order(record) if one.name in stated and _alike(one, stated[one.name])]
    axes = list(dict.fromkeys(one.axis for one in found))
    return tuple(
        _table([one for one in found if one.axis in abreast], abreast, stated)
        for abreast in (axes[n : n + _ABREAST] for n in range(0, len(axes), _ABREAST))
    )


def _alike(result: JudgedResult, figure: Quantity) -> bool:
    """Whether they are of one kind; a figure of another is no ground to have no certificate."""
    try:
        figure.to(result.unit)
    except UnitError:
        return False
    return True


def _table(
    results: Sequence[JudgedResult], axes: Sequence[str], stated: Mapping[str, Quantity]
) -> TableView:
    repeated = any((one.repeat or 1) > 1 for one in results)
    several = len({one.case for one in results}) > 1
    columns = [Column(heading="Parameter", share=22)]
    columns += [Column(heading="Rep.", share=7)] * repeated
    columns += [Column(heading="Datasheet", share=10, numbers=True), Column(heading="Unit", share=8.5)]
    for axis in axes:
        name = f"Axis {axis}" if axis else "Measured, U or 95 % interval"
        columns += [Column(heading=name, share=22), Column(heading="Ratio", share=8, numbers=True)]
    return TableView(
        title="Measured against the datasheet",
        note="measured with U or 95 % interval; ratio: measured to datasheet; not judged",
        columns=tuple(columns),
        rows=tuple(_rows(results, axes, stated, repeated=repeated, several=several)),
        sentences=(),
    )


def _rows(
    results: Sequence[JudgedResult],
    axes: Sequence[str],
    stated: Mapping[str, Quantity],
    *,
    repeated: bool,
    several: bool,
) -> Iterator[tuple[str, ...]]:
    """One row for each repeat of what was measured; the axes came one after another."""
    for (case, name, unit), same in groupby(results, key=lambda one: (one.case, one.name, one.unit)):
        of_repeat: dict[str, dict[str, JudgedResult]] = {}
        for one in same:
            of_repeat.setdefault(repeat_words(one), {})[one.axis] = one
        figure = stated[name].to(unit)
        for number, (repeat, found) in enumerate(of_repeat.items()):
            label = next(iter(found.values())).label
            first = number == 0
            yield (
                (f"{label} ({case})" if several else label) if first else "",
                *([repeat] if repeated else []),
                plain(figure) if first else "",
                printed_unit(unit) if first else "",
                *(text for axis in axes for text in _measured(found.get(axis), figure)),
            )


def _measured(result: JudgedResult | None, figure: float) -> tuple[str, str]:
    """A value with what surrounds it, and its ratio to the datasheet's figure."""
    if result is None or result.value is None:
        return ABSENT, ABSENT
    shown = row(result)
    measured = " ".join(part for part in (shown.value, shown.spread) if part)
    if figure == 0.0:
        return measured, ABSENT
    ratio = significant(result.value / figure, digits=_DIGITS)
    return measured, bounded(ratio, at_most=result.at_most, at_least=result.at_least)
