"""Where a spec's units go: the slots of the station that carry what the spec needs."""

from gyrotest.records.plan import Plan
from gyrotest.records.spec import Spec
from gyrotest.records.station import Slot, Station
from gyrotest.runner.items import planned_case


def moved_together(plan: Plan, one: Slot, other: Slot) -> bool:
    """Whether what a plan does to the unit in a slot happens to the one in another slot as well."""
    return (
        (not plan.turns or one.table == other.table)
        and (not plan.vibrates or one.vibration == other.vibration)
        and (not plan.soaks or one.chamber == other.chamber)
    )


def slots_of(spec: Spec, station: Station) -> tuple[str, ...]:
    """The slots that a spec's units take, in the order of their serial numbers."""
    plans: list[Plan] = [planned_case(name, spec).plan for name in spec.cases]
    return station.slots_for(
        spec.model,
        vibrates=any(one.vibrates for one in plans),
        rotates=any(one.rotates for one in plans),
    )
