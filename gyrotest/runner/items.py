"""What a run owes: its items in order, and when in a power-on each one starts."""

from collections.abc import Iterator
from dataclasses import dataclass

from gyrotest.ports import Procedure
from gyrotest.records.plan import Plan
from gyrotest.records.result import Measurand
from gyrotest.records.run import PlannedItem
from gyrotest.records.spec import Between, Case, Over, Spec
from gyrotest.registry import PROCEDURES, load
from gyrotest.specification.spec import case_parameters


@dataclass(frozen=True, slots=True, kw_only=True)
class PlannedCase:
    """A case with its procedure, its checked parameters and the acquisition of one repeat."""

    name: str
    case: Case
    procedure: Procedure
    parameters: object
    plan: Plan
    measurands: tuple[Measurand, ...]

    def measured(self, over: Over | None) -> tuple[Measurand, ...]:
        """The measurands of one acquisition (None), or those over the repeats."""
        return tuple(one for one in self.measurands if one.over == over)


def planned_case(name: str, spec: Spec) -> PlannedCase:
    """Resolve the procedure of a spec's case."""
    case = spec.cases[name]
    procedure: Procedure = load(PROCEDURES, case.procedure)()
    parameters = case_parameters(case, procedure)
    return PlannedCase(
        name=name,
        case=case,
        procedure=procedure,
        parameters=parameters,
        plan=procedure.plan(case, parameters),
        measurands=tuple(procedure.measurands(case, parameters, spec.output)),
    )


def planned_items(spec: Spec, serial_number: str) -> tuple[PlannedItem, ...]:
    """Every item that a run of the spec owes for a serial number, in order."""
    return tuple(
        PlannedItem(name=f"{name}-{serial_number}-{suffix}", case=name, repeat=repeat)
        for name in spec.cases
        for repeat, suffix in _suffixes(planned_case(name, spec))
    )


def _suffixes(planned: PlannedCase) -> Iterator[tuple[int | None, str]]:
    for repeat in range(1, planned.case.repeats + 1):
        yield repeat, f"r{repeat}"
    if planned.case.repeats > 1 and planned.measured(Over.REPEATS):
        yield None, "repeats"


@dataclass(frozen=True, slots=True, kw_only=True)
class Moment:
    """When an acquisition starts by the plan.

    In which power-on (1 …), how long after it, and how much was acquired before it, s.
    """

    power_cycle: int
    elapsed_s: float
    acquired_s: float = 0.0


def moment(spec: Spec, wanted: PlannedItem) -> Moment:
    """The planned start of an acquisition in a full run of the spec."""
    power_cycle, elapsed_s, acquired_s = 1, 0.0, 0.0
    for name, case in spec.cases.items():
        plan = planned_case(name, spec).plan
        for repeat in range(1, case.repeats + 1):
            if case.between_repeats is Between.POWER_CYCLE and repeat > 1:
                power_cycle, elapsed_s = power_cycle + 1, 0.0
            elapsed_s = max(elapsed_s, plan.warm_up_s)
            if (name, repeat) == (wanted.case, wanted.repeat):
                break
            elapsed_s += plan.duration_s
            acquired_s += plan.duration_s
        else:
            continue
        break
    return Moment(power_cycle=power_cycle, elapsed_s=elapsed_s, acquired_s=acquired_s)
