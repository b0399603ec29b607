"""What stands behind the results: equipment, uncertainty budgets, attempts, and hashes of the data."""

import math
from collections.abc import Iterator
from dataclasses import dataclass

from gyrotest.certificate.numbers import plain, significant
from gyrotest.records.recording import Identity
from gyrotest.records.result import Contribution, JudgedResult
from gyrotest.records.run import InstrumentUse, Outcome, RunRecord
from gyrotest.records.station import Instrument
from gyrotest.units import printed_unit

NOT_STATED = "not stated"


@dataclass(frozen=True, slots=True, kw_only=True)
class Equipment:
    """An instrument of the station, and who answered there."""

    name: str
    made_by: str
    serial_number: str
    asset: str
    certificate: str
    calibrated: str
    due: str
    overdue: bool
    traceable_to: str


@dataclass(frozen=True, slots=True, kw_only=True)
class BudgetLine:
    """A contribution, its number rounded like the others of its budget."""

    source: str
    kind: str
    distribution: str
    half_width: str
    sensitivity: str
    degrees_of_freedom: str
    standard_uncertainty: str


@dataclass(frozen=True, slots=True, kw_only=True)
class Budget:
    """The uncertainty budget of a result; `others` tells what the other repeats gave."""

    label: str
    unit: str
    lines: tuple[BudgetLine, ...]
    combined: str
    expanded: str
    factor: str
    others: str
    not_included: str


@dataclass(frozen=True, slots=True, kw_only=True)
class AttemptLine:
    """One try at an item."""

    item: str
    number: int
    outcome: str
    begun: str
    ended: str
    message: str


@dataclass(frozen=True, slots=True, kw_only=True)
class RecordingLine:
    """A file of raw data."""

    path: str
    samples: str
    missing: str
    sha256: str


def equipment(record: RunRecord) -> tuple[Equipment, ...]:
    """List every instrument of the station, once for each identity found there."""
    return tuple(_equipment(record))


def budgets(record: RunRecord) -> tuple[Budget, ...]:
    """Give the budget of the first repeat of each result that has one."""
    chosen: dict[tuple[str, str], list[JudgedResult]] = {}
    for result in record.results:
        if result.budget:
            chosen.setdefault((result.case, result.name), []).append(result)
    several = len({case for case, _ in chosen}) > 1
    return tuple(_budget(results, named=several) for results in chosen.values())


def attempts(record: RunRecord) -> tuple[AttemptLine, ...]:
    """List all attempts where an item needed more than one, or one of them did not finish."""
    unfinished = {Outcome.ERROR, Outcome.INTERRUPTED, Outcome.SKIPPED}
    telling = any(
        len(item.attempts) > 1 or any(one.outcome in unfinished for one in item.attempts)
        for item in record.items
    )
    return tuple(
        AttemptLine(
            item=item.plan.name,
            number=attempt.number,
            outcome=attempt.outcome.value,
            begun=f"{attempt.started_utc:%Y-%m-%d %H:%M:%S}",
            ended=f"{attempt.ended_utc:%Y-%m-%d %H:%M:%S}",
            message=attempt.message,
        )
        for item in record.items
        for attempt in item.attempts
        if telling
    )


def recordings(record: RunRecord) -> tuple[RecordingLine, ...]:
    """List the raw data of all attempts."""
    files = [one.recording for item in record.items for one in item.attempts if one.recording]
    return tuple(
        RecordingLine(
            path=one.path,
            samples=f"{plain(one.samples)} of {plain(one.header.planned_samples)}",
            missing=plain(sum(gap.missing for gap in one.gaps)),
            sha256=one.sha256 or "not closed",
        )
        for one in files
    )


def sampling(record: RunRecord) -> tuple[str, ...]:
    """How the source sampled, each way once, with what dead time there was."""
    files = [one.recording for item in record.items for one in item.attempts if one.recording]
    # How long a replayed file's samples were integrated for is not known.
    ways = dict.fromkeys(one.header.sampling for one in files if not one.header.source.replayed)
    return tuple(
        f"One sample every {plain(way.interval_s)} s is the mean of {way.readings} reading"
        f"{'' if way.readings == 1 else 's'} of {plain(way.aperture_s * 1000, digits=4)} ms: the signal is "
        f"integrated for {plain(100 * way.duty, digits=3)} % of the time."
        + (
            " White noise read through the dead time is folded; see the results' conditions."
            * (way.duty < 0.999)
        )
        for way in ways
    )


def _equipment(record: RunRecord) -> Iterator[Equipment]:
    uses = [use for item in record.items for attempt in item.attempts for use in attempt.instruments]
    station = record.header.station.station
    for name, instrument in station.instruments.items():
        found = list(dict.fromkeys(use.identity for use in uses if use.name == name))
        if not found:
            yield _entry(record, name, instrument, None)
        for identity in found:
            yield _entry(record, name, instrument, identity)
    strangers: dict[str, InstrumentUse] = {
        use.name: use for use in uses if use.name not in station.instruments
    }
    for name, use in strangers.items():
        yield _entry(record, name, None, use.identity)


def _entry(
    record: RunRecord, name: str, instrument: Instrument | None, identity: Identity | None
) -> Equipment:
    calibration = instrument.calibration if instrument else None
    made_by = f"{identity.manufacturer} {identity.model}".strip() if identity else "not used"
    expected = instrument.serial_number if instrument else None
    return Equipment(
        name=f"{name} ({instrument.driver})" if instrument else name,
        made_by=made_by,
        serial_number=(identity.serial_number if identity else expected) or NOT_STATED,
        asset=(instrument.asset if instrument else "") or NOT_STATED,
        certificate=calibration.certificate if calibration else NOT_STATED,
        calibrated=str(calibration.date) if calibration else NOT_STATED,
        due=str(calibration.due) if calibration else NOT_STATED,
        overdue=calibration is not None and calibration.due < record.header.started_utc.date(),
        traceable_to=(calibration.traceable_to if calibration else "") or NOT_STATED,
    )


def _budget(results: list[JudgedResult], *, named: bool) -> Budget:
    first = results[0]
    combined = _combined(first.budget)
    label = f"{first.label} ({first.case})" if named else first.label
    which = f", repeat {first.repeat}" if len(results) > 1 and first.repeat is not None else ""
    return Budget(
        label=label[:1].lower() + label[1:] + which,
        unit=printed_unit(first.unit),
        lines=tuple(_line(one) for one in first.budget),
        combined=significant(combined, digits=2),
        expanded=""
        if first.expanded_uncertainty is None
        else significant(first.expanded_uncertainty, digits=2),
        factor="" if first.coverage_factor is None else f"{first.coverage_factor:.2f}",
        others=_others(results[1:]),
        not_included=", ".join(first.not_included),
    )


def _line(one: Contribution) -> BudgetLine:
    freedom = one.degrees_of_freedom
    return BudgetLine(
        source=one.source,
        kind=one.kind,
        distribution=one.distribution,
        half_width=one.half_width or "–",
        sensitivity=one.sensitivity or "–",
        degrees_of_freedom="∞" if freedom is None else plain(freedom, digits=3),
        standard_uncertainty=significant(one.standard_uncertainty, digits=2),
    )


def _others(results: list[JudgedResult]) -> str:
    told = (f"repeat {one.repeat}: {significant(_combined(one.budget), digits=2)}" for one in results)
    unit = printed_unit(results[0].unit) if results else ""
    return f"Combined, other repeats: {', '.join(told)} {unit}" if results else ""


def _combined(budget: tuple[Contribution, ...]) -> float:
    """The root sum of squares (JCGM 100 eq. 10)."""
    return math.sqrt(math.fsum(one.standard_uncertainty**2 for one in budget))
