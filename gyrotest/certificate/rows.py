"""The table of results: what is printed of each value, grouped by case and by what was measured."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import groupby

from gyrotest.certificate.gauge import Gauge, gauge
from gyrotest.certificate.numbers import plain, printed
from gyrotest.records.result import JudgedResult, Verdict
from gyrotest.records.run import RunRecord
from gyrotest.records.spec import DecisionRule
from gyrotest.units import printed_unit

ABSENT = "–"
INFO = "info"
_TALL = 8  # repeats from which on a parameter's name stands above its rows, which may break


@dataclass(frozen=True, slots=True, kw_only=True)
class Look:
    """How a verdict is shown: it must also be told apart in grey."""

    symbol: str
    word: str
    short: str
    style: str
    colour: str


LOOKS = {
    Verdict.PASS: Look(symbol="✓", word="PASS", short="PASS", style="pass", colour="#14602f"),
    Verdict.CONDITIONAL_PASS: Look(
        symbol="(✓)", word="CONDITIONAL PASS", short="COND. PASS", style="conditional", colour="#7a5200"
    ),
    Verdict.CONDITIONAL_FAIL: Look(
        symbol="(✗)", word="CONDITIONAL FAIL", short="COND. FAIL", style="conditional", colour="#a04000"
    ),
    Verdict.FAIL: Look(symbol="✗", word="FAIL", short="FAIL", style="fail", colour="#a31515"),
    Verdict.INCOMPLETE: Look(
        symbol="⚠", word="INCOMPLETE", short="INCOMPLETE", style="incomplete", colour="#7a3e00"
    ),
}


@dataclass(frozen=True, slots=True, kw_only=True)
class Row:
    """One value: of a repeat, or over all of them."""

    repeat: str
    condition: str
    value: str
    spread: str
    factor: str
    gauge: Gauge | None
    look: Look | None
    reason: str

    @property
    def telling(self) -> bool:
        """Whether its limits are printed once more, beside it."""
        return self.look is not None and self.look.style != "pass"


@dataclass(frozen=True, slots=True, kw_only=True)
class Group:
    """What one measurement gave in all repeats; limits and unit are common to them."""

    label: str
    condition: str
    lower: str
    upper: str
    unit: str
    rows: tuple[Row, ...]

    @property
    def tall(self) -> bool:
        """Whether there are too many rows to keep them on one page."""
        return len(self.rows) > _TALL


@dataclass(frozen=True, slots=True, kw_only=True)
class CaseTable:
    """The results of one case."""

    case: str
    note: str
    repeated: bool
    groups: tuple[Group, ...]


def case_tables(record: RunRecord) -> tuple[CaseTable, ...]:
    """Arrange the results: cases in their order, in each the measurements, in each the repeats."""
    cases = dict.fromkeys(result.case for result in record.results)
    return tuple(_case_table(record, case) for case in cases)


def outcome(result: JudgedResult) -> str:
    """A result in one line, with what surrounds it, its unit and its limit."""
    which = "" if result.repeat is None else f", repeat {result.repeat}"
    row = _row(result)
    if result.value is None:
        return f"{result.label}{which}: {result.reason or result.condition or row.reason}"
    found = " ".join(part for part in (row.value, row.spread) if part)
    return f"{result.label}{which}: {found} {printed_unit(result.unit)}, limit {_limit_words(result)}"


def _case_table(record: RunRecord, case: str) -> CaseTable:
    results = [result for result in record.results if result.case == case]
    return CaseTable(
        case=case,
        note=_case_note(record, case),
        repeated=any((result.repeat or 1) > 1 for result in results),
        groups=tuple(_groups(results)),
    )


def _groups(results: Sequence[JudgedResult]) -> Iterator[Group]:
    names = list(dict.fromkeys(result.name for result in results))
    ordered = sorted(
        results, key=lambda one: (names.index(one.name), one.repeat is None, one.repeat or 0)
    )
    for _, same in groupby(ordered, key=lambda one: (one.name, one.unit, one.limit)):
        yield _group(list(same))


def _group(results: list[JudgedResult]) -> Group:
    first = results[0]
    conditions = [_condition(results)]
    if first.limit and first.limit.decision is not DecisionRule.SIMPLE:
        conditions.append(RULE_WORDS[first.limit.decision])
    return Group(
        label=first.label,
        condition="; ".join(part for part in conditions if part),
        lower=ABSENT if first.limit is None or first.limit.min is None else plain(first.limit.min),
        upper=ABSENT if first.limit is None or first.limit.max is None else plain(first.limit.max),
        unit=printed_unit(first.unit),
        rows=tuple(_row(result) for result in results),
    )


def _condition(results: list[JudgedResult]) -> str:
    """What holds for all repeats, then what holds for each."""
    parts = [result.condition.split("; ") if result.condition else [] for result in results]
    common = [part for part in parts[0] if all(part in others for others in parts)]
    own = ["; ".join(part for part in given if part not in common) for given in parts]
    if len(results) > _TALL:
        own = []  # stands in each row
    told = [f"{_repeat(result)}: {text}" for result, text in zip(results, own, strict=False) if text]
    return "; ".join((*common, *told))


def _repeat(result: JudgedResult) -> str:
    return "all" if result.repeat is None else str(result.repeat)


RULE_WORDS = {
    DecisionRule.SIMPLE: "simple acceptance",
    DecisionRule.GUARDED: "guarded acceptance",
    DecisionRule.GUARDED_NONBINARY: "guarded acceptance with conditional verdicts",
}


def _row(result: JudgedResult) -> Row:
    look = LOOKS[result.verdict] if result.verdict else None
    if result.value is None:
        return _empty_row(result, look)
    shown = printed(
        result.value,
        uncertainty=result.expanded_uncertainty,
        lower=result.lower_95,
        upper=result.upper_95,
        limits=_limits(result),
    )
    spread = f"± {shown.uncertainty}" if shown.uncertainty else ""
    if not spread and (shown.lower or shown.upper):
        spread = f"[{shown.lower or ABSENT}, {shown.upper or ABSENT}]"
    factor = result.coverage_factor
    return Row(
        repeat=_repeat(result),
        condition=result.condition,
        value=f"≤ {shown.value}" if result.at_most else shown.value,
        spread=spread,
        factor=f"k = {factor:.2f}" if factor is not None and shown.uncertainty else "",
        gauge=gauge(result, look.colour if look else "#4b5563"),
        look=look,
        reason=result.reason,
    )


def _empty_row(result: JudgedResult, look: Look | None) -> Row:
    return Row(
        repeat=_repeat(result),
        condition=result.condition,
        value=ABSENT,
        spread="",
        factor="",
        gauge=None,
        look=look,
        reason=result.reason if result.reason != result.condition else "not evaluated",
    )


def _limits(result: JudgedResult) -> tuple[float, ...]:
    if result.limit is None:
        return ()
    return tuple(one for one in (result.limit.min, result.limit.max) if one is not None)


def _limit_words(result: JudgedResult) -> str:
    limit = result.limit
    if limit is None or (limit.min is None and limit.max is None):
        return "none"
    unit = printed_unit(limit.unit)
    if limit.min is None:
        return f"≤ {plain(limit.max or 0.0)} {unit}"
    if limit.max is None:
        return f"≥ {plain(limit.min)} {unit}"
    return f"{plain(limit.min)} … {plain(limit.max)} {unit}"


def _case_note(record: RunRecord, case: str) -> str:
    planned = record.header.spec.spec.cases.get(case)
    if planned is None:
        return ""
    repeats = f"{planned.repeats} × " if planned.repeats > 1 else ""
    parts = [planned.procedure, f"{repeats}{planned.duration}", f"one sample every {planned.interval}"]
    if planned.warm_up is not None:
        parts.append(f"after {planned.warm_up} of warm-up")
    return ", ".join(parts)
