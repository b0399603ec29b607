"""The sentences of a certificate: what conforms, by which rule, with which uncertainty, and what deviates."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass

from gyrotest.certificate.equipment import instruments_used, is_unit
from gyrotest.certificate.looks import LOOKS, RULE_WORDS
from gyrotest.certificate.order import in_order
from gyrotest.certificate.printing import numbers_in_words
from gyrotest.certificate.rows import outcome
from gyrotest.records.result import JudgedResult, Verdict
from gyrotest.records.run import Attempt, ItemRecord, PlannedItem, RunRecord
from gyrotest.records.spec import DecisionRule

_NAMED = 8
_RULES = {
    DecisionRule.SIMPLE: "Simple acceptance (ILAC-G8:09/2019 4.2.1): PASS when the measured value lies within "
    "the limits; for a value at a limit the probability of a false accept is up to 50 %.",
    DecisionRule.GUARDED: "Guarded acceptance (ILAC-G8:09/2019 4.2.2, w = U): PASS when the whole interval of "
    "uncertainty lies within the limits; the probability of a false accept is below 2.5 % for each limit.",
    DecisionRule.GUARDED_NONBINARY: "Guarded acceptance with conditional verdicts (ILAC-G8:09/2019 4.2.3, "
    "w = U): PASS when the whole interval of uncertainty lies within the limits, CONDITIONAL PASS when only "
    "the value does, CONDITIONAL FAIL when only a part of the interval does, FAIL otherwise.",
}
_CONFORMITY = {
    Verdict.PASS: "All results with limits are within their acceptance limits.",
    Verdict.CONDITIONAL_PASS: "All values lie within their limits, but results marked CONDITIONAL PASS not by "
    "more than their uncertainty.",
    Verdict.CONDITIONAL_FAIL: "Results marked CONDITIONAL FAIL lie outside their limits by less than their "
    "uncertainty. The unit does not conform.",
    Verdict.FAIL: "Results marked FAIL do not meet their acceptance limits. The unit does not conform.",
    Verdict.INCOMPLETE: "The test is not complete: no statement of conformity is made. Verdicts on single "
    "results hold for these alone.",
}
_HEADINGS = {
    Verdict.FAIL: "Not conforming:",
    Verdict.CONDITIONAL_FAIL: "Outside by less than the uncertainty:",
    Verdict.CONDITIONAL_PASS: "Inside by less than the uncertainty:",
    Verdict.INCOMPLETE: "Not judged:",
}


def judged(record: RunRecord) -> list[JudgedResult]:
    """Return the results that a limit was held against."""
    return [result for result in record.results if result.limit is not None]


def tally(record: RunRecord) -> str:
    """How many limits were met."""
    held = judged(record)
    met = sum(result.verdict is Verdict.PASS for result in held)
    text = f"{met} of {len(held)} limits met" if held else "no limit judged"
    missing = sum(bool(one.missing) for one in record.items) or len(record.missing)
    return f"{text} · {_items(missing)} missing" if missing else text


def rule_names(record: RunRecord) -> str:
    """The decision rules in a few words, for the verdict's block."""
    rules = _rules(record)
    names = ", ".join(RULE_WORDS[rule] for rule in rules)
    return f"rule{'s' * (len(rules) > 1)}: {names}" if rules else "no decision rule applied"


@dataclass(frozen=True, slots=True, kw_only=True)
class Banner:
    """What must not be overlooked."""

    style: str
    heading: str
    text: str


def banners(record: RunRecord) -> Iterator[Banner]:
    """Name what the certificate replaces, what does not conform and what is missing."""
    if record.amends:
        text = f"this certificate replaces {record.amends}."
        yield Banner(style="amended", heading="Amended:", text=text)
    for verdict, heading in _HEADINGS.items():
        found = [outcome(one) for one in in_order(record) if one.verdict is verdict]
        if found:
            yield Banner(style=LOOKS[verdict].style, heading=heading, text=_listed(found))
    unjudged = any(one.verdict is Verdict.INCOMPLETE for one in record.results)
    if record.missing or (record.verdict is Verdict.INCOMPLETE and not unjudged):
        text = _listed(list(record.missing) or ["the run did not finish"])
        yield Banner(style=LOOKS[Verdict.INCOMPLETE].style, heading="Incomplete:", text=text)


def conformity(record: RunRecord) -> str:
    """The statement of conformity."""
    tested = "The unit identified above was tested to the specification named above."
    told = _CONFORMITY[record.verdict]
    if record.verdict is Verdict.PASS and not judged(record):
        told = "No result was held against a limit."
    return f"{tested} {told} The results relate only to the item tested, in the condition received."


def decision_rules(record: RunRecord) -> tuple[str, ...]:
    """Each rule that was used, and for which results where there are several."""
    rules = _rules(record)
    if len(rules) < 2:
        return tuple(_RULES[rule] for rule in rules)
    return tuple(f"{_RULES[rule]} Applied to: {_labels(record, rule)}." for rule in rules)


def uncertainty(record: RunRecord) -> str:
    """How the uncertainties are to be read, and what they leave out."""
    text = (
        "± is the expanded uncertainty U = k·u by JCGM 100 (GUM): the combined standard uncertainty times "
        "Student's t for 95.45 % coverage at the effective degrees of freedom. Square brackets are 95 % "
        "intervals, which need not lie evenly about the value. ≤ marks an upper bound, ≥ a lower one."
    )
    left_out = list(dict.fromkeys(name for result in record.results for name in result.not_included))
    return f"{text} Not included: {', '.join(left_out)}." if left_out else text


def deviations(record: RunRecord) -> tuple[str, ...]:
    """Everything that differs from a plain run of the plan."""
    return tuple(dict.fromkeys(_deviations(record)))


def remarks(record: RunRecord) -> tuple[str, ...]:
    """What is to be known of the acquisitions, without being a deviation."""
    return tuple(_of_items(record, lambda attempt: attempt.remarks))


def _deviations(record: RunRecord) -> Iterator[str]:
    header = record.header
    yield from header.deviations
    yield from _calibrations(record)
    for item in record.items:
        yield from _of_item(item)
    yield from _of_items(record, lambda attempt: attempt.events)


def _calibrations(record: RunRecord) -> Iterator[str]:
    if record.simulated or record.replayed:
        return
    day = record.header.started_utc.date()
    for name, instrument in instruments_used(record).items():
        if is_unit(record, name):
            continue
        if instrument.calibration is None:
            yield f"instrument '{name}': calibration not stated"
        elif instrument.calibration.due < day:
            yield f"instrument '{name}': calibration was due on {instrument.calibration.due}"


def _of_item(item: ItemRecord) -> Iterator[str]:
    name = item.plan.name
    for attempt in item.attempts:
        recording = attempt.recording
        for gap in recording.gaps if recording else ():
            yield f"{name}: {gap.missing} samples missing after sample {gap.after} ({gap.reason})"
        if recording and recording.flagged:
            yield f"{name}: {recording.flagged} samples flagged as overload or not a number"
    if len(item.attempts) > 1:
        yield f"{name}: attempt {len(item.attempts)} counts; earlier attempts are listed"


def _of_items(record: RunRecord, texts: Callable[[Attempt], tuple[str, ...]]) -> Iterator[str]:
    """What is said of items; the same of several is said once."""
    said: dict[str, list[PlannedItem]] = {}
    for item in record.items:
        for text in dict.fromkeys(text for attempt in item.attempts for text in texts(attempt)):
            said.setdefault(text, []).append(item.plan)
    yield from (f"{_named(plans)}: {text}" for text, plans in said.items())


def _named(plans: list[PlannedItem]) -> str:
    if len(plans) == 1:
        return plans[0].name
    cases: dict[str, list[int | None]] = {}
    for plan in plans:
        cases.setdefault(plan.case, []).append(plan.repeat)
    return "; ".join(f"{case}, {_repeats(repeats)}" for case, repeats in cases.items())


def _repeats(repeats: list[int | None]) -> str:
    numbers = [one for one in repeats if one is not None]
    parts = [f"repeat{'s' * (len(numbers) > 1)} {numbers_in_words(numbers)}"] if numbers else []
    return " and ".join((*parts, "over the repeats") if None in repeats else parts)


def _rules(record: RunRecord) -> list[DecisionRule]:
    used = {result.limit.decision for result in record.results if result.limit}
    return [rule for rule in DecisionRule if rule in used]


def _labels(record: RunRecord, rule: DecisionRule) -> str:
    chosen = [one.label for one in record.results if one.limit and one.limit.decision is rule]
    return "; ".join(dict.fromkeys(chosen))


def _listed(texts: list[str]) -> str:
    more = f"; and {len(texts) - _NAMED} more" if len(texts) > _NAMED else ""
    return "; ".join(texts[:_NAMED]) + more + "."


def _items(count: int) -> str:
    return "1 item" if count == 1 else f"{count} items"
