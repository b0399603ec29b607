"""What is printed of a single value."""

from dataclasses import dataclass

from gyrotest.certificate.gauge import Gauge, gauge
from gyrotest.certificate.looks import LOOKS, Look
from gyrotest.certificate.numbers import bounded, plain, printed
from gyrotest.records.result import JudgedResult
from gyrotest.units import printed_unit

ABSENT = "–"


@dataclass(frozen=True, slots=True, kw_only=True)
class Row:
    """One value: of a repeat, or over all of them; `condition` where it has one of its own."""

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


def row(result: JudgedResult, condition: str = "") -> Row:
    """Round a result for print, with its uncertainty and on its side of the limits."""
    look = LOOKS[result.verdict] if result.verdict else None
    if result.value is None:
        return _empty_row(result, look, condition)
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
        repeat=repeat_words(result),
        condition=condition,
        value=bounded(shown.value, at_most=result.at_most, at_least=result.at_least),
        spread=spread,
        factor=f"k = {factor:.2f}" if factor is not None and shown.uncertainty else "",
        gauge=gauge(result, look.colour if look else "#4b5563"),
        look=look,
        reason=result.reason,
    )


def outcome(result: JudgedResult) -> str:
    """A result in one line, with what surrounds it, its unit and its limit."""
    axis = f", axis {result.axis}" if result.axis else ""
    repeat = "" if result.repeat is None else f", repeat {result.repeat}"
    name, shown = f"{result.label}{axis}{repeat}", row(result)
    if result.value is None:
        return f"{name}: {result.reason or result.condition or shown.reason}"
    found = " ".join(part for part in (shown.value, shown.spread) if part)
    return f"{name}: {found} {printed_unit(result.unit)}, limit {_limit_words(result)}"


def repeat_words(result: JudgedResult) -> str:
    """Which repeat it is, or that it is over all of them."""
    return "all" if result.repeat is None else str(result.repeat)


def _empty_row(result: JudgedResult, look: Look | None, condition: str) -> Row:
    return Row(
        repeat=repeat_words(result),
        condition=condition,
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
