"""Whether a station can carry out a spec: its slots, and what turns, powers and soaks the units there."""

from collections.abc import Iterator

from gyrotest.errors import RefusedError
from gyrotest.ports import Playback, SyncDaq
from gyrotest.records.plan import Plan, Rotating
from gyrotest.records.spec import Spec
from gyrotest.records.station import Instrument, Slot, Station
from gyrotest.registry import INSTRUMENTS, load
from gyrotest.runner.items import planned_case
from gyrotest.runner.places import slots_of


def check_fitness(spec: Spec, station: Station) -> None:
    """Refuse a spec that the station cannot carry out, before anything moves; raises `RefusedError`."""
    slots = slots_of(spec, station)
    if not slots:
        raise RefusedError(
            f"station '{station.name}' has no slot for a {spec.model}: every slot names other models"
            f" ({', '.join(sorted({one for slot in station.slots.values() for one in slot.models}))});"
            " add a slot, or the model to a slot's 'models'"
        )
    faults = [
        f"{case}: {fault}"
        for case, plan in ((name, planned_case(name, spec).plan) for name in spec.cases)
        for fault in dict.fromkeys(
            text for slot in slots for text in plan_faults(plan, station, slot, station.slots[slot])
        )
    ]
    if faults:
        raise RefusedError("\n".join(faults))


def plan_faults(plan: Plan, station: Station, name: str, slot: Slot) -> Iterator[str]:
    """What a slot of a station lacks for a plan, and what its instruments cannot do of it."""
    if plan.rotates:
        yield from _rotating_faults(plan, station, name, slot)
    elif plan.turns:
        yield from _turning_faults(plan, station, name, slot)
    if plan.soaks and slot.chamber is None:
        yield (
            f"needs a temperature chamber, and slot '{name}' of station '{station.name}' names none;"
            " give the slot a 'chamber', or choose another station by --gyro-station"
        )
    if plan.vibrates:
        yield from _vibrating_faults(plan, station, name, slot)


def _turning_faults(plan: Plan, station: Station, name: str, slot: Slot) -> Iterator[str]:
    if slot.table is None:
        yield (
            f"turns the unit on a rate table, and slot '{name}' of station '{station.name}' names none;"
            " give the slot a 'table', or choose another station by --gyro-station"
        )
        return
    motion = station.instruments[slot.table].motion
    if motion is None:
        yield _no_motion(slot.table, "slip_ring: true")
        return
    from gyrotest.acquisition.turning import motion_faults

    yield from motion_faults(plan, motion)


def _rotating_faults(plan: Plan, station: Station, name: str, slot: Slot) -> Iterator[str]:
    place = f"slot '{name}' of station '{station.name}'"
    if slot.table is None:
        yield (
            f"turns the unit in gravity on a stage with a level shaft, and {place} names none; give the slot a"
            " 'table' that has a 'shaft', or choose another station by --gyro-station"
        )
    else:
        yield from _shaft_faults(station.instruments[slot.table], slot.table)
    if station.site is None:
        yield (
            f"needs the Earth's rate and gravity, and station '{station.name}' does not say where it stands; give"
            " it a 'site', e.g. {latitude: 48.1 deg}"
        )
    if slot.encoder is None and any(isinstance(step.stimulus, Rotating) for step in plan.steps):
        yield (
            f"reads the stage's angle beside the gyro, and {place} has no encoder; give it an 'encoder', e.g."
            " {angle: angle}"
        )
    if any(isinstance(step.stimulus, Rotating) for step in plan.steps):
        yield from _asynchronous_faults(station, place, slot)
    yield from _mounting_faults(plan, slot, place)
    motion = station.instruments[slot.table].motion if slot.table is not None else None
    if motion is None:
        if slot.table is not None:
            yield _no_motion(slot.table, "max_turns: 1")
        return
    from gyrotest.acquisition.rotation_limits import rotation_faults
    from gyrotest.acquisition.turning import motion_faults

    yield from motion_faults(plan, motion)
    yield from rotation_faults(plan, motion)


def _shaft_faults(stage: Instrument, name: str) -> Iterator[str]:
    """What is not said of a stage's shaft and must be known."""
    if stage.shaft is None:
        yield (
            f"turns the unit in gravity on a level shaft, and instrument '{name}' has no 'shaft'; state how it"
            " lies, e.g. {azimuth: 37 deg, azimuth_uncertainty: 1 deg}, or choose another station by"
            " --gyro-station"
        )
    elif stage.shaft.azimuth is None:
        yield (
            f"needs the Earth's rate along what turns, and the shaft of instrument '{name}' has no 'azimuth';"
            " state where the stage's x axis points at angle 0, clockwise from true north, e.g. azimuth: 37 deg"
        )


def _mounting_faults(plan: Plan, slot: Slot, place: str) -> Iterator[str]:
    """Turned about its sensitive axis a unit has that axis where the slot's frame puts it, in every mounting."""
    for axis in sorted({one.sensitive_axis for one in plan.placements}):
        if slot.frame.get(axis) in {"y", "-y"}:
            yield (
                f"{place} puts the sensitive axis {axis} along the shaft ('frame'), where it feels no gravity that"
                " turns; it must lie across it: correct the frame, or the case's 'parameters.sensitive_axis'"
            )


def _no_motion(table: str, turns: str) -> str:
    return (
        f"instrument '{table}' has no 'motion': state how fast and how far it may turn, e.g."
        f" {{max_rate: 200 deg/s, max_acceleration: 100 deg/s/s, {turns}}}"
    )


def _vibrating_faults(plan: Plan, station: Station, name: str, slot: Slot) -> Iterator[str]:
    place = f"slot '{name}' of station '{station.name}'"
    if slot.encoder is None:
        yield (
            f"vibrates the unit against the angle of the table that carries it, and {place} has no encoder; give"
            " it an 'encoder', e.g. {sine: ua, cosine: ub, lines: 9000}, or choose another station by"
            " --gyro-station"
        )
    yield from _asynchronous_faults(station, place, slot)
    if issubclass(load(INSTRUMENTS, station.instruments[slot.source].driver), Playback):
        return
    if slot.vibration is not None:
        yield from _drive_faults(plan, station, slot.vibration)
    elif station.simulation is not None:
        yield (
            f"vibrates the unit, and {place}, a simulated one, has nothing that drives a vibration table; give the"
            " slot a 'vibration', e.g. an instrument with the driver keysight33500b"
        )


def _asynchronous_faults(station: Station, place: str, slot: Slot) -> Iterator[str]:
    """Whether output and encoder are sampled by one clock; of what is played back the file tells."""
    source = station.instruments[slot.source]
    driver = load(INSTRUMENTS, source.driver)
    if not issubclass(driver, Playback) and not issubclass(driver, SyncDaq):
        yield (
            f"needs the gyro's output and the encoder sampled at the same instants, and the source '{slot.source}'"
            f" ({source.driver}) of {place} does not do that; read both by a synchronous source, e.g. sync_stream"
        )


def _drive_faults(plan: Plan, station: Station, name: str) -> Iterator[str]:
    from gyrotest.acquisition.vibrating import VibrationLimits, vibration_faults
    from gyrotest.specification.station import instrument_settings

    instrument = station.instruments[name]
    driver = load(INSTRUMENTS, instrument.driver)
    if not hasattr(driver, "random"):
        yield (
            f"vibrates the unit, and the instrument '{name}' ({instrument.driver}) does not drive a vibration"
            " table; name one that does as the slot's 'vibration', e.g. with the driver keysight33500b"
        )
        return
    limits = instrument_settings(instrument, driver)
    if isinstance(limits, VibrationLimits):
        yield from vibration_faults(plan, limits)
