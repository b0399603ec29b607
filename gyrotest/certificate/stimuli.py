"""What moved and heated the unit: rates, vibration and temperatures asked for, and how far off they were."""

from collections.abc import Callable, Iterator, Sequence

from gyrotest.certificate.numbers import plain, significant
from gyrotest.certificate.printing import printed_text
from gyrotest.records.recording import Dwell
from gyrotest.records.run import RunRecord
from gyrotest.records.station import Instrument, Motion

_FEW = 12  # levels up to which each is printed; mirrored ones with both signs at once


def stimuli(record: RunRecord) -> Iterator[str]:
    """Tell of the rate table, of the vibration, of the temperature chamber, as far as they were used."""
    yield from _table(record)
    yield from _vibration(record)
    yield from _chamber(record)


def _table(record: RunRecord) -> Iterator[str]:
    slot = record.header.station.station.slots.get(record.header.slot)
    instrument = _instrument(record, slot.table if slot else None)
    turned = _courses(record, lambda one: one.rate_dps, lambda one: one.measured_rate_dps, "°/s")
    held = _courses(record, lambda one: one.position_deg, lambda one: one.measured_position_deg, "°")
    told = [f"Rates asked for in {case}: {course}." for case, course in turned]
    told += [f"Angles asked for in {case}: {course}." for case, course in held]
    if told and slot and instrument:
        kind = "Rate table" if instrument.shaft is None else "Rotation stage"
        yield f"{kind} '{slot.table}' ({instrument.driver}){_motion(instrument.motion)}."
    yield from told


def _vibration(record: RunRecord) -> Iterator[str]:
    slot = record.header.station.station.slots.get(record.header.slot)
    instrument = _instrument(record, slot.vibration if slot else None)
    vibrated = [
        (case, [one for one in held if one.vibration_dps])
        for case, held in _dwells(record, lambda one: one.vibration_dps).items()
    ]
    for number, (case, moved) in enumerate((case, moved) for case, moved in vibrated if moved):
        if slot and instrument and number == 0:
            yield f"Vibration table, driven by '{slot.vibration}' ({instrument.driver})."
        levels = _levels([one.vibration_dps for one in moved], "°/s")
        yield f"Vibration asked for in {case}: {levels} root mean square, {_frequencies(moved)}."


def _frequencies(moved: Sequence[Dwell]) -> str:
    """Say between which frequencies, or at which, and how often."""
    bands = sorted({one.band_hz for one in moved if one.band_hz})
    sines = [one.frequency_hz for one in moved if one.frequency_hz is not None]
    parts = [f"from {plain(low)} to {plain(high)} Hz" for low, high in bands]
    if sines:
        parts.append(f"sines of {_levels(sines, 'Hz')}")
    return ", ".join((*parts, f"{len(moved)} times")) if bands and len(moved) > 1 else ", ".join(parts)


def _chamber(record: RunRecord) -> Iterator[str]:
    slot = record.header.station.station.slots.get(record.header.slot)
    instrument = _instrument(record, slot.chamber if slot else None)
    courses = _courses(
        record, lambda one: one.temperature_degc, lambda one: one.measured_temperature_degc, "°C"
    )
    for number, (case, course) in enumerate(courses):
        if slot and instrument and number == 0:
            yield f"Temperature chamber '{slot.chamber}' ({instrument.driver})."
        yield f"Temperatures asked for in {case}: {course}."


def _courses(
    record: RunRecord,
    asked: Callable[[Dwell], float | None],
    found: Callable[[Dwell], float | None],
    unit: str,
) -> Iterator[tuple[str, str]]:
    """Of each case with such a stimulus: what was asked for, and how far off it was at most."""
    for case, all_of_it in _dwells(record, asked).items():
        if all_of_it:
            levels = _levels([asked(one) for one in all_of_it], unit)
            yield case, f"{levels}{_off(all_of_it, asked, found, unit)}"


def _dwells(record: RunRecord, asked: Callable[[Dwell], float | None]) -> dict[str, list[Dwell]]:
    """Of each case the dwells for which such a thing was asked for."""
    dwells: dict[str, list[Dwell]] = {}
    for item in record.items:
        for attempt in item.attempts:
            held = attempt.recording.dwells if attempt.recording else ()
            dwells.setdefault(item.plan.case, []).extend(one for one in held if asked(one) is not None)
    return dwells


def _levels(values: Sequence[float | None], unit: str) -> str:
    levels = sorted({one for one in values if one is not None})
    if len(levels) <= _FEW:
        return f"{', '.join(plain(one) for one in levels)} {unit}"
    if len(levels) <= 2 * _FEW and _mirrored(levels):
        rest = "0, " if 0.0 in levels else ""
        return f"{rest}{', '.join(f'±{plain(one)}' for one in levels if one > 0)} {unit}"
    return f"{plain(levels[0])} … {plain(levels[-1])} {unit} in {len(levels)} levels"


def _mirrored(levels: Sequence[float]) -> bool:
    return {-one for one in levels} == set(levels)


def _off(
    held: Sequence[Dwell],
    asked: Callable[[Dwell], float | None],
    found: Callable[[Dwell], float | None],
    unit: str,
) -> str:
    pairs = [(asked(one), found(one)) for one in held]
    errors = [abs(b - a) for a, b in pairs if a is not None and b is not None]
    if not errors:
        return ""
    return f"; read back within {significant(max(errors), digits=2)} {unit} of that"


def _motion(motion: Motion | None) -> str:
    if motion is None:
        return ""
    turns = ""
    if motion.slip_ring:
        turns = ", with a slip ring"
    elif motion.max_turns is not None:
        turns = f", {plain(motion.max_turns)} turn{'' if motion.max_turns == 1 else 's'} either way"
    most = printed_text(f"{motion.max_rate}, {motion.max_acceleration}").replace("/s/s", "/s²")
    return f": at most {most}{turns}"


def _instrument(record: RunRecord, name: str | None) -> Instrument | None:
    return record.header.station.station.instruments.get(name) if name else None
