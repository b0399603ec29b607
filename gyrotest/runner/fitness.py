"""Whether a station can carry out a spec: its slots, and what turns, powers and soaks the units there."""

from collections.abc import Iterator

from gyrotest.errors import RefusedError
from gyrotest.records.plan import Plan
from gyrotest.records.spec import Spec
from gyrotest.records.station import Slot, Station
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
            text for slot in slots for text in _plan_faults(plan, station, slot, station.slots[slot])
        )
    ]
    if faults:
        raise RefusedError("\n".join(faults))


def _plan_faults(plan: Plan, station: Station, name: str, slot: Slot) -> Iterator[str]:
    if plan.turns:
        yield from _turning_faults(plan, station, name, slot)
    if plan.soaks and slot.chamber is None:
        yield (
            f"needs a temperature chamber, and slot '{name}' of station '{station.name}' names none;"
            " give the slot a 'chamber', or choose another station by --gyro-station"
        )


def _turning_faults(plan: Plan, station: Station, name: str, slot: Slot) -> Iterator[str]:
    if slot.table is None:
        yield (
            f"turns the unit on a rate table, and slot '{name}' of station '{station.name}' names none;"
            " give the slot a 'table', or choose another station by --gyro-station"
        )
        return
    motion = station.instruments[slot.table].motion
    if motion is None:
        yield (
            f"instrument '{slot.table}' has no 'motion': state how fast and how far it may turn, e.g."
            " {max_rate: 200 deg/s, max_acceleration: 100 deg/s/s, slip_ring: true}"
        )
        return
    from gyrotest.acquisition.turning import motion_faults

    yield from motion_faults(plan, motion)
