"""With what was measured: the instruments that were used, and who answered there."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

from gyrotest.records.recording import Identity
from gyrotest.records.run import InstrumentUse, RunRecord
from gyrotest.records.spec import OutputKind
from gyrotest.records.station import Calibration, Instrument

NOT_STATED = "not stated"
_NOT_APPLICABLE = "–"


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


def equipment(record: RunRecord) -> tuple[Equipment, ...]:
    """List every instrument that was used, once for each identity found there."""
    return tuple(_equipment(record))


def instruments_used(record: RunRecord) -> Mapping[str, Instrument]:
    """Return what read, turned, fed or heated the unit; of an unknown slot all of the station."""
    station = record.header.station.station
    slot = station.slots.get(record.header.slot)
    if slot is None:
        return station.instruments
    attempts = [one for item in record.items for one in item.attempts]
    dwells = [held for one in attempts if one.recording for held in one.recording.dwells]
    wanted = {slot.source, *(use.name for one in attempts for use in one.instruments)}
    if record.header.spec.spec.supply is not None:
        wanted.add(slot.supply or "")
    if any(one.rate_dps is not None for one in dwells):
        wanted.add(slot.table or "")
    if any(one.temperature_degc is not None for one in dwells):
        wanted.add(slot.chamber or "")
    return {name: one for name, one in station.instruments.items() if name in wanted}


def is_unit(record: RunRecord, name: str) -> bool:
    """Whether an instrument of the station is the unit under test itself: a gyro that speaks for itself."""
    slot = record.header.station.station.slots.get(record.header.slot)
    spoken = record.header.spec.spec.output.kind is not OutputKind.VOLTAGE
    return spoken and not record.replayed and slot is not None and slot.source == name


def _equipment(record: RunRecord) -> Iterator[Equipment]:
    uses = [use for item in record.items for attempt in item.attempts for use in attempt.instruments]
    station = record.header.station.station
    for name, instrument in instruments_used(record).items():
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
    unit = is_unit(record, name)
    absent = _NOT_APPLICABLE if unit else NOT_STATED
    made_by = f"{identity.manufacturer} {identity.model}".strip() if identity else NOT_STATED
    expected = instrument.serial_number if instrument else None
    return Equipment(
        name=f"{name} ({instrument.driver})" if instrument else name,
        made_by=f"{made_by}, the unit under test" if unit else made_by,
        serial_number=(identity.serial_number if identity else expected) or NOT_STATED,
        asset=(instrument.asset if instrument else "") or absent,
        certificate=calibration.certificate if calibration else absent,
        calibrated=str(calibration.date) if calibration else absent,
        due=str(calibration.due) if calibration else absent,
        overdue=_overdue(record, calibration),
        traceable_to=(calibration.traceable_to if calibration else "") or absent,
    )


def _overdue(record: RunRecord, calibration: Calibration | None) -> bool:
    return calibration is not None and calibration.due < record.header.started_utc.date()
