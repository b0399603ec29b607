"""Conformity: a result held against its limit by the rule that the spec fixed beforehand."""

import math
from collections.abc import Iterable
from dataclasses import dataclass, replace

from gyrotest.records.result import Contribution, JudgedLimit, JudgedResult, Measurand, Result, Verdict
from gyrotest.records.spec import DecisionRule, Limit
from gyrotest.units import Quantity, conversion_factor, printed_unit

_FROM_BEST = tuple(Verdict)
_MINUS = "\N{MINUS SIGN}"
_MOST_DIGITS = 12


@dataclass(frozen=True, slots=True, kw_only=True)
class _Span:
    """Where the true value lies: a value and the ends of its 95 % interval (None: not known)."""

    value: float
    lower: float | None
    upper: float | None


@dataclass(frozen=True, slots=True, kw_only=True)
class _Finding:
    verdict: Verdict
    reason: str = ""


def judge(
    measurand: Measurand,
    result: Result | None,
    limit: Limit | None,
    *,
    case: str,
    repeat: int | None,
    axis: str = "",
) -> JudgedResult:
    """Hold a result against its limit, in the limit's unit; a limit of None judges nothing.

    `axis` is the axis that the result belongs to (empty for a single-axis gyro). What is missing, not a
    number or infinite never passes: it is INCOMPLETE, with the reason.
    """
    unit = _unit(measurand, limit)
    applied = _applied(limit, unit)
    if result is None:
        judged = JudgedResult(
            case=case, repeat=repeat, name=measurand.name, label=measurand.label, value=None, unit=unit
        )
        reason = "not measured"
    else:
        judged, reason = _converted(result, unit, case, repeat)
    judged = replace(judged, axis=axis)
    if limit is None or applied is None:
        return replace(judged, reason=reason)
    finding = _Finding(verdict=Verdict.INCOMPLETE, reason=reason) if reason else _decide(judged, applied)
    return replace(judged, limit=applied, verdict=finding.verdict, reason=finding.reason)


def worst(verdicts: Iterable[Verdict]) -> Verdict:
    """Return the worst verdict; of none at all, INCOMPLETE."""
    return max(verdicts, key=_FROM_BEST.index, default=Verdict.INCOMPLETE)


def line(judged: JudgedResult) -> str:
    """Return a result with its limit in one line: `noise = 12.5 °/h [11.7, 13.6], limit ≤ 10 °/h`.

    Of a gyro with several axes: `noise (axis x) = …`.
    """
    name = f"{judged.name} (axis {judged.axis})" if judged.axis else judged.name
    if judged.value is None:
        return f"{name}: {judged.reason or 'not evaluated'}{_limit_text(judged.limit)}"
    sign = "≤" if judged.at_most else "≥" if judged.at_least else "="
    text = f"{name} {sign} {_value_text(judged)}{_limit_text(judged.limit)}"
    return f"{text} ({judged.reason})" if judged.reason else text


def _unit(measurand: Measurand, limit: Limit | None) -> str:
    ends = () if limit is None else (limit.max, limit.min)
    return next((end.unit for end in ends if end is not None), measurand.unit)


def _applied(limit: Limit | None, unit: str) -> JudgedLimit | None:
    if limit is None:
        return None
    return JudgedLimit(
        min=_end(limit.min, unit),
        max=_end(limit.max, unit),
        unit=unit,
        decision=limit.decision,
        over=limit.over,
    )


def _end(quantity: Quantity | None, unit: str) -> float | None:
    return None if quantity is None else quantity.to(unit)


def _converted(result: Result, unit: str, case: str, repeat: int | None) -> tuple[JudgedResult, str]:
    """Return the result in another unit, without what is not finite, and why it has no value if so."""
    factor = conversion_factor(result.unit, unit)
    numbers = {
        name: None if number is None else number * factor
        for name, number in (
            ("value", result.value),
            ("expanded_uncertainty", result.expanded_uncertainty),
            ("lower_95", result.lower_95),
            ("upper_95", result.upper_95),
        )
    }
    wrong = [
        name for name, number in numbers.items() if number is not None and not math.isfinite(number)
    ]
    reason = f"{', '.join(wrong).replace('_', ' ')} is not finite" if wrong else ""
    if result.value is None:
        reason = result.condition or "not evaluated"
    kept = {name: None if name in wrong else number for name, number in numbers.items()}
    judged = JudgedResult(
        case=case,
        repeat=repeat,
        name=result.name,
        label=result.label,
        unit=unit,
        coverage_factor=result.coverage_factor,
        at_most=result.at_most,
        at_least=result.at_least,
        condition=result.condition,
        value=kept["value"],
        expanded_uncertainty=kept["expanded_uncertainty"],
        lower_95=kept["lower_95"],
        upper_95=kept["upper_95"],
        budget=tuple(_scaled(one, factor) for one in result.budget),
        not_included=result.not_included,
    )
    return judged, reason


def _scaled(contribution: Contribution, factor: float) -> Contribution:
    return replace(contribution, standard_uncertainty=contribution.standard_uncertainty * factor)


def _decide(judged: JudgedResult, limit: JudgedLimit) -> _Finding:
    value = judged.value
    if value is None:
        return _Finding(verdict=Verdict.INCOMPLETE, reason="not evaluated")
    if limit.min is None and limit.max is None:
        return _Finding(
            verdict=Verdict.INCOMPLETE, reason="the limit has neither a minimum nor a maximum"
        )
    undecided = _undecided(judged, value, limit)
    if undecided:
        return _Finding(verdict=Verdict.INCOMPLETE, reason=undecided)
    if limit.decision is DecisionRule.SIMPLE:
        if _within(value, value, limit):
            return _Finding(verdict=Verdict.PASS)
        return _Finding(verdict=Verdict.FAIL, reason=_bound_words(judged, value, limit))
    return _guarded(_span(judged, value), limit, judged.not_included)


def _undecided(judged: JudgedResult, value: float, limit: JudgedLimit) -> str:
    """Say why a value that is only a bound tells nothing of a limit; empty where it does."""
    if judged.at_most and limit.min is not None:
        return "an upper bound cannot be held against a minimum"
    if judged.at_least and limit.max is not None and value <= limit.max:
        return "a lower bound cannot be held against a maximum"
    return ""


def _bound_words(judged: JudgedResult, value: float, limit: JudgedLimit) -> str:
    """Say that the true value may lie on the right side of the limit that its bound does not meet."""
    if judged.at_most:
        return "an upper bound; the record shows no lower one"
    if judged.at_least and limit.min is not None and value < limit.min:
        return "a lower bound; the record shows no upper one"
    return ""


def _span(judged: JudgedResult, value: float) -> _Span:
    lower, upper = judged.lower_95, judged.upper_95
    if judged.expanded_uncertainty is not None:
        lower, upper = value - judged.expanded_uncertainty, value + judged.expanded_uncertainty
    if judged.at_most:
        lower = -math.inf
    if judged.at_least:
        upper = math.inf
    return _Span(value=value, lower=lower, upper=upper)


def _guarded(span: _Span, limit: JudgedLimit, not_included: tuple[str, ...]) -> _Finding:
    """ILAC-G8:09/2019 4.2.2 (binary) and 4.2.3 (non-binary), the guard band being the uncertainty.

    Of an interval with one end only, that end decides what it can.
    """
    if not_included:
        reason = (
            f"a guarded decision needs the whole uncertainty; not included: {', '.join(not_included)}"
        )
        return _Finding(verdict=Verdict.INCOMPLETE, reason=reason)
    lower = -math.inf if span.lower is None else span.lower
    upper = math.inf if span.upper is None else span.upper
    open_end = (limit.min is not None and span.lower is None) or (
        limit.max is not None and span.upper is None
    )
    if open_end and not _apart(lower, upper, limit):
        return _Finding(verdict=Verdict.INCOMPLETE, reason="a guarded decision needs an uncertainty")
    return _Finding(verdict=_guarded_verdict(span.value, lower, upper, limit))


def _guarded_verdict(value: float, lower: float, upper: float, limit: JudgedLimit) -> Verdict:
    if _within(lower, upper, limit):
        return Verdict.PASS
    if limit.decision is DecisionRule.GUARDED or _apart(lower, upper, limit):
        return Verdict.FAIL
    return Verdict.CONDITIONAL_PASS if _within(value, value, limit) else Verdict.CONDITIONAL_FAIL


def _within(lower: float, upper: float, limit: JudgedLimit) -> bool:
    return (limit.min is None or lower >= limit.min) and (limit.max is None or upper <= limit.max)


def _apart(lower: float, upper: float, limit: JudgedLimit) -> bool:
    """Whether no value between lower and upper is inside the limit."""
    return (limit.min is not None and upper < limit.min) or (limit.max is not None and lower > limit.max)


def _value_text(judged: JudgedResult) -> str:
    """Round value and uncertainty alike, finely enough to show on which side of a limit the value is."""
    value = judged.value or 0.0
    limit = judged.limit
    ends = [end for end in (limit.min, limit.max) if end is not None] if limit else []
    fewest = _digits_down_to(judged.expanded_uncertainty, value) if judged.expanded_uncertainty else 3
    digits = next(
        (d for d in range(fewest, _MOST_DIGITS) if all(_same_side(value, end, d) for end in ends)),
        _MOST_DIGITS,
    )
    unit = printed_unit(judged.unit)
    text = _number(value, digits)
    if judged.expanded_uncertainty is not None:
        return f"{text} ± {_number(judged.expanded_uncertainty, 2)} {unit}"
    if judged.lower_95 is not None and judged.upper_95 is not None:
        return f"{text} {unit} [{_number(judged.lower_95, digits)}, {_number(judged.upper_95, digits)}]"
    return f"{text} {unit}"


def _digits_down_to(uncertainty: float, value: float) -> int:
    """Return the significant digits that end a value where two digits of its uncertainty end."""
    rounded = abs(float(f"{value:.2g}")) or uncertainty
    places = math.floor(math.log10(rounded)) - math.floor(math.log10(float(f"{uncertainty:.2g}")))
    return min(max(places + 2, 1), _MOST_DIGITS)


def _same_side(value: float, end: float, digits: int) -> bool:
    rounded = float(f"{value:.{digits}g}")
    return (rounded > end) == (value > end) and (rounded < end) == (value < end)


def _number(value: float, digits: int) -> str:
    text = f"{value:.{digits}g}"
    if "e" in text and 1e-4 <= abs(value) < 1e7:
        text = f"{float(text):.0f}"
    return text.replace("-", _MINUS)


def _limit_text(limit: JudgedLimit | None) -> str:
    if limit is None:
        return ""
    unit = printed_unit(limit.unit)
    if limit.min is not None and limit.max is not None:
        ends = f"{_number(limit.min, 10)} … {_number(limit.max, 10)}"
    elif limit.max is not None:
        ends = f"≤ {_number(limit.max, 10)}"
    else:
        ends = f"≥ {_number(limit.min or 0.0, 10)}"
    rule = (
        "" if limit.decision is DecisionRule.SIMPLE else f" ({limit.decision.value.replace('_', ' ')})"
    )
    return f", limit {ends} {unit}{rule}".replace(" %", " %")
