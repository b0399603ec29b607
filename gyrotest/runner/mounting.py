"""How units are mounted on the bench, and what the operator is asked to change before an acquisition."""

from collections.abc import Mapping

from gyrotest.records.plan import Placement
from gyrotest.records.run import Attempt, Outcome, RunHeader
from gyrotest.records.spec import Case
from gyrotest.runner.folder import RunFolder
from gyrotest.runner.items import planned_case

_TAKEN = {Outcome.PASSED, Outcome.FAILED, Outcome.ACQUIRED}


class Mounted:
    """How the unit in each slot was mounted last, in this process."""

    def __init__(self) -> None:
        self._by_slot: dict[str, tuple[str, float]] = {}

    def turned_deg(self, slot: str, serial_number: str) -> float | None:
        """By how much a unit is turned from how its slot describes it; None where nothing was done yet."""
        found, turned_deg = self._by_slot.get(slot, ("", 0.0))
        return turned_deg if found == serial_number else None

    def put(self, slot: str, serial_number: str, turned_deg: float) -> None:
        """It is mounted so."""
        self._by_slot[slot] = (serial_number, turned_deg)


def mountings(case: Case | None) -> Mapping[str, tuple[float, float, float]]:
    """The directions of a case's axes by name; that of a single axis under no name."""
    if case is None:
        return {}
    if case.mounting is not None:
        return {"": case.mounting}
    return case.mountings


def turned_before_deg(folder: RunFolder, header: RunHeader) -> float:
    """How a unit was mounted when it was acquired last by its run's record; 0 before the first time."""
    last: tuple[Attempt, Placement] | None = None
    for item in header.plan:
        placement = planned_case(item.case, header.spec.spec).plan.placement(item.repeat)
        if placement is None:
            continue
        for attempt in folder.attempts(item.name):
            if attempt.outcome in _TAKEN and (last is None or attempt.ended_utc > last[0].ended_utc):
                last = (attempt, placement)
    return last[1].turned_deg if last is not None else 0.0


def mounted_words(placement: Placement) -> str:
    """How a unit is mounted, in words."""
    turned_deg, axis = placement.turned_deg, placement.sensitive_axis
    if turned_deg == 0.0:
        return f"as its slot describes it (turned by 0° about its own {axis} axis)"
    return f"turned by {turned_deg:g}° about its own {axis} axis"


def remounting_words(units: Mapping[str, str], placement: Placement, *, safe: str) -> str:
    """What the operator is asked for: units by their slots; `safe` says why a hand may touch them."""
    named = " and ".join(f"unit {serial} in slot '{slot}'" for slot, serial in units.items())
    return (
        f"{safe}the power stays on. Mount {named} {mounted_words(placement)}; angles count right-handed about that"
        " axis, from the mounting that the slot describes"
    )
