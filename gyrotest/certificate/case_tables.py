"""The tables of results: grouped by case, by what was measured, by axis."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import groupby

from gyrotest.certificate.looks import RULE_WORDS
from gyrotest.certificate.numbers import plain
from gyrotest.certificate.order import in_order
from gyrotest.certificate.rows import ABSENT, Row, repeat_words, row
from gyrotest.records.result import JudgedResult
from gyrotest.records.run import RunRecord
from gyrotest.records.spec import Case, DecisionRule
from gyrotest.units import printed_unit

_TALL = 9  # rows beyond which a parameter's name stands above them, and they may break between axes
# Shares of the columns' widths.
_REPEAT = 5.0
_AXIS, _AXIS_LETTER, _AXIS_LONGEST = 5.0, 1.0, 16.0
_BARE = (29.0, 11.0, 17.0, 8.0, 8.0, 8.5, 16.0, 12.0)
_SHARED = (9.6, 15.8, 7.5, 7.5, 8.5, 15.5, 12.5)
_WHOLE = 107.0


@dataclass(frozen=True, slots=True, kw_only=True)
class Block:
    """What one measurement gave for an axis (empty: there is but one) in all repeats."""

    axis: str
    rows: tuple[Row, ...]

    @property
    def tall(self) -> bool:
        """Whether there are too many rows to keep them on one page."""
        return len(self.rows) > _TALL


@dataclass(frozen=True, slots=True, kw_only=True)
class Group:
    """What one measurement gave for all axes and repeats; limits and unit are common to them."""

    label: str
    condition: str
    lower: str
    upper: str
    unit: str
    blocks: tuple[Block, ...]

    @property
    def rows(self) -> tuple[Row, ...]:
        """The rows of all axes."""
        return tuple(one for block in self.blocks for one in block.rows)

    @property
    def tall(self) -> bool:
        """Whether there are too many rows to keep them on one page."""
        return len(self.rows) > _TALL


@dataclass(frozen=True, slots=True, kw_only=True)
class CaseTable:
    """The results of one case; `shares` are its columns' widths."""

    case: str
    note: str
    axial: bool
    repeated: bool
    shares: tuple[float, ...]
    groups: tuple[Group, ...]


def case_tables(record: RunRecord) -> tuple[CaseTable, ...]:
    """Arrange the results: cases, in each the measurements, in each the axes, in each the repeats."""
    return tuple(
        _case_table(record, case, list(results))
        for case, results in groupby(in_order(record), key=lambda one: one.case)
    )


def _case_table(record: RunRecord, case: str, results: list[JudgedResult]) -> CaseTable:
    axial = any(one.axis for one in results)
    repeated = any((one.repeat or 1) > 1 for one in results)
    same = groupby(results, key=lambda one: (one.name, one.unit, one.limit))
    return CaseTable(
        case=case,
        note=_case_note(record, case),
        axial=axial,
        repeated=repeated,
        shares=_shares([one.axis for one in results], repeated=repeated),
        groups=tuple(_group(list(group), repeated=repeated) for _, group in same),
    )


def _shares(axes: Sequence[str], *, repeated: bool) -> tuple[float, ...]:
    """Return the columns' widths: what axes' names and repeats need is taken from the parameters' names."""
    longest = max((len(one) for one in axes), default=0)
    named = [min(max(_AXIS, 2 + _AXIS_LETTER * longest), _AXIS_LONGEST)] if longest else []
    between = [*named, *([_REPEAT] if repeated else [])]
    if not between:
        return _BARE
    return (_WHOLE - sum(between) - sum(_SHARED), *between, *_SHARED)


def _group(results: list[JudgedResult], *, repeated: bool) -> Group:
    first = results[0]
    common, own = _conditions(results)
    in_rows = len(results) > _TALL
    told = [] if in_rows else list(_told(results, own, repeated=repeated))
    guarded = first.limit is not None and first.limit.decision is not DecisionRule.SIMPLE
    rule = [RULE_WORDS[first.limit.decision]] if first.limit and guarded else []
    rows = [row(one, text if in_rows else "") for one, text in zip(results, own, strict=True)]
    return Group(
        label=first.label,
        condition="; ".join((*common, *told, *rule)),
        lower=ABSENT if first.limit is None or first.limit.min is None else plain(first.limit.min),
        upper=ABSENT if first.limit is None or first.limit.max is None else plain(first.limit.max),
        unit=printed_unit(first.unit),
        blocks=tuple(_blocks(results, rows)),
    )


def _blocks(results: Sequence[JudgedResult], rows: Sequence[Row]) -> Iterator[Block]:
    pairs = zip(results, rows, strict=True)
    for axis, same in groupby(pairs, key=lambda pair: pair[0].axis):
        yield Block(axis=axis, rows=tuple(one for _, one in same))


def _conditions(results: Sequence[JudgedResult]) -> tuple[list[str], list[str]]:
    """What holds for all rows, then what holds for each."""
    parts = [result.condition.split("; ") if result.condition else [] for result in results]
    common = [part for part in parts[0] if all(part in others for others in parts)]
    return common, ["; ".join(part for part in given if part not in common) for given in parts]


def _told(results: Sequence[JudgedResult], own: Sequence[str], *, repeated: bool) -> Iterator[str]:
    """Each row's own condition behind its name; what an axis's repeats share is said once."""
    for axis, same in groupby(zip(results, own, strict=True), key=lambda pair: pair[0].axis):
        pairs = [(repeat_words(result), text) for result, text in same]
        texts = {text for _, text in pairs}
        if axis and (not repeated or len(texts) == 1):
            pairs = [("", pairs[0][1])]
        for repeat, text in pairs:
            if text:
                yield f"{' '.join(part for part in (axis, repeat) if part)}: {text}"


def _case_note(record: RunRecord, case: str) -> str:
    planned = record.header.spec.spec.cases.get(case)
    if planned is None:
        return ""
    repeats = f"{planned.repeats} × " if planned.repeats > 1 else ""
    acquired = f"{repeats}{_steps(record, case, planned)}"
    parts = [planned.procedure, acquired, f"one sample every {planned.interval}"]
    if planned.warm_up is not None:
        parts.append(f"after {planned.warm_up} of warm-up")
    return ", ".join(parts)


def _steps(record: RunRecord, case: str, planned: Case) -> str:
    """How long a repeat was, or in how many steps."""
    lasts = (item.last for item in record.items if item.plan.case == case)
    dwells = next((one.recording.dwells for one in lasts if one and one.recording), ())
    if len(dwells) < 2:
        return str(planned.duration)
    each = round(planned.duration.to("s") / planned.interval.to("s"))
    uniform = all(one.samples == each for one in dwells)
    return f"{len(dwells)} steps of {planned.duration}" if uniform else f"{len(dwells)} steps"
